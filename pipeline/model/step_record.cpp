#include "model/step_record.hpp"

#include <algorithm>
#include <cmath>

namespace vrda::inline model {
namespace {

/// Upper bound of valid coordinates (mm, rad), as in motion models.
constexpr double largest_pose_number = 1e9;

}  // namespace

bool is_sound(const MovingPose& pose)
{
  return !(pose.translation_mm.array().abs() > largest_pose_number).any() &&
         !(std::abs(pose.theta_rad) > largest_pose_number);
}

bool is_sound(const CoordinateForces& forces)
{
  return std::abs(forces.flexion_rad) <= largest_pose_number &&
         std::all_of(forces.determined.begin(), forces.determined.end(),
                     [](std::int8_t determined) { return determined >= -1 && determined <= 1; });
}

bool is_sound(const StepRecord& record)
{
  return record.status != StepStatus::stable ||
         (record.pose.translation_mm.allFinite() && std::isfinite(record.pose.theta_rad) &&
          std::abs(record.varus_rad) <= largest_pose_number);
}

bool is_sound(const SearchTrace& trace)
{
  return std::find(std::begin(search_step_kinds), std::end(search_step_kinds), trace.key.kind) !=
         std::end(search_step_kinds);
}

StepRecord scaled(const StepRecord& record, double factor)
{
  StepRecord r = record;
  scale_lengths(r, factor);
  for (std::size_t k = 0; r.coordinates && k < n_joint_coordinates; ++k) {
    if (is_rotation(k)) r.coordinates->holding[k] *= factor;
  }
  return r;
}

double prior_value(const PriorTerm& term, double flexion_rad)
{
  const auto above = std::lower_bound(term.flexion_rad.begin(), term.flexion_rad.end(), flexion_rad);
  const auto k = static_cast<std::size_t>(above - term.flexion_rad.begin());
  // A change of shape grows up to 45 degrees, as the spread of the published curves does.
  const double change = term.shape_change * std::min(1.0, std::abs(flexion_rad) / rad_from_deg(45.0));
  if (k == 0) return term.value.front() + change;
  if (k == term.value.size()) return term.value.back() + change;
  const double share =
      (flexion_rad - term.flexion_rad[k - 1]) / (term.flexion_rad[k] - term.flexion_rad[k - 1]);
  return (1.0 - share) * term.value[k - 1] + share * term.value[k] + change;
}

// From a pose to the numbers of a motion step.

SolverPosition solver_position(const SolverFrame& frame, const Pose& X_reference_moving)
{
  // R = Rz(-f) Rx(v) Ry(theta), as in model/coordinates.cpp but about the axes of S.
  const Pose X = X_solver_reference_moving(frame, X_reference_moving);
  const Eigen::Matrix3d R = X.linear();
  SolverPosition result;
  result.attitude = {arc_tangent2(R(0, 1), R(1, 1)), arc_sine(R(2, 1))};
  result.pose.theta_rad = arc_tangent2(-R(2, 0), R(2, 2));
  result.pose.translation_mm = reference_rotation(result.attitude) * X.translation();
  return result;
}

}  // namespace vrda::inline model
