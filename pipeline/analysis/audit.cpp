#include "analysis/audit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>

#include "analysis/follower_meter.hpp"
#include "core/parallel.hpp"
#include "core/text.hpp"

namespace vrda::analysis {
namespace {

/// A pose to measure, if the motion has one at the attitude.
struct AuditPose {
  Attitude attitude;
  Pose X_reference_moving = Pose::Identity();
  bool has_pose = false;
};

bool is_node(const store::AuditSet& out, Eigen::Index i, Eigen::Index j)
{
  return i % out.refine == 0 && j % out.refine == 0;
}

AuditPose pose_of(const store::JointPose& pose)
{
  return {pose.attitude, pose.X_reference_moving, pose.status == store::PoseStatus::solved};
}

AuditPose stored_pose(const store::MotionModel& model, Eigen::Index flexion, Eigen::Index varus)
{
  AuditPose pose;
  pose.has_pose = model.status(flexion, varus) == status_stable;
  if (!pose.has_pose) return pose;
  pose.attitude = {rad_from_deg(model.flexion_deg[static_cast<std::size_t>(flexion)]),
                   rad_from_deg(model.varus_solved_deg(flexion, varus))};
  const auto cell = static_cast<std::size_t>(flexion * model.status.cols() + varus);
  pose.X_reference_moving = store::pose_in(model.X_reference_moving, cell);
  return pose;
}

store::JointPose joint_pose_at(const store::Motion& motion, const store::AuditSet& out, Eigen::Index i,
                               Eigen::Index j)
{
  if (motion.is_sequence()) return motion.at_frame(out.frame_key[static_cast<std::size_t>(i)]);
  return motion.at({rad_from_deg(out.flexion_deg[static_cast<std::size_t>(i)]),
                    rad_from_deg(out.varus_deg[static_cast<std::size_t>(j)])});
}

AuditPose pose_at(const store::MotionModel& model, const store::Motion& motion, const store::AuditSet& out,
                  Eigen::Index i, Eigen::Index j)
{
  if (out.name == "raw" && is_node(out, i, j)) return stored_pose(model, i / out.refine, j / out.refine);
  return pose_of(joint_pose_at(motion, out, i, j));
}

template <typename Audit>
void set_state(Audit& out, Eigen::Index i, Eigen::Index j, const PoseAudit& found)
{
  out.penetration_mm(i, j) = found.penetration_mm;
  store::AuditState state = store::AuditState::free;
  if (found.is_overlapping) {
    state = store::AuditState::overlapping;
  } else if (std::isinf(found.gap_mm)) {
    state = store::AuditState::nothing_ahead;
  } else {
    out.gap_mm(i, j) = found.gap_mm;
  }
  out.state(i, j) = static_cast<std::int8_t>(state);
}

/// Flexion of each audited frame; between two frames without a pose there, the mean weighted by the key.
std::vector<double> flexion_of_frames(const store::MotionModel& model, const store::Motion& motion,
                                      const store::AuditSet& out)
{
  std::vector<double> flexion_deg;
  for (std::size_t i = 0; i < out.frame_key.size(); ++i) {
    const auto refine = static_cast<std::size_t>(out.refine);
    const std::size_t frame = i / refine;
    const double part = static_cast<double>(i % refine) / static_cast<double>(refine);
    const store::JointPose pose = motion.at_frame(out.frame_key[i]);
    if (part == 0.0) {
      flexion_deg.push_back(model.flexion_deg[frame]);
    } else if (pose.status == store::PoseStatus::solved) {
      flexion_deg.push_back(deg_from_rad(pose.attitude.flexion_rad));
    } else {
      flexion_deg.push_back((1.0 - part) * model.flexion_deg[frame] + part * model.flexion_deg[frame + 1]);
    }
  }
  return flexion_deg;
}

std::vector<Eigen::Vector3d> deltas_of(const store::Motion& motion, const store::AuditSet& out)
{
  std::vector<Eigen::Vector3d> deltas;
  for (const double key : out.frame_key) deltas.push_back(motion.delta_of(motion.at_frame(key)));
  if (motion.is_sequence()) return deltas;
  for (const double angle_deg : out.flexion_deg) deltas.push_back(motion.delta(rad_from_deg(angle_deg)));
  return deltas;
}

store::AuditSet unmeasured(const store::MotionModel& model, const store::Motion& motion,
                           const std::string& set, int refine)
{
  store::AuditSet out;
  out.name = set;
  out.refine = refine;
  const bool is_two_sided = set == "two_sided";
  if (motion.is_sequence()) {
    out.frame_key = refined(motion.keys(), refine);
    out.flexion_deg = flexion_of_frames(model, motion, out);
  } else {
    out.flexion_deg = refined(is_two_sided ? model.two_sided->flexion_deg : model.flexion_deg, refine);
  }
  out.varus_deg =
      is_two_sided || set == "zero_varus" ? std::vector<double>{0.0} : refined(model.varus_deg, refine);
  const auto rows = static_cast<Eigen::Index>(out.flexion_deg.size());
  const auto columns = static_cast<Eigen::Index>(out.varus_deg.size());
  out.state = store::GridB::Constant(rows, columns, static_cast<std::int8_t>(store::AuditState::no_pose));
  out.gap_mm = store::GridD::Constant(rows, columns, nan);
  out.penetration_mm = store::GridD::Constant(rows, columns, nan);
  if (model.has_compartments) out.compartment_gap_mm.fill(out.penetration_mm);
  return out;
}

void take_larger(AuditExtreme& extreme, const AuditExtreme& found)
{
  if (found.value_mm > extreme.value_mm) extreme = found;
}

store::FollowerAudit follower_audit(const store::MotionModel& model, const store::Motion& motion,
                                    const store::AuditSet& out, const store::FollowerRows& rows,
                                    int n_threads, OverlapTest at_grid)
{
  store::FollowerAudit found;
  found.name = rows.name;
  found.state = store::GridB::Constant(out.state.rows(), out.state.cols(),
                                       static_cast<std::int8_t>(store::AuditState::no_pose));
  found.gap_mm = found.penetration_mm = store::GridD::Constant(out.state.rows(), out.state.cols(), nan);
  const auto n = static_cast<std::size_t>(out.state.rows());
  for_each_follower_row(model, rows, n, n_threads, [&](std::size_t row, FollowerMeter& meter) {
    const auto i = static_cast<Eigen::Index>(row);
    for (Eigen::Index j = 0; j < out.state.cols(); ++j) {
      const store::JointPose pose = joint_pose_at(motion, out, i, j);
      std::optional<Pose> X_of = pose.X_of(rows);
      if (out.name == "raw" && is_node(out, i, j)) {
        const Eigen::Index cell = i / out.refine * rows.status.cols() + j / out.refine;
        X_of.reset();
        if (rows.status.data()[cell] == status_stable)
          X_of = store::pose_in(rows.X_of_follower, static_cast<std::size_t>(cell));
      }
      const OverlapTest judge = is_node(out, i, j) ? at_grid : OverlapTest::sweep;
      if (X_of) set_state(found, i, j, meter.measure(pose, *X_of, judge));
    }
  });
  return found;
}

}  // namespace

store::AuditSet audit_joint(const store::MotionModel& model, const std::string& set, int refine,
                            const Measuring& with, OverlapTest at_grid)
{
  check(refine >= 1, "an audit divides a cell into at least one part");
  const store::Motion motion(model, set);
  store::AuditSet out = unmeasured(model, motion, set, refine);
  for_each_delta(model, deltas_of(motion, out), with, [&](std::size_t row, PoseMeter& meter) {
    const auto i = static_cast<Eigen::Index>(row);
    for (Eigen::Index j = 0; j < out.state.cols(); ++j) {
      const AuditPose pose = pose_at(model, motion, out, i, j);
      const OverlapTest judge = is_node(out, i, j) ? at_grid : OverlapTest::sweep;
      if (!pose.has_pose) continue;
      set_state(out, i, j, meter.measure(pose.attitude, pose.X_reference_moving, judge));
      if (!model.has_compartments) continue;
      const CompartmentGaps gaps = meter.compartment_gaps(pose.attitude, pose.X_reference_moving);
      for (std::size_t side = 0; side < gaps.size(); ++side) out.compartment_gap_mm[side](i, j) = gaps[side];
    }
  });
  return out;
}

store::AuditSet audit(const store::MotionModel& model, const std::string& set, int refine,
                      const Measuring& with, OverlapTest at_grid)
{
  store::AuditSet out = audit_joint(model, set, refine, with, at_grid);
  if (model.followers.empty()) return out;
  const store::Motion motion(model, set);
  for (const store::FollowerRows& rows : model.followers)
    out.followers.push_back(follower_audit(model, motion, out, rows, with.n_threads, at_grid));
  return out;
}

namespace {

template <typename Audit>
AuditFigures measured_figures(const store::AuditSet& axes, const Audit& audit)
{
  AuditFigures figures;
  int n_free = 0;
  for (Eigen::Index i = 0; i < audit.state.rows(); ++i) {
    for (Eigen::Index j = 0; j < audit.state.cols(); ++j) {
      const auto state = static_cast<store::AuditState>(audit.state(i, j));
      if (state == store::AuditState::no_pose) continue;
      ++figures.n_poses;
      const double flexion_deg = axes.flexion_deg[static_cast<std::size_t>(i)];
      const double varus_deg = axes.varus_deg[static_cast<std::size_t>(j)];
      const double key = axes.frame_key.empty() ? nan : axes.frame_key[static_cast<std::size_t>(i)];
      if (state == store::AuditState::overlapping) {
        ++figures.n_overlapping;
        figures.mean_penetration_mm += audit.penetration_mm(i, j);
        take_larger(figures.largest_penetration, {audit.penetration_mm(i, j), flexion_deg, varus_deg, key});
      } else if (state == store::AuditState::nothing_ahead) {
        ++figures.n_nothing_ahead;
      } else {
        ++n_free;
        figures.mean_gap_mm += audit.gap_mm(i, j);
        take_larger(figures.largest_gap, {audit.gap_mm(i, j), flexion_deg, varus_deg, key});
      }
    }
  }
  if (n_free > 0) figures.mean_gap_mm /= n_free;
  if (figures.n_overlapping > 0) figures.mean_penetration_mm /= figures.n_overlapping;
  return figures;
}

}  // namespace

AuditFigures figures_of(const store::AuditSet& audit)
{
  AuditFigures figures = measured_figures(audit, audit);
  figures.two_sided = store::two_sided_figures(audit);
  return figures;
}

AuditFigures figures_of(const store::AuditSet& audit, const store::FollowerAudit& follower)
{
  return measured_figures(audit, follower);
}

FrameTravel frame_travel(const store::MotionModel& model)
{
  check(model.frames.has_value(), "only a sequence of frames has steps");
  FrameTravel travel;
  std::optional<Pose> before;
  for (std::size_t i = 0; i < model.frames->key.size(); ++i) {
    if (model.status.data()[i] != status_stable) continue;
    const Pose X = store::pose_in(model.X_reference_moving, i);
    if (before) {
      const Eigen::Vector3d& centre_mm = model.rotation_centre_mm;
      const double way_mm = (X * centre_mm - *before * centre_mm).norm();
      const std::optional<HelicalAxis> axis = helical_axis(*before, X, centre_mm);
      const double angle_rad = axis ? axis->rotation_rad : 0.0;
      if (way_mm > travel.largest_mm) travel.key_of_mm = model.frames->key[i];
      if (angle_rad > travel.largest_rad) travel.key_of_rad = model.frames->key[i];
      travel.largest_mm = std::max(travel.largest_mm, way_mm);
      travel.largest_rad = std::max(travel.largest_rad, angle_rad);
      travel.mean_mm += way_mm;
      travel.mean_rad += angle_rad;
      ++travel.n_steps;
    }
    before = X;
  }
  if (travel.n_steps == 0) return travel;
  travel.mean_mm /= travel.n_steps;
  travel.mean_rad /= travel.n_steps;
  return travel;
}

store::GridD recontact(const store::MotionModel& model, const store::SmoothedSet& set, const Measuring& with)
{
  store::SmoothedSet bare = set;
  bare.recontact_mm.reset();
  const store::Motion motion(model, bare);
  store::GridD travel_mm(static_cast<Eigen::Index>(model.flexion_deg.size()),
                         static_cast<Eigen::Index>(model.varus_deg.size()));
  for_each_row(model, motion, model.flexion_deg, with, [&](std::size_t row, PoseMeter& meter) {
    for (Eigen::Index j = 0; j < travel_mm.cols(); ++j) {
      const store::JointPose pose = motion.at(
          {rad_from_deg(model.flexion_deg[row]), rad_from_deg(model.varus_deg[static_cast<std::size_t>(j)])});
      travel_mm(static_cast<Eigen::Index>(row), j) =
          meter.travel_into_contact_mm(pose.attitude, pose.X_reference_moving);
    }
  });
  return travel_mm;
}

void add_recontact(const store::MotionModel& model, store::SmoothedSet& set, const Measuring& with)
{
  set.recontact_mm = recontact(model, set, with);
  if (set.followers.empty()) return;
  for (store::SmoothedFollower& follower : set.followers) follower.recontact_mm.reset();
  const store::Motion motion(model, set);
  for (store::SmoothedFollower& follower : set.followers) {
    const auto rows = std::find_if(model.followers.begin(), model.followers.end(),
                                   [&](const auto& other) { return other.name == follower.name; });
    check(rows != model.followers.end(), "a smoothed follower is one of the model");
    store::GridD travel_mm = store::GridD::Constant(set.recontact_mm->rows(), set.recontact_mm->cols(), nan);
    for_each_follower_row(model, *rows, model.flexion_deg.size(), with.n_threads,
                          [&](std::size_t row, FollowerMeter& meter) {
                            for (Eigen::Index j = 0; j < travel_mm.cols(); ++j) {
                              const store::JointPose pose =
                                  motion.at({rad_from_deg(model.flexion_deg[row]),
                                             rad_from_deg(model.varus_deg[static_cast<std::size_t>(j)])});
                              if (const std::optional<Pose> X_of = pose.X_of(*rows))
                                travel_mm(static_cast<Eigen::Index>(row), j) = meter.travel_mm(pose, *X_of);
                            }
                          });
    follower.recontact_mm = std::move(travel_mm);
  }
}

namespace {

// Tolerance on matrix elements of equal rotations: 1e-9 mm at a vertex one metre away.
constexpr double same_rotation = 1e-12;
// Above the rounding of a travel of a few metres.
constexpr double clear_mm = 1e-9;
// First retreat from an overlap, doubled until the objects are free. Far below the thickness of any part and
// above the displacement by smoothing, so that the contact found is the one that was passed.
constexpr double first_retreat_mm = 0.1;
// Growth factor of the margin until nothing overlaps; the limit is the largest gap that counts as contact.
constexpr double margin_growth = 8.0;
constexpr double largest_margin_mm = 1e-3;

// `X` as a rotation about +Y and a translation; empty if it has another rotation.
std::optional<MovingPose> about_delta(const Pose& X)
{
  const Eigen::Matrix3d R = X.linear();
  const double theta_rad = arc_tangent2(R(0, 2), R(0, 0));
  if (!((R - rotation_y(theta_rad)).cwiseAbs().maxCoeff() <= same_rotation)) return std::nullopt;
  return MovingPose{X.translation(), theta_rad};
}

// `X_zero`, in S at zero attitude, at the attitude.
Pose at_attitude(const Attitude& attitude, const Pose& X_zero)
{
  const Eigen::Matrix3d R = reference_rotation(attitude);
  Pose X = Pose::Identity();
  X.linear() = R * X_zero.linear();
  X.translation() = R * X_zero.translation();
  return X;
}

CompartmentGaps gaps_of(OfCompartments<geometry::GapQuery>& queries, const solve::SolverPosition& at)
{
  return {queries[0].gap_mm(at.attitude, at.pose), queries[1].gap_mm(at.attitude, at.pose)};
}

double radius_mm(const Mesh& mesh)
{
  return mesh.vertices_mm.rows() == 0 ? 0.0 : mesh.vertices_mm.rowwise().norm().maxCoeff();
}

}  // namespace

AuditScene make_audit_scene(const Mesh& reference_canonical, const Mesh& moving_canonical,
                            const SolverFrame& frame, const std::vector<std::int8_t>& compartment_of_triangle,
                            int n_threads)
{
  AuditScene scene{frame,
                   geometry::LateTreeMesh(solver_mesh(reference_canonical, frame)),
                   geometry::LateTreeMesh(solver_mesh(moving_canonical, frame)),
                   {},
                   {},
                   {}};
  const Mesh& moving = scene.moving.mesh();
  const auto make_compartment = [&](Compartment side) {
    scene.compartment_gap[side] = geometry::GapTree(moving, triangles_of(compartment_of_triangle, side));
    scene.compartment_gap[side].prepare_as_moving(geometry::GapKind::signed_facing);
  };
  // The longest first.
  const std::array<std::function<void()>, 4> parts{
      [&] {
        scene.moving_gap = geometry::GapTree(moving);
        scene.moving_gap.prepare_as_moving(geometry::GapKind::non_negative);
      },
      [&] { make_compartment(Compartment::medial); }, [&] { make_compartment(Compartment::lateral); },
      [&] {
        scene.reference_gap = geometry::GapTree(scene.reference.mesh());
        scene.reference_gap.prepare_as_reference();
      }};
  for_each_index(parts.size(), n_threads, [&] { return [&](std::size_t k) { parts[k](); }; });
  return scene;
}

PoseMeter::PoseMeter(const AuditScene& scene)
    : scene_(scene),
      query_(scene.reference_gap, scene.moving_gap),
      compartment_queries_(solve::compartment_queries(scene.reference_gap, scene.compartment_gap)),
      X_zero_(Pose::Identity()),
      radii_mm_(radius_mm(scene.reference.mesh()) + radius_mm(scene.moving.mesh()))
{
}

void PoseMeter::place(const Attitude& attitude, const Pose& X_reference_moving)
{
  X_zero_ = X_solver_reference_moving(scene_.frame, X_reference_moving);
  delta_zero_ = reference_rotation(attitude).transpose() * Eigen::Vector3d::UnitY();
  const Pose X_turned = at_attitude(attitude, X_zero_);
  beneath_mm_ = radii_mm_ + X_zero_.translation().norm() + 1.0;
  tilted_query_.reset();
  from_below_.reset();
  const std::optional<MovingPose> pose = about_delta(X_turned);
  if (pose) {
    pose_ = *pose;
  } else {
    pose_ = {};
    tilted_query_.emplace(scene_.reference_gap,
                          geometry::GapTree(transformed(scene_.moving.mesh(), X_turned)));
  }
  query().set_attitude(attitude);
  attitude_ = attitude;
}

// Expensive, so skipped for an unchanged attitude.
void PoseMeter::turn_reference(const Attitude& attitude)
{
  if (attitude.flexion_rad == attitude_.flexion_rad && attitude.varus_rad == attitude_.varus_rad) return;
  query_.set_attitude(attitude);
  attitude_ = attitude;
}

MovingPose PoseMeter::shifted(double shift_mm) const
{
  return {pose_.translation_mm + shift_mm * Eigen::Vector3d::UnitY(), pose_.theta_rad};
}

// The first contact on the way along Delta from far below, from the placed pose: the same for any shift.
const geometry::Gap& PoseMeter::first_from_below()
{
  if (!from_below_) {
    from_below_ = query().next_contact(shifted(-beneath_mm_));
    from_below_->travel_mm -= beneath_mm_;
  }
  return *from_below_;
}

bool PoseMeter::is_reached_from_below(double shift_mm)
{
  return first_from_below().travel_mm - shift_mm > clear_mm;
}

bool PoseMeter::is_overlapping(double shift_mm, OverlapTest judge)
{
  if (judge == OverlapTest::sweep && is_reached_from_below(shift_mm)) return false;
  Pose X = X_zero_;
  X.translation() += shift_mm * delta_zero_;
  const geometry::RigidPlacement place(X);
  // Independent of the queries, or three times as fast.
  const std::optional<geometry::TrianglePair> pair =
      judge == OverlapTest::narrow_phase || tilted_query_
          ? contact::find_collision(scene_.reference.with_tree(), scene_.moving.with_tree(), place,
                                    narrow_phase_, hint_)
          : contact::find_collision(scene_.reference.mesh(), scene_.moving.mesh(), place, shifted(shift_mm),
                                    query_, narrow_phase_, hint_);
  if (pair) hint_ = *pair;
  return pair.has_value();
}

double PoseMeter::touch_mm(double shift_mm)
{
  // On the way from far below nothing is passed: the first contact is the next one.
  if (from_below_ && is_reached_from_below(shift_mm)) {
    if (from_below_->pair.reference < 0) return from_below_->travel_mm;
    const double travel_mm = query().travel_of_mm(shifted(shift_mm), from_below_->pair);
    if (std::isfinite(travel_mm)) return travel_mm;
  }
  return query().next_contact(shifted(shift_mm)).travel_mm;
}

// Retreat from an overlapping pose. From far below, travel_mm finds the first contact, which for a ball deep
// in a socket is the rim; the free region is much nearer, so short retreats are tried first.
double PoseMeter::retreat_mm()
{
  const double afar_mm = query().travel_mm(pose_);
  const double most_mm = afar_mm < 0.0 ? -afar_mm : beneath_mm_;
  for (double back_mm = first_retreat_mm; back_mm < most_mm; back_mm *= 2.0) {
    if (!is_overlapping(-back_mm, OverlapTest::sweep)) return std::max(0.0, back_mm - touch_mm(-back_mm));
  }
  // Without facing pairs ahead (an open sheet hit from behind) the contact is searched from below everything.
  return afar_mm < 0.0 ? most_mm : std::max(0.0, most_mm - touch_mm(-most_mm));
}

std::optional<MovingPose> PoseMeter::solver_pose() const
{
  return tilted_query_ ? std::nullopt : std::optional(pose_);
}

double PoseMeter::travel_near_mm(const Attitude& attitude, const MovingPose& pose, double range_mm)
{
  check(!tilted_query_, "the measured pose is a rotation about Delta alone");
  turn_reference(attitude);
  // The first contact of facing pairs from far away is the cheapest query. Far behind, it is the rim of a
  // socket.
  const double afar_mm = query_.travel_mm(pose);
  if (std::abs(afar_mm) <= range_mm) return afar_mm;
  MovingPose behind = pose;
  behind.translation_mm.y() -= range_mm;
  const double travel_mm = query_.next_contact(behind).travel_mm;
  if (travel_mm <= 2.0 * range_mm) return travel_mm - range_mm;
  // An overlap there hides the nearest contact, and the query returns the next one.
  Pose X = pose_of(behind);
  X.prerotate(Eigen::Matrix3d(reference_rotation(attitude).transpose()));
  const bool is_blocked = contact::find_collision(scene_.reference.with_tree(), scene_.moving.with_tree(),
                                                  geometry::RigidPlacement(X), narrow_phase_, hint_)
                              .has_value();
  return is_blocked ? -range_mm : travel_mm - range_mm;
}

void PoseMeter::note_features(double band_mm)
{
  check(!tilted_query_, "the measured pose is a rotation about Delta alone");
  noted_.clear();
  for (const geometry::GapFeature& feature : query_.features(pose_, band_mm).features)
    noted_.push_back(feature.triangles);
}

// Also where the first contact from far away is far behind: travel_near_mm() then starts at most `range_mm`
// behind the pose, from where a noted pair is ahead.
double PoseMeter::travel_near_bound_mm(const Attitude& attitude, const MovingPose& pose)
{
  turn_reference(attitude);
  return query_.travel_upper_bound_mm(pose, noted_);
}

PoseAudit PoseMeter::measure(const Attitude& attitude, const Pose& X_reference_moving, OverlapTest judge)
{
  place(attitude, X_reference_moving);
  if (is_overlapping(0.0, judge)) return {true, retreat_mm(), 0.0};
  return {false, 0.0, touch_mm(0.0)};
}

CompartmentGaps PoseMeter::compartment_gaps(const Attitude& attitude, const Pose& X_reference_moving)
{
  if (!scene_.has_compartments()) return {nan, nan};
  // Without place(): the whole joint's query need not follow the attitude.
  const std::optional<MovingPose> pose =
      about_delta(at_attitude(attitude, X_solver_reference_moving(scene_.frame, X_reference_moving)));
  if (!pose) return {nan, nan};
  return gaps_of(compartment_queries_, {attitude, *pose});
}

FrameMeter::FrameMeter(const solve::Joint& joint, double resolution_mm)
    : joint_(joint),
      resolution_mm_(resolution_mm),
      whole_(joint.reference_gap, joint.moving_gap),
      compartments_(solve::compartment_queries(joint.reference_gap, joint.compartment_gap))
{
}

CompartmentGaps FrameMeter::gaps(const solve::SolverPosition& at)
{
  if (joint_.compartment_of_triangle.empty()) return {nan, nan};
  return gaps_of(compartments_, at);
}

StepRecord FrameMeter::record(std::int32_t frame, const solve::SolverPosition& at,
                              const CompartmentGaps& gaps)
{
  StepRecord r;
  r.key = {StepKind::row, frame, 0};
  r.status = StepStatus::stable;
  r.pose = at.pose;
  r.varus_rad = at.attitude.varus_rad;
  whole_.set_attitude(at.attitude);
  solve::measure_contacts(joint_, at.attitude, whole_, narrow_phase_, resolution_mm_, r);
  r.theta_determined = true;  // measured
  if (joint_.compartment_of_triangle.empty()) return r;
  r.gap_mm = gaps;
  for (const Compartment side : all_compartments) r.is_in_contact[side] = gaps[side] <= resolution_mm_;
  return r;
}

double PoseMeter::travel_into_contact_mm(const Attitude& attitude, const Pose& X_reference_moving)
{
  place(attitude, X_reference_moving);
  const double contact_mm = is_overlapping(0.0, OverlapTest::sweep) ? -retreat_mm() : touch_mm(0.0);
  for (double margin_mm = contact_margin_mm; margin_mm <= largest_margin_mm; margin_mm *= margin_growth) {
    if (std::isinf(contact_mm)) break;
    // Must be free at half the margin; the other half allows for rounding in a later measurement.
    if (!is_overlapping(contact_mm - 0.5 * margin_mm, OverlapTest::sweep)) return contact_mm - margin_mm;
  }
  return std::numeric_limits<double>::quiet_NaN();
}

std::shared_ptr<const AuditScene> AuditScenes::made(const Eigen::Vector3d& delta, int n_threads) const
{
  return std::make_shared<const AuditScene>(
      make_audit_scene(model_.reference.contact.mesh, model_.moving.contact.mesh,
                       {side_named(model_.side), model_.rotation_centre_mm, delta},
                       model_.compartment_of_triangle, n_threads));
}

std::shared_ptr<const AuditScene> AuditScenes::along(const Eigen::Vector3d& delta)
{
  {
    const std::lock_guard lock(mutex_);
    if (!first_) first_ = made(delta, n_threads_);
    if (first_->frame.delta == delta) return first_;
  }
  return made(delta, 1);
}

namespace {

/// The meter of a thread, replaced when Delta changes.
class CachedMeter {
 public:
  CachedMeter(AuditScenes& scenes, const Eigen::Vector3d& first) : scenes_(scenes)
  {
    use(scenes_.along(first));
  }
  PoseMeter& along(const Eigen::Vector3d& delta)
  {
    if (scene_->frame.delta != delta) use(scenes_.along(delta));
    return *meter_;
  }

