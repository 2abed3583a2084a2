#include "solve/potential.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "solve/quadratic_program.hpp"

namespace vrda::solve {
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

}  // namespace vrda::solve
