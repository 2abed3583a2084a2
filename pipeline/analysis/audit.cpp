#include "analysis/audit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <utility>

#include "core/parallel.hpp"
#include "core/text.hpp"
#include "solve/followers.hpp"
#include "solve/potential.hpp"

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
  if (model.has_compartments) out.gap_medial_mm = out.gap_lateral_mm = out.penetration_mm;
  return out;
}

void take_larger(AuditExtreme& extreme, const AuditExtreme& found)
{
  if (found.value_mm > extreme.value_mm) extreme = found;
}

// A follower and what it touches, for one thread.
class FollowerMeter {
 public:
  // `shared`: the scene of a follower that touches only the body of its coordinates, else empty.
  FollowerMeter(const store::MotionModel& model, const store::FollowerRows& rows,
                std::shared_ptr<const AuditScene> shared)
      : model_(model), rows_(rows), scene_(std::move(shared)), is_shared_(scene_ != nullptr)
  {
    if (is_shared_) meter_.emplace(*scene_);
  }

  static std::shared_ptr<const AuditScene> shared_scene(const store::MotionModel& model,
                                                        const store::FollowerRows& rows)
  {
    if (rows.touches != std::vector<std::int8_t>{static_cast<std::int8_t>(rows.of)}) return nullptr;
    return scene_at(model, rows, {});
  }

  // `pose` places the other bodies, X_of the follower relative to the body of its coordinates.
  PoseAudit measure(const store::JointPose& pose, const Pose& X_of, OverlapTest judge)
  {
    place(pose);
    return meter_->measure(attitude_of(X_of), X_of, judge);
  }
  double travel_mm(const store::JointPose& pose, const Pose& X_of)
  {
    place(pose);
    return meter_->travel_into_contact_mm(attitude_of(X_of), X_of);
  }

 private:
  static SolverFrame frame_of(const store::MotionModel& model, const store::FollowerRows& rows)
  {
    return {side_named(model.side), rows.centre_mm, rows.delta};
  }

  static std::shared_ptr<const AuditScene> scene_at(const store::MotionModel& model,
                                                    const store::FollowerRows& rows,
                                                    const store::JointPose& pose)
  {
    BodyPoses placed{Pose::Identity(), pose.X_reference_moving};
    placed.insert(placed.end(), pose.X_reference_follower.begin(), pose.X_reference_follower.end());
    std::vector<solve::TouchedBody> touched;
    for (std::size_t k = 0; k < rows.touches.size(); ++k) {
      const auto index = static_cast<BodyIndex>(rows.touches[k]);
      const bool has_drawn = !rows.touches_drawn.empty() && rows.touches_drawn[k] == 1;
      touched.push_back({&body_of(model, index), index, has_drawn});
    }
    return std::make_shared<const AuditScene>(
        make_audit_scene(solve::touched_mesh(touched, static_cast<BodyIndex>(rows.of), placed),
                         rows.body.contact.mesh, frame_of(model, rows)));
  }

  static const Body& body_of(const store::MotionModel& model, BodyIndex index)
  {
    if (index == BodyIndex::reference) return model.reference;
    if (index == BodyIndex::moving) return model.moving;
    return std::find_if(model.followers.begin(), model.followers.end(),
                        [&](const auto& other) { return static_cast<BodyIndex>(other.body_index) == index; })
        ->body;
  }

  void place(const store::JointPose& pose)
  {
    if (is_shared_) return;
    meter_.reset();
    scene_ = scene_at(model_, rows_, pose);
    meter_.emplace(*scene_);
  }

  Attitude attitude_of(const Pose& X_of) const
  {
    return solver_position(frame_of(model_, rows_), X_of).attitude;
  }

  const store::MotionModel& model_;
  const store::FollowerRows& rows_;
  std::shared_ptr<const AuditScene> scene_;
  bool is_shared_;
  std::optional<PoseMeter> meter_;
};

