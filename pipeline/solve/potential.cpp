#include "solve/potential.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/units.hpp"
#include "solve/quadratic_program.hpp"

namespace vrda::solve {
namespace {

// Rotation of a load's axes in S.
Eigen::Matrix3d rotation_of(BodyIndex frame, const model::JointPlacement& placement)
{
  switch (frame) {
    case BodyIndex::world:
      return Eigen::Matrix3d::Identity();
    case BodyIndex::reference:
      return placement.R_S_reference;
    case BodyIndex::moving:
      return placement.R_S_moving;
  }
  return Eigen::Matrix3d::Identity();
}

void add(Wrench& sum, const Eigen::Vector3d& at_mm, const Eigen::Vector3d& force_n)
{
  sum.force_n += force_n;
  sum.moment_nmm += at_mm.cross(force_n);
}

Wrench wrench_of(const AppliedLoad& load, const model::JointPlacement& placement)
{
  const Eigen::Matrix3d R = rotation_of(load.frame, placement);
  Wrench sum;
  add(sum, placement.t_S_moving_mm + placement.R_S_moving * load.point_mm, R * load.force_n);
  sum.moment_nmm += R * load.moment_nmm;
  return sum;
}

// Along the coordinates (model/coordinates.hpp): theta turns about the object's own axis, varus about X.
Vector5d generalised(const Wrench& wrench, const MovingPose& pose)
{
  Vector5d force;
  force << wrench.force_n, (wrench.moment_nmm - pose.translation_mm.cross(wrench.force_n)).y(),
      wrench.moment_nmm.x();
  return force;
}

}  // namespace

Wrench wrench_of(const Loads& loads, const Attitude& attitude, const MovingPose& pose)
{
  const model::JointPlacement placement = model::joint_placement(attitude, pose);
  Wrench sum;
  for (const AppliedLoad& load : loads.applied) {
    const Wrench one = wrench_of(load, placement);
    sum.force_n += one.force_n;
    sum.moment_nmm += one.moment_nmm;
  }
  for (const TensionLine& line : loads.lines) {
    const Eigen::Vector3d from_mm = placement.t_S_moving_mm + placement.R_S_moving * line.moving_mm;
    const Eigen::Vector3d to_mm = placement.R_S_reference * line.reference_mm;
    add(sum, from_mm, line.tension_n * (to_mm - from_mm).normalized());
  }
  return sum;
}

LoadPotential potential_near(const Loads& loads, const Attitude& attitude, const MovingPose& pose)
{
  const model::JointPlacement placement = model::joint_placement(attitude, pose);
  LoadPotential out;
  out.lines = loads.lines;
  for (const AppliedLoad& load : loads.applied) {
    AppliedLoad constant = load;
    if (load.frame != BodyIndex::moving) {
      const Eigen::Matrix3d R_S_load = rotation_of(load.frame, placement);
      out.forces.push_back({placement.R_S_reference.transpose() * (R_S_load * load.force_n), load.point_mm});
      constant.force_n.setZero();
    }
    out.constant += generalised(wrench_of(constant, placement), pose);
  }
  return out;
}

Potential energy_of(const LoadPotential& loads, const Attitude& attitude, const MovingPose& pose)
{
  Potential sum = model::line_energy(loads.lines, attitude, pose);
  for (const LoadPotential::PointForce& force : loads.forces) {
    const Potential one =
        model::point_force_energy(force.force_reference_n, force.point_moving_mm, attitude, pose);
    sum.energy_nmm += one.energy_nmm;
    sum.gradient += one.gradient;
    sum.hessian += one.hessian;
  }
  Vector5d at;
  at << pose.translation_mm, pose.theta_rad, attitude.varus_rad;
  sum.energy_nmm -= loads.constant.dot(at);
  sum.gradient -= loads.constant;
  return sum;
}

CoordinateValue coordinate_value(PriorCoordinate coordinate, double varus_rad, const MovingPose& pose)
{
  CoordinateValue q;
  const Eigen::Vector3d& t = pose.translation_mm;
  const auto linear = [&](double value, Eigen::Index k) {
    q.value = value;
    q.gradient(k) = 1.0;
    return q;
  };
  switch (coordinate) {
    case PriorCoordinate::varus:
      return linear(varus_rad, about_varus);
    case PriorCoordinate::internal:
      return linear(pose.theta_rad, about_y);
    case PriorCoordinate::anterior:
      return linear(t.x(), along_x);
    case PriorCoordinate::proximal:
      return linear(t.y(), along_y);
    case PriorCoordinate::lateral: {  // along the flexion axis Rx(-varus) Z
      const SinCos varus = sin_cos(varus_rad);
      q.value = varus.sin * t.y() + varus.cos * t.z();
      q.gradient(along_y) = varus.sin;
      q.gradient(along_z) = varus.cos;
      q.gradient(about_varus) = varus.cos * t.y() - varus.sin * t.z();
      q.hessian(about_varus, about_varus) = -q.value;
      q.hessian(about_varus, along_y) = q.hessian(along_y, about_varus) = varus.cos;
      q.hessian(about_varus, along_z) = q.hessian(along_z, about_varus) = -varus.sin;
      return q;
    }
    case PriorCoordinate::centre_anterior: {  // X component of Ry(-theta) (0 - t)
      const SinCos theta = sin_cos(pose.theta_rad);
      q.value = theta.sin * t.z() - theta.cos * t.x();
      q.gradient(along_x) = -theta.cos;
      q.gradient(along_z) = theta.sin;
      q.gradient(about_y) = theta.cos * t.z() + theta.sin * t.x();
      q.hessian(about_y, about_y) = -q.value;
      q.hessian(about_y, along_x) = q.hessian(along_x, about_y) = theta.sin;
      q.hessian(about_y, along_z) = q.hessian(along_z, about_y) = theta.cos;
      return q;
    }
  }
  throw InternalError("a coordinate of a prior");
}

Potential energy_of(const std::vector<CoordinateSpring>& springs, double varus_rad, const MovingPose& pose)
{
  Potential sum;
  for (const CoordinateSpring& spring : springs) {
    const CoordinateValue q = coordinate_value(spring.coordinate, varus_rad, pose);
    const double force = spring.stiffness * (q.value - spring.target);
    sum.energy_nmm += 0.5 * force * (q.value - spring.target);
    sum.gradient += force * q.gradient;
    sum.hessian += spring.stiffness * q.gradient * q.gradient.transpose() + force * q.hessian;
  }
  return sum;
}

namespace {

// Newton's method safeguarded by bisection: 60 halvings reduce 1000 mm to rounding.
constexpr int max_height_steps = 80;

// Changes coordinates from the pose to the configuration: rotation about the pivot moves the object's origin.
Potential about_pivot(const Potential& of_pose, const Eigen::Vector3d& arm)
{
  // arm: from the origin of the moving object to its pivot, in S.
  Vector5d turn = Vector5d::Zero();
  turn.head<3>() = -Eigen::Vector3d::UnitY().cross(arm);
  turn(about_y) = 1.0;
  Potential out = of_pose;
  out.gradient(about_y) = turn.dot(of_pose.gradient);
  const Vector5d column = of_pose.hessian * turn;
  out.hessian.col(about_y) = column;
  out.hessian.row(about_y) = column.transpose();
  out.hessian(about_y, about_y) =
      turn.dot(column) + of_pose.gradient(along_x) * arm.x() + of_pose.gradient(along_z) * arm.z();
  return out;
}

Potential second_order_expansion(const EquilibriumCandidate& from, const Configuration& configuration)
{
  Vector5d step;
  step << configuration.pivot_mm - from.configuration.pivot_mm,
      configuration.theta_rad - from.configuration.theta_rad,
      configuration.varus_rad - from.configuration.varus_rad;
  const Vector5d change = from.potential.hessian * step;
  Potential u = from.potential;
  u.energy_nmm += from.potential.gradient.dot(step) + 0.5 * step.dot(change);
  u.gradient += change;
  return u;
}

}  // namespace

Potential potential_at(const NonContactForces& forces, const Configuration& configuration)
{
  if (forces.expansion_point != nullptr)
    return second_order_expansion(*forces.expansion_point, configuration);
  const MovingPose pose = pose_at(configuration, forces.scale);
  Potential u;
  if (!forces.ligaments.fibres.empty())
    u = model::ligament_energy(forces.ligaments, {forces.flexion_rad, configuration.varus_rad}, pose);
  if (forces.applied != nullptr) {
    const Potential applied = energy_of(*forces.applied, {forces.flexion_rad, configuration.varus_rad}, pose);
    u.energy_nmm += applied.energy_nmm;
    u.gradient += applied.gradient;
    u.hessian += applied.hessian;
  }
  const Loads& loads = forces.loads;
  if (!loads.springs.empty()) {
    const Potential springs = energy_of(loads.springs, configuration.varus_rad, pose);
    u.energy_nmm += springs.energy_nmm;
    u.gradient += springs.gradient;
    u.hessian += springs.hessian;
  }
  const Eigen::Vector3d turning_nmm = loads.point_mm.cross(loads.force_n);
  Vector5d push;
  push << loads.force_n, loads.moment_nmm + turning_nmm.y(), loads.varus_moment_nmm + turning_nmm.x();
  Vector5d at;
  at << pose.translation_mm, pose.theta_rad, configuration.varus_rad;
  u.energy_nmm -= push.dot(at);
  u.gradient -= push;
  return about_pivot(u, configuration.pivot_mm - pose.translation_mm);
}

EquilibriumCandidate equilibrium_along_delta(const NonContactForces& forces, Configuration configuration,
                                             const HeightLimits& limits)
{
  double low = limits.ceiling_mm - limits.reach_mm, high = limits.ceiling_mm;
  configuration.pivot_mm.y() = std::clamp(configuration.pivot_mm.y(), low, high);
  EquilibriumCandidate candidate{configuration, potential_at(forces, configuration), true};
  for (int k = 0; k < max_height_steps; ++k) {
    double& y = candidate.configuration.pivot_mm.y();
    const double slope = candidate.potential.gradient(along_y),
                 stiffness = candidate.potential.hessian(along_y, along_y);
    if (std::abs(slope) <= limits.force_tolerance_n || (y >= limits.ceiling_mm && slope < 0.0))
      return candidate;
    (slope > 0.0 ? high : low) = y;
    if (high - low <= 1e-13 * (1.0 + std::abs(y))) break;
    // Newton's step, or else the ceiling while it has not been tried, or bisection.
    double next = y - slope / stiffness;
    if (!(stiffness > 0.0) || !(next > low) || !(next < high)) {
      next = slope < 0.0 && high == limits.ceiling_mm ? high : 0.5 * (low + high);
    }
    y = next;
    candidate.potential = potential_at(forces, candidate.configuration);
  }
  candidate.is_bounded = high - low < 0.5 * limits.reach_mm && low > limits.ceiling_mm - limits.reach_mm;
  return candidate;
}

ContactForceBalance balance_contact_forces(const Potential& potential, const std::vector<Clearance>& touching,
                                           const RotationScale& scale, const std::array<bool, 5>& is_free)
{
  Vector5d s;
  s << 1.0, 1.0, 1.0, 1.0 / scale.lever_mm, 1.0 / scale.lever_mm;
  for (std::size_t k = 0; k < is_free.size(); ++k) s(static_cast<Eigen::Index>(k)) *= is_free[k] ? 1.0 : 0.0;
  std::vector<HalfSpace> rows;
  std::vector<double> length;
  for (const Clearance& c : touching) {
    const QpVector normal = s.cwiseProduct(c.gradient);
    length.push_back(std::max(normal.norm(), std::numeric_limits<double>::min()));
    rows.push_back({normal / length.back(), 0.0});
  }
  const QpSolution qp =
      solve_quadratic_program<5>(QpMatrix::Identity(), s.cwiseProduct(potential.gradient), rows);
  ContactForceBalance held;
  held.unbalanced_n = qp.d;
  held.residual_n = qp.d.norm();
  for (std::size_t k = 0; k < qp.n_active; ++k) {
    const QpSolution::ActiveConstraint& active = qp.active[k];
    if (active.multiplier > 0.0) held.active.push_back({active.row, active.multiplier / length[active.row]});
  }
  std::sort(held.active.begin(), held.active.end(),
            [](const ContactForceBalance::ActiveConstraint& a,
               const ContactForceBalance::ActiveConstraint& b) { return a.row < b.row; });
  return held;
}

Vector6d wrench_of(const Eigen::Vector3d& force_n, const Eigen::Vector3d& p, const SolverPosition& at)
{
  Vector6d wrench;
  wrench << (p - at.pose.translation_mm).cross(force_n), force_n;
  return wrench;
}

namespace {

// Angle of the line to the point of the reference and its derivative over that point, in S.
struct Turned {
  double angle_rad = 0.0;
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
};

Turned turned(const DirectionSpring& spring, const SolverPosition& at)
{
  const Eigen::Matrix3d R_S_moving = rotation_y(at.pose.theta_rad);
  const Eigen::Vector3d end_mm = reference_rotation(at.attitude) * spring.reference_mm;
  const Eigen::Vector3d line = R_S_moving.transpose() * (end_mm - at.pose.translation_mm) - spring.moving_mm;
  const Eigen::Vector3d across = line - spring.axis.dot(line) * spring.axis;
  const double sine = spring.axis.dot(spring.rest.cross(across)), cosine = spring.rest.dot(across);
  return {arc_tangent2(sine, cosine), R_S_moving * spring.axis.cross(across) / across.squaredNorm()};
}

}  // namespace

double energy_of(const DirectionSpring& spring, const SolverPosition& at, Vector6d& wrench)
{
  const Turned now = turned(spring, at);
  const Eigen::Vector3d end_mm = reference_rotation(at.attitude) * spring.reference_mm;
  wrench += wrench_of(-spring.stiffness_nmm * now.angle_rad * now.gradient, end_mm, at);
  return 0.5 * spring.stiffness_nmm * now.angle_rad * now.angle_rad;
}

Eigen::Vector3d force_on_reference(const DirectionSpring& spring, const SolverPosition& at)
{
  const Turned now = turned(spring, at);
  return -spring.stiffness_nmm * now.angle_rad * now.gradient;
}

SolverPosition solver_position(const Pose& X_reference_moving)
{
  const JointCoordinates angles = joint_coordinates(X_reference_moving);
  const Attitude attitude{angles(0), angles(1)};
  return {attitude, {reference_rotation(attitude) * X_reference_moving.translation(), angles(2)}};
}

JointMap::JointMap(const SolverFrame& frame) : frame_{Side::right, Eigen::Vector3d::Zero(), frame.delta}
{
  if (frame.side == Side::left) frame_.delta.z() = -frame_.delta.z();
  for (Eigen::Index k = 0; k < 3; ++k)
    R_solver_joint_.col(k) = solver_translation_mm(frame_, Eigen::Matrix3d::Identity().col(k));
}

SolverPosition JointMap::position_at(const JointCoordinates& coordinates) const
{
  // With Delta along the moving object's axis the coordinates are those of S: no rounding.
  if (R_solver_joint_.isIdentity(0.0))
    return {{coordinates(0), coordinates(1)}, {floating_translation_mm(coordinates), coordinates(2)}};
  return solver_position(frame_, joint_pose(coordinates));
}

JointCoordinates JointMap::coordinates_at(const SolverPosition& position) const
{
  return joint_coordinates(X_reference_moving(frame_, position.attitude, position.pose));
}

Matrix6d JointMap::twists(const JointCoordinates& coordinates, const SolverPosition& position) const
{
  const SinCos varus = sin_cos(coordinates(1));
  const Eigen::Matrix3d axes = floating_axes(coordinates);
  const Eigen::Vector3d t = axes * floating_translation_mm(coordinates);
  const Eigen::Vector3d e1 = Eigen::Vector3d::UnitZ(), e2 = axes.col(0), e3 = axes.col(1),
                        across = axes.col(2);
  const double across_by_varus =
      (coordinates(5) * varus.sin - coordinates(4)) / (varus.cos * varus.cos);  // mm/rad
  Eigen::Matrix<double, 3, 6> omega, u;
  omega << -e1, e2, e3, Eigen::Matrix3d::Zero();
  u.col(0) = (-e1).cross(t);
  u.col(1) = e2.cross(t) + across * across_by_varus;
  u.col(2).setZero();
  u.col(3) = e2;
  u.col(4) = e3 - across * (varus.sin / varus.cos);
  u.col(5) = across / varus.cos;
  const Eigen::Matrix3d R = reference_rotation(position.attitude) * R_solver_joint_;
  Matrix6d twists;
  twists.topRows<3>() = R * omega;
  twists.bottomRows<3>() = R * u;
  return twists;
}

Work work_of(const Loads& loads, const LoadPotential* applied, const SolverPosition& at)
{
  const Eigen::Vector3d t = at.pose.translation_mm, turning_nmm = loads.point_mm.cross(loads.force_n);
  Vector5d constant;
  constant << loads.force_n, loads.moment_nmm + turning_nmm.y(), loads.varus_moment_nmm + turning_nmm.x();
  if (applied != nullptr) constant += applied->constant;
  Vector5d coordinates;
  coordinates << t, at.pose.theta_rad, at.attitude.varus_rad;
  Work work;
  work.work_nmm = constant.dot(coordinates);
  // The wrench whose work is that on theta, on varus and none on flexion: about Y, X and -(0, sin, cos).
  const SinCos varus = sin_cos(at.attitude.varus_rad);
  const Eigen::Vector3d flexion_axis(0.0, varus.sin, varus.cos), force_n = constant.head<3>();
  const double mx = constant(about_varus) - force_n.dot(Eigen::Vector3d::UnitX().cross(t));
  const double my = constant(about_y);
  const double mz = -(varus.sin * my + force_n.dot(flexion_axis.cross(t))) / varus.cos;
  work.wrench << mx, my, mz, force_n;
  if (applied == nullptr) return work;
  const model::JointPlacement placement = model::joint_placement(at.attitude, at.pose);
  for (const LoadPotential::PointForce& force : applied->forces) {
    const Eigen::Vector3d force_S_n = placement.R_S_reference * force.force_reference_n;
    const Eigen::Vector3d p = t + placement.R_S_moving * force.point_moving_mm;
    work.work_nmm += force_S_n.dot(p);
    work.wrench += wrench_of(force_S_n, p, at);
  }
  for (const TensionLine& line : applied->lines) {
    const Eigen::Vector3d p = t + placement.R_S_moving * line.moving_mm;
    const Eigen::Vector3d span_mm = placement.R_S_reference * line.reference_mm - p;
    work.work_nmm -= line.tension_n * span_mm.norm();
    work.wrench += wrench_of(line.tension_n * span_mm.normalized(), p, at);
  }
  return work;
}

namespace {

constexpr double parallel_edges = 1e-6;  // sine of their angle

}  // namespace

FeatureDistance FeatureMeter::operator()(const ContactConstraint& constraint) const
{
  const Eigen::Matrix3d &R_reference = rotations_.of_reference, &R_moving = rotations_.of_moving;
  const Eigen::Vector3d reference_mm = R_reference * constraint.reference_mm;
  const Eigen::Vector3d moving_mm =
      at_.pose.translation_mm + R_moving * Eigen::Vector3d(pivot_mm_ + constraint.moving_mm);
  const Eigen::Vector3d apart_mm = moving_mm - reference_mm;
  FeatureDistance out;
  if (constraint.offset_mm > 0.0) {
    const RoundedContact near = rounded_distance(
        {constraint.kind, constraint.offset_mm, reference_mm, moving_mm,
         R_reference * constraint.reference_direction, R_moving * constraint.moving_direction},
        Eigen::Vector3d::UnitY());
    out.distance_mm = near.mm;
    if (!std::isfinite(near.mm)) return out;
    out.normal = near.normal;
    out.wrench = wrench_of(near.normal, near.moving_mm, at_);
    out.point_mm = near.reference_mm + constraint.reference_offset_mm * near.normal;
    return out;
  }
  out.point_mm = reference_mm;
  switch (constraint.kind) {
    case ContactConstraint::Kind::face_of_reference:
      out.normal = R_reference * constraint.reference_direction;
      out.wrench = wrench_of(out.normal, moving_mm, at_);
      break;
    case ContactConstraint::Kind::face_of_moving:
      out.normal = R_moving * constraint.moving_direction;
      out.wrench = wrench_of(out.normal, reference_mm, at_);
      break;
    default: {
      const Eigen::Vector3d u = R_reference * constraint.reference_direction,
                            v = R_moving * constraint.moving_direction;
      Eigen::Vector3d across = u.cross(v);
      if (across.y() > 0.0) across = -across;
      const double length = across.norm();
      if (length < parallel_edges) {
        out.distance_mm = std::numeric_limits<double>::infinity();
        return out;
      }
      out.normal = across / length;
      out.wrench = wrench_of(out.normal, moving_mm, at_);
      // The normal turns with the moving edge: d(u x v) = u x (omega x v).
      const Eigen::Vector3d side_mm = apart_mm - out.normal.dot(apart_mm) * out.normal;
      const Eigen::Vector3d signed_u = u.cross(v).y() > 0.0 ? Eigen::Vector3d(-u) : u;
      out.wrench.head<3>() += v.cross(side_mm.cross(signed_u)) / length;
      break;
    }
  }
  out.distance_mm = out.normal.dot(apart_mm);
  return out;
}

}  // namespace vrda::solve
