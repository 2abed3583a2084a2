#include "model/step_record.hpp"

#include <algorithm>
#include <cmath>

#include "core/axis.hpp"

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
  // A change of shape grows up to 45 degrees, as the spread of the published curves does.
  const double change = term.shape_change * std::min(1.0, std::abs(flexion_rad) / rad_from_deg(45.0));
  return linear_at(term.value, position_on(term.flexion_rad, flexion_rad)) + change;
}

}  // namespace vrda::inline model