// Calls `measure(row, meter)` once for every row, with a meter of the thread.
template <typename Measure>
void for_each_follower_row(const store::MotionModel& model, const store::FollowerRows& rows, std::size_t n,
                           int n_threads, const Measure& measure)
{
  const std::shared_ptr<const AuditScene> shared = FollowerMeter::shared_scene(model, rows);
  for_each_index(n, n_threads, [&] {
    return [&, meter = std::make_shared<FollowerMeter>(model, rows, shared)](std::size_t row) {
      measure(row, *meter);
    };
  });
}

std::optional<Pose> pose_of_follower(const store::JointPose& pose, const store::FollowerRows& rows)
{
  const auto body = static_cast<BodyIndex>(rows.body_index);
  if (!pose.has_follower.at(model::follower_row(body))) return std::nullopt;
  return pose.X_reference(static_cast<BodyIndex>(rows.of)).inverse() * pose.X_reference(body);
}

store::FollowerAudit follower_audit(const store::MotionModel& model, const store::Motion& motion,
                                    const store::AuditSet& out, const store::FollowerRows& rows,
                                    int n_threads)
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
      std::optional<Pose> X_of = pose_of_follower(pose, rows);
      if (out.name == "raw" && is_node(out, i, j)) {
        const Eigen::Index cell = i / out.refine * rows.status.cols() + j / out.refine;
        X_of.reset();
        if (rows.status.data()[cell] == status_stable)
          X_of = store::pose_in(rows.X_of_follower, static_cast<std::size_t>(cell));
      }
      const OverlapTest judge = is_node(out, i, j) ? OverlapTest::narrow_phase : OverlapTest::sweep;
      if (X_of) set_state(found, i, j, meter.measure(pose, *X_of, judge));
    }
  });
  return found;
}

}  // namespace

