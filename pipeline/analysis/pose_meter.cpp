#include "analysis/pose_meter.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "core/error.hpp"
#include "core/parallel.hpp"
#include "model/side.hpp"
#include "core/trig.hpp"
#include "core/units.hpp"

namespace vrda::analysis {
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
    tilted_query_.emplace(scene_.reference_gap,
                          geometry::GapTree(transformed(scene_.moving.mesh, X_turned)));
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
          : contact::find_collision(scene_.reference.mesh, scene_.moving.mesh, place, shifted(shift_mm), query_,
                                    narrow_phase_, hint_);
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
  const auto gap_mm = [&](geometry::GapQuery& query) {
    query.set_attitude(attitude);
    const double travel_mm = query.travel_mm(*pose);
    return std::isfinite(travel_mm) ? travel_mm : nan;
  };
  return {gap_mm(medial_query_), gap_mm(lateral_query_)};
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

}  // namespace vrda::analysis