 private:
  void use(std::shared_ptr<const AuditScene> scene)
  {
    meter_.reset();
    scene_ = std::move(scene);
    meter_ = std::make_unique<PoseMeter>(*scene_);
  }

  AuditScenes& scenes_;
  std::shared_ptr<const AuditScene> scene_;
  std::unique_ptr<PoseMeter> meter_;
};

}  // namespace

std::vector<double> refined(const std::vector<double>& axis_deg, int refine)
{
  std::vector<double> result;
  for (std::size_t i = 0; i + 1 < axis_deg.size(); ++i) {
    for (int k = 0; k < refine; ++k)
      result.push_back(axis_deg[i] + (axis_deg[i + 1] - axis_deg[i]) * k / refine);
  }
  result.push_back(axis_deg.back());
  return result;
}

void for_each_row(const store::MotionModel& model, const store::Motion& motion,
                  const std::vector<double>& flexion_deg, const Measuring& with,
                  const std::function<void(std::size_t, PoseMeter&)>& measure)
{
  std::vector<Eigen::Vector3d> deltas;
  for (const double angle_deg : flexion_deg) deltas.push_back(motion.delta(rad_from_deg(angle_deg)));
  for_each_delta(model, deltas, with, measure);
}

void for_each_delta(const store::MotionModel& model, const std::vector<Eigen::Vector3d>& deltas,
                    const Measuring& with, const std::function<void(std::size_t, PoseMeter&)>& measure)
{
  AuditScenes own(model, with.n_threads);
  AuditScenes& scenes = with.scenes != nullptr ? *with.scenes : own;
  for_each_index(deltas.size(), with.n_threads, [&] {
    return [&, meters = CachedMeter(scenes, deltas.front())](std::size_t row) mutable {
      measure(row, meters.along(deltas[row]));
    };
  });
}

}  // namespace vrda::analysis