store::AuditSet audit(const store::MotionModel& model, const std::string& set, int refine, int n_threads)
{
  check(refine >= 1, "an audit divides a cell into at least one part");
  const store::Motion motion(model, set);
  store::AuditSet out = unmeasured(model, motion, set, refine);
  for_each_delta(model, deltas_of(motion, out), n_threads, [&](std::size_t row, PoseMeter& meter) {
    const auto i = static_cast<Eigen::Index>(row);
    for (Eigen::Index j = 0; j < out.state.cols(); ++j) {
      const AuditPose pose = pose_at(model, motion, out, i, j);
      const OverlapTest judge = is_node(out, i, j) ? OverlapTest::narrow_phase : OverlapTest::sweep;
      if (!pose.has_pose) continue;
      set_state(out, i, j, meter.measure(pose.attitude, pose.X_reference_moving, judge));
      if (!model.has_compartments) continue;
      const CompartmentGaps gaps = meter.compartment_gaps(pose.attitude, pose.X_reference_moving);
      out.gap_medial_mm(i, j) = gaps.medial_mm;
      out.gap_lateral_mm(i, j) = gaps.lateral_mm;
    }
  });
  for (const store::FollowerRows& rows : model.followers)
    out.followers.push_back(follower_audit(model, motion, out, rows, n_threads));
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

store::GridD recontact(const store::MotionModel& model, const store::SmoothedSet& set, int n_threads)
{
  const store::Motion motion(model, set);
  store::GridD travel_mm(static_cast<Eigen::Index>(model.flexion_deg.size()),
                         static_cast<Eigen::Index>(model.varus_deg.size()));
  for_each_row(model, motion, model.flexion_deg, n_threads, [&](std::size_t row, PoseMeter& meter) {
    for (Eigen::Index j = 0; j < travel_mm.cols(); ++j) {
      const store::JointPose pose = motion.at(
          {rad_from_deg(model.flexion_deg[row]), rad_from_deg(model.varus_deg[static_cast<std::size_t>(j)])});
      travel_mm(static_cast<Eigen::Index>(row), j) =
          meter.travel_into_contact_mm(pose.attitude, pose.X_reference_moving);
    }
  });
  return travel_mm;
}

void add_recontact(const store::MotionModel& model, store::SmoothedSet& set, int n_threads)
{
  set.recontact_mm = recontact(model, set, n_threads);
  if (set.followers.empty()) return;
  const store::Motion motion(store::with_smoothed(model, set),
                             "degree_" + std::to_string(set.degree) + "_recontacted");
  for (store::SmoothedFollower& follower : set.followers) {
    const auto rows = std::find_if(model.followers.begin(), model.followers.end(),
                                   [&](const auto& other) { return other.name == follower.name; });
    check(rows != model.followers.end(), "a smoothed follower is one of the model");
    store::GridD travel_mm = store::GridD::Constant(set.recontact_mm->rows(), set.recontact_mm->cols(), nan);
    for_each_follower_row(model, *rows, model.flexion_deg.size(), n_threads,
                          [&](std::size_t row, FollowerMeter& meter) {
                            for (Eigen::Index j = 0; j < travel_mm.cols(); ++j) {
                              const store::JointPose pose =
                                  motion.at({rad_from_deg(model.flexion_deg[row]),
                                             rad_from_deg(model.varus_deg[static_cast<std::size_t>(j)])});
                              if (const std::optional<Pose> X_of = pose_of_follower(pose, *rows))
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

/// Signed travel along Delta; NaN if nothing faces.
double gap_mm(geometry::GapQuery& query, const Attitude& attitude, const MovingPose& pose)
{
  query.set_attitude(attitude);
  const double travel_mm = query.travel_mm(pose);
  return std::isfinite(travel_mm) ? travel_mm : nan;
}

double radius_mm(const Mesh& mesh)
{
  return mesh.vertices_mm.rows() == 0 ? 0.0 : mesh.vertices_mm.rowwise().norm().maxCoeff();
}

}  // namespace

AuditScene make_audit_scene(const Mesh& reference_canonical, const Mesh& moving_canonical,
                            const SolverFrame& frame, const std::vector<std::int8_t>& compartment_of_triangle)
{
  const Mesh reference = solver_mesh(reference_canonical, frame);
  const Mesh moving = solver_mesh(moving_canonical, frame);
  return {frame,
          geometry::make_tree_mesh(reference),
          geometry::make_tree_mesh(moving),
          geometry::GapTree(reference),
          geometry::GapTree(moving),
          geometry::GapTree(moving, triangles_of(compartment_of_triangle, Compartment::medial)),
          geometry::GapTree(moving, triangles_of(compartment_of_triangle, Compartment::lateral))};
}

PoseMeter::PoseMeter(const AuditScene& scene)
    : scene_(scene),
      query_(scene.reference_gap, scene.moving_gap),
      medial_query_(scene.reference_gap, scene.medial_gap),
      lateral_query_(scene.reference_gap, scene.lateral_gap),
      X_zero_(Pose::Identity()),
      radii_mm_(radius_mm(scene.reference.mesh) + radius_mm(scene.moving.mesh))
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
    tilted_query_.emplace(scene_.reference_gap, geometry::GapTree(transformed(scene_.moving.mesh, X_turned)));
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
          ? contact::find_collision(scene_.reference, scene_.moving, place, narrow_phase_, hint_)
          : contact::find_collision(scene_.reference.mesh, scene_.moving.mesh, place, shifted(shift_mm),
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
  const bool is_blocked = contact::find_collision(scene_.reference, scene_.moving,
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
  if (scene_.medial_gap.is_empty() || scene_.lateral_gap.is_empty()) return {};
  // Without place(): the whole joint's query need not follow the attitude.
  const std::optional<MovingPose> pose =
      about_delta(at_attitude(attitude, X_solver_reference_moving(scene_.frame, X_reference_moving)));
  if (!pose) return {};
  return {gap_mm(medial_query_, attitude, *pose), gap_mm(lateral_query_, attitude, *pose)};
}

FrameMeter::FrameMeter(const solve::Joint& joint, double resolution_mm)
    : joint_(joint),
      resolution_mm_(resolution_mm),
      whole_(joint.reference_gap, joint.moving_gap),
      medial_(joint.reference_gap, joint.medial_gap),
      lateral_(joint.reference_gap, joint.lateral_gap)
{
}

CompartmentGaps FrameMeter::gaps(const SolverPosition& at)
{
  if (joint_.compartment_of_triangle.empty()) return {};
  return {gap_mm(medial_, at.attitude, at.pose), gap_mm(lateral_, at.attitude, at.pose)};
}

StepRecord FrameMeter::record(std::int32_t frame, const SolverPosition& at, const CompartmentGaps& gaps)
{
  StepRecord r;
  r.key = {StepKind::row, frame, 0};
  r.status = StepStatus::stable;
  r.pose = at.pose;
  r.varus_rad = at.attitude.varus_rad;
  r.theta_determined = true;  // measured
  whole_.set_attitude(at.attitude);
  contact::ContactOptions options;
  options.band_mm = resolution_mm_;
  for (const contact::Contact& contact :
       contact::find_contacts(joint_.reference, joint_.moving, {at.attitude, at.pose},
                              whole_.close_pairs(at.pose, resolution_mm_), narrow_phase_, options))
    r.contacts.push_back(solve::contact_record(joint_, contact));
  if (joint_.compartment_of_triangle.empty()) return r;
  r.gap_medial_mm = gaps.medial_mm;
  r.gap_lateral_mm = gaps.lateral_mm;
  r.contact_medial = r.gap_medial_mm <= resolution_mm_;
  r.contact_lateral = r.gap_lateral_mm <= resolution_mm_;
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

namespace {

std::shared_ptr<const AuditScene> scene_along(const store::MotionModel& model, const Eigen::Vector3d& delta)
{
  const Side side = side_named(model.side);
  return std::make_shared<const AuditScene>(
      make_audit_scene(model.reference.contact.mesh, model.moving.contact.mesh,
                       {side, model.rotation_centre_mm, delta}, model.compartment_of_triangle));
}

/// The meter of a thread, replaced when Delta changes.
class CachedMeter {
 public:
  CachedMeter(const store::MotionModel& model, std::shared_ptr<const AuditScene> scene) : model_(model)
  {
    use(std::move(scene));
  }
  PoseMeter& along(const Eigen::Vector3d& delta)
  {
    if (scene_->frame.delta != delta) use(scene_along(model_, delta));
    return *meter_;
  }

 private:
  void use(std::shared_ptr<const AuditScene> scene)
  {
    meter_.reset();
    scene_ = std::move(scene);
    meter_ = std::make_unique<PoseMeter>(*scene_);
  }

  const store::MotionModel& model_;
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
                  const std::vector<double>& flexion_deg, int n_threads,
                  const std::function<void(std::size_t, PoseMeter&)>& measure)
{
  std::vector<Eigen::Vector3d> deltas;
  for (const double angle_deg : flexion_deg) deltas.push_back(motion.delta(rad_from_deg(angle_deg)));
  for_each_delta(model, deltas, n_threads, measure);
}

void for_each_delta(const store::MotionModel& model, const std::vector<Eigen::Vector3d>& deltas,
                    int n_threads, const std::function<void(std::size_t, PoseMeter&)>& measure)
{
  const std::shared_ptr<const AuditScene> first = scene_along(model, deltas.front());
  for_each_index(deltas.size(), n_threads, [&] {
    return [&, meters = CachedMeter(model, first)](std::size_t row) mutable {
      measure(row, meters.along(deltas[row]));
    };
  });
}

namespace {

// Search range for the contact of a neighbouring pose, in resolutions: sufficient next to a wall of slope 4
// (76 degrees). Steeper ones are left to the narrow phase.
constexpr double range_resolutions = 4.0;
// Features of this band bound the travel after a step of one resolution on slopes up to 60 degrees.
constexpr double band_resolutions = 2.0;
// Far above the rounding of heights (about 1e-12 mm) and below the slope that the solvers treat as level:
// 1e-3 in the search (solve/stability_search.cpp).
constexpr double level_slope = 1e-3;

Eigen::Vector3d vector_at(const std::vector<double>& rows, std::size_t row)
{
  return {rows[3 * row], rows[3 * row + 1], rows[3 * row + 2]};
}

void add_applied(const store::LoadRows& rows, std::size_t flexion, const SolverFrame& frame, Loads& loads)
{
  for (std::size_t k = 0; k < rows.name.size(); ++k) {
    const std::size_t at = flexion * rows.name.size() + k;
    loads.applied.push_back(
        {static_cast<BodyIndex>(rows.frame[k] - 1), solver_translation_mm(frame, vector_at(rows.force_n, at)),
         solver_moment_nmm(frame, vector_at(rows.moment_nmm, at)),
         solver_translation_mm(frame, rows.point_mm.row(static_cast<Eigen::Index>(k)).transpose())});
  }
}

// Between the last point on the reference and the first on the moving object.
void add_lines(const store::LineRows& rows, std::size_t flexion, const SolverFrame& frame, Loads& loads)
{
  const std::size_t n_lines = rows.name.size();
  for (std::size_t p = 0; p + 1 < rows.point_line.size(); ++p) {
    const bool is_free_segment = rows.point_line[p] == rows.point_line[p + 1] && rows.point_body[p] == 0 &&
                                 rows.point_body[p + 1] == 1;
    if (!is_free_segment) continue;
    const auto row = static_cast<Eigen::Index>(p);
    loads.lines.push_back({rows.tension_n[flexion * n_lines + static_cast<std::size_t>(rows.point_line[p])],
                           solver_translation_mm(frame, rows.point_mm.row(row).transpose()),
                           solver_translation_mm(frame, rows.point_mm.row(row + 1).transpose())});
  }
}

Loads loads_of(const store::MotionModel& model, Eigen::Index flexion, const SolverFrame& frame)
{
  Loads loads;
  loads.force_n = Eigen::Vector3d::UnitY();  // the only load of the stability search
  if (!model.equilibrium) return loads;
  const auto row = static_cast<std::size_t>(flexion);
  loads.force_n = solver_translation_mm(frame, model.push.force_n.row(flexion).transpose());
  loads.point_mm = solver_translation_mm(frame, model.push.point_mm);
  loads.moment_nmm = model.push.moment_nmm[row];
  loads.varus_moment_nmm = model.push.varus_moment_nmm[row];
  if (model.push.loads) add_applied(*model.push.loads, row, frame, loads);
  if (model.push.lines) add_lines(*model.push.lines, row, frame, loads);
  return loads;
}

// Unit steps along what the solver leaves free; a step back is the other side.
std::vector<Vector5d> free_directions(bool is_varus_free)
{
  const double half = std::sqrt(0.5);
  std::vector<Vector5d> directions(4, Vector5d::Zero());
  directions[0](along_x) = 1.0;
  directions[1](along_z) = 1.0;
  directions[2](along_x) = directions[2](along_z) = half;
  directions[3](along_x) = half;
  directions[3](along_z) = -half;
  directions.push_back(Vector5d::Unit(about_y));
  if (is_varus_free) directions.push_back(Vector5d::Unit(about_varus));
  return directions;
}

// Failure of an anterior cruciate ligament (Noyes and Grood 1976).
constexpr double largest_strain = 0.44;
constexpr double largest_bundle_n = 1730.0;

/// The edges at which the surfaces of both objects end.
struct Borders {
  std::vector<std::int8_t> reference, moving;
};

bool is_overstrained(const store::LigamentRows& rows, std::size_t cell)
{
  const std::size_t n = rows.name.size();
  std::map<std::string, double> bundle_n;
  for (std::size_t k = 0; k < n; ++k) {
    if (rows.strain[cell * n + k] > largest_strain) return true;
    double& tension_n = bundle_n[rows.bundle[k]];
    tension_n += rows.tension_n[cell * n + k];
    if (tension_n > largest_bundle_n) return true;
  }
  return false;
}

/// A configuration and its travel along Delta into contact.
struct ContactTravel {
  solve::Configuration configuration;
  double travel_mm = 0.0;
};

/// Assesses the stable poses of one row of the grid.
class RowAssessor {
 public:
  RowAssessor(const store::MotionModel& model, Eigen::Index flexion, const model::Ligaments& canonical,
              const JointBounds& bounds, const Borders& borders, PoseMeter& meter)
      : model_(model),
        flexion_(flexion),
        bounds_(bounds),
        borders_(borders),
        meter_(meter),
        resolution_mm_(model.contact_resolution_mm),
        rotation_scale_(solve::rotation_scale_of(meter.scene().moving.mesh)),
        ligaments_(model::solver_ligaments(canonical, meter.scene().frame)),
        loads_(loads_of(model, flexion, meter.scene().frame)),
        forces_{ligaments_, loads_, rotation_scale_,
                rad_from_deg(model.flexion_deg[static_cast<std::size_t>(flexion)])}
  {
    if (!loads_.applied.empty() || !loads_.lines.empty()) forces_.applied = &applied_;
  }

  void assess(Eigen::Index varus, bool is_varus_free, PoseAssessment& verdicts)
  {
    const Attitude attitude{forces_.flexion_rad, rad_from_deg(model_.varus_solved_deg(flexion_, varus))};
    const std::size_t cell = static_cast<std::size_t>(flexion_ * model_.status.cols() + varus);
    const PoseAudit found =
        meter_.measure(attitude, store::pose_in(model_.X_reference_moving, cell), OverlapTest::sweep);
    verdicts.is_overlapping(flexion_, varus) = found.is_overlapping ? 1 : 0;
    if (found.is_overlapping) return;
    verdicts.plausibility(flexion_, varus) =
        static_cast<std::int8_t>(plausibility_of(cell, attitude, found.gap_mm, is_varus_free));
  }

 private:
  Plausibility plausibility_of(std::size_t cell, const Attitude& attitude, double gap_mm, bool is_varus_free)
  {
    const std::optional<MovingPose> pose = meter_.solver_pose();
    if (pose && !is_within(bounds_, meter_.scene().frame, *pose)) return Plausibility::dislocated;
    if (pose && has_border_contact(cell, attitude, *pose)) return Plausibility::border_contact;
    if (model_.ligaments && is_overstrained(*model_.ligaments, cell)) return Plausibility::overstrained;
    if (!is_held_by_contact(cell)) return Plausibility::nothing_found;
    if (gap_mm > resolution_mm_) return Plausibility::nothing_ahead;
    return neighbour_plausibility(attitude, gap_mm, is_varus_free);
  }

  bool has_border_contact(std::size_t cell, const Attitude& attitude, const MovingPose& pose) const
  {
    const AuditScene& scene = meter_.scene();
    const store::ContactRows& rows = model_.contacts;
    const Eigen::Matrix3d R_reference_solver = reference_rotation(attitude).transpose();
    const Pose X_moving_solver = pose_of(pose).inverse();
    for (std::int64_t i = rows.row_start[cell]; i < rows.row_start[cell + 1]; ++i) {
      const auto k = static_cast<std::size_t>(i);
      const Eigen::Vector3d p_mm = solver_translation_mm(scene.frame, rows.point_world_mm.row(i).transpose());
      // The moving surface is at most the contact's distance away from the point, and where they overlap
      // either of these surfaces (inward_limit) is.
      const double inside_mm = std::max(0.0, -rows.distance_mm[k]);
      if (is_at_border(scene.reference.mesh, borders_.reference, rows.triangle_reference[k],
                       R_reference_solver * p_mm, resolution_mm_ + inside_mm) ||
          is_at_border(scene.moving.mesh, borders_.moving, rows.triangle_moving[k], X_moving_solver * p_mm,
                       resolution_mm_ + std::abs(rows.distance_mm[k])))
        return true;
    }
    return false;
  }

  bool is_held_by_contact(std::size_t cell) const
  {
    if (!model_.equilibrium) return true;
    const std::vector<std::int64_t>& row_start = model_.equilibrium->forces.row_start;
    return row_start[cell + 1] > row_start[cell];
  }

  Plausibility neighbour_plausibility(const Attitude& attitude, double gap_mm, bool is_varus_free)
  {
    const std::optional<MovingPose> pose = meter_.solver_pose();
    if (!pose) return Plausibility::nothing_found;
    const solve::Configuration here = solve::configuration_at(*pose, attitude.varus_rad, rotation_scale_);
    const ContactTravel start{here, gap_mm};
    // About this pose, of whose neighbours the energies are compared.
    applied_ = solve::potential_near(loads_, attitude, *pose);
    meter_.note_features(band_resolutions * resolution_mm_);
    for (const Vector5d& direction : free_directions(is_varus_free)) {
      if (is_clearly_held(start, direction)) continue;
      const ContactTravel one =
          contact_travel(solve::moved(here, resolution_mm_ * direction, rotation_scale_));
      const ContactTravel other =
          contact_travel(solve::moved(here, -resolution_mm_ * direction, rotation_scale_));
      const double furthest_mm = std::max(one.travel_mm, other.travel_mm);
      if (std::isfinite(furthest_mm) && is_lower_both_ways(start, one, other))
        return Plausibility::unstable_balance;
      if (furthest_mm > resolution_mm_) return Plausibility::nothing_ahead;
    }
    return Plausibility::nothing_found;
  }

  // By upper bounds of both travels: most directions of most poses need no query.
  bool is_clearly_held(const ContactTravel& start, const Vector5d& direction)
  {
    double sum_mm = 0.0;
    for (const double side : {1.0, -1.0}) {
      const solve::Configuration aside =
          solve::moved(start.configuration, side * resolution_mm_ * direction, rotation_scale_);
      const double bound_mm = meter_.travel_near_bound_mm({forces_.flexion_rad, aside.varus_rad},
                                                          solve::pose_at(aside, rotation_scale_));
      if (!(bound_mm <= resolution_mm_) || bound_mm < -range_resolutions * resolution_mm_) return false;
      sum_mm += bound_mm;
    }
    return is_level(start.travel_mm, sum_mm);
  }

  // In equilibrium the slope along the path is 0, so only its curvature can lower the energy on both sides.
  bool is_level(double start_mm, double sum_mm) const
  {
    return sum_mm - 2.0 * start_mm <= 2.0 * level_slope * resolution_mm_;
  }

  ContactTravel contact_travel(const solve::Configuration& configuration)
  {
    return {configuration, meter_.travel_near_mm({forces_.flexion_rad, configuration.varus_rad},
                                                 solve::pose_at(configuration, rotation_scale_),
                                                 range_resolutions * resolution_mm_)};
  }

  bool is_lower_both_ways(const ContactTravel& start, const ContactTravel& one,
                          const ContactTravel& other) const
  {
    if (is_level(start.travel_mm, one.travel_mm + other.travel_mm)) return false;
    const double least_nmm = energy_nmm(start) - level_slope * resolution_mm_ * loads_.force_n.norm();
    return energy_nmm(one) < least_nmm && energy_nmm(other) < least_nmm;
  }

  double energy_nmm(const ContactTravel& travel) const
  {
    solve::Configuration configuration = travel.configuration;
    configuration.pivot_mm.y() += travel.travel_mm;
    return solve::potential_at(forces_, configuration).energy_nmm;
  }

  const store::MotionModel& model_;
  Eigen::Index flexion_;
  const JointBounds& bounds_;
  const Borders& borders_;
  PoseMeter& meter_;
  double resolution_mm_;
  solve::RotationScale rotation_scale_;
  model::Ligaments ligaments_;
  Loads loads_;
  solve::LoadPotential applied_;
  solve::NonContactForces forces_;
};

}  // namespace

PoseAssessment assess_poses(const store::MotionModel& model, const model::Ligaments& ligaments,
                            const JointBounds& bounds, int n_threads)
{
  const store::Motion motion(model, "raw");
  PoseAssessment verdicts;
  verdicts.is_overlapping = store::GridB::Zero(model.status.rows(), model.status.cols());
  verdicts.plausibility =
      store::GridB::Constant(model.status.rows(), model.status.cols(), plausibility_not_judged);
  const Borders borders{boundary_edges(model.reference.contact.mesh),
                        boundary_edges(model.moving.contact.mesh)};
  std::vector<Eigen::Vector3d> deltas;
  for (Eigen::Index i = 0; i < model.push.delta.rows(); ++i)
    deltas.emplace_back(model.push.delta.row(i).transpose());
  for_each_delta(model, deltas, n_threads, [&](std::size_t row, PoseMeter& meter) {
    const auto i = static_cast<Eigen::Index>(row);
    RowAssessor assessor(model, i, ligaments, bounds, borders, meter);
    for (Eigen::Index j = 0; j < model.status.cols(); ++j) {
      if (model.status(i, j) == status_stable) assessor.assess(j, motion.is_varus_free(), verdicts);
    }
  });
  return verdicts;
}

// Where the surface of a mesh ends.

std::vector<std::int8_t> boundary_edges(const Mesh& mesh)
{
  struct Side {
    std::int32_t first, second;  // sorted vertices
    Eigen::Index triangle;
    int corner;
  };
  std::vector<Side> sides;
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const auto [first, second] = std::minmax(mesh.triangles(t, k), mesh.triangles(t, (k + 1) % 3));
      sides.push_back({first, second, t, k});
    }
  }
  const auto edge = [](const Side& s) { return std::pair(s.first, s.second); };
  std::sort(sides.begin(), sides.end(), [&](const Side& a, const Side& b) { return edge(a) < edge(b); });
  std::vector<std::int8_t> bits(static_cast<std::size_t>(mesh.triangles.rows()), 0);
  for (std::size_t i = 0; i < sides.size(); ++i) {
    const bool is_shared = (i > 0 && edge(sides[i - 1]) == edge(sides[i])) ||
                           (i + 1 < sides.size() && edge(sides[i]) == edge(sides[i + 1]));
    if (!is_shared)
      bits[static_cast<std::size_t>(sides[i].triangle)] |= static_cast<std::int8_t>(1 << sides[i].corner);
  }
  return bits;
}

namespace {

double distance_to_segment_mm(const Eigen::Vector3d& p, const Eigen::Vector3d& a, const Eigen::Vector3d& b)
{
  const Eigen::Vector3d along = b - a;
  const double length_sq = along.squaredNorm();
  const double share = length_sq > 0.0 ? std::clamp((p - a).dot(along) / length_sq, 0.0, 1.0) : 0.0;
  return (p - a - share * along).norm();
}

}  // namespace

bool is_at_border(const Mesh& mesh, const std::vector<std::int8_t>& border, std::int32_t t,
                  const Eigen::Vector3d& p_mm, double resolution_mm)
{
  // Writing the model refuses a row outside the mesh, which only a damaged journal has.
  if (t < 0 || static_cast<std::size_t>(t) >= border.size()) return false;
  const int bits = border[static_cast<std::size_t>(t)];
  for (int k = 0; k < 3; ++k) {
    if ((bits >> k & 1) == 0) continue;
    const Eigen::Vector3d a = mesh.vertices_mm.row(mesh.triangles(t, k)).transpose();
    const Eigen::Vector3d b = mesh.vertices_mm.row(mesh.triangles(t, (k + 1) % 3)).transpose();
    if (distance_to_segment_mm(p_mm, a, b) <= resolution_mm) return true;
  }
  return false;
}

}  // namespace vrda::analysis
