#include "solve/free_spine.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/error.hpp"
#include "core/units.hpp"

namespace vrda::solve {
namespace {

// Poses closer than the search's resolutions are the same equilibrium.
constexpr double same_position_mm = 0.1;
constexpr double same_angle_rad = rad_from_deg(0.1);
// Negligible: 1e-6 N mm is 20 N along 5e-8 mm.
constexpr double same_energy_nmm = 1e-6;

bool is_same_equilibrium(const StepRecord& a, const StepRecord& b)
{
  return (a.pose.translation_mm - b.pose.translation_mm).norm() <= same_position_mm &&
         std::abs(a.pose.theta_rad - b.pose.theta_rad) <= same_angle_rad &&
         std::abs(a.varus_rad - b.varus_rad) <= same_angle_rad;
}

}  // namespace

std::vector<SpineOffset> spine_offsets(int n)
{
  constexpr double turn = rad_from_deg(6.0);
  constexpr double shift_mm = 3.0;
  const std::vector<SpineOffset> all{{turn, 0, 0},      {-turn, 0, 0},      {0, shift_mm, 0},
                                     {0, -shift_mm, 0}, {2.0 * turn, 0, 0}, {-2.0 * turn, 0, 0},
                                     {0, 0, shift_mm},  {0, 0, -shift_mm}};
  check(n >= 0 && n <= static_cast<int>(all.size()), "spine_offsets: at most 8");
  return {all.begin(), all.begin() + n};
}

std::vector<SpineOffset> polish_offsets()
{
  // The smaller ones reach equilibria on neighbouring facets, which the larger ones pass over.
  constexpr double rotation_rad = rad_from_deg(0.5), shift_mm = 0.3;
  std::vector<SpineOffset> offsets;
  for (const double size : {1.0, 0.25}) {
    for (const double signed_size : {size, -size}) {
      offsets.push_back({signed_size * rotation_rad, 0, 0});
      offsets.push_back({0, signed_size * shift_mm, 0});
      offsets.push_back({0, 0, signed_size * shift_mm});
    }
  }
  return offsets;
}

FreeSpineStep select_lowest(const std::vector<StepRecord>& ends)
{
  check(!ends.empty(), "lowest_of: no result");
  FreeSpineStep step;
  // Of each equilibrium the first result, by which others are distinguished, and the lowest.
  std::vector<std::pair<const StepRecord*, const StepRecord*>> optima;
  const StepRecord* lowest = nullptr;
  double least_nmm = 0.0, most_nmm = 0.0, least_rad = 0.0, most_rad = 0.0;
  for (const StepRecord& end : ends) {
    if (end.status != StepStatus::stable) continue;
    const double energy_nmm = end.balance.energy_nmm, theta_rad = end.pose.theta_rad;
    const bool is_first = lowest == nullptr;
    if (is_first || energy_nmm < lowest->balance.energy_nmm - same_energy_nmm) lowest = &end;
    least_nmm = is_first ? energy_nmm : std::min(least_nmm, energy_nmm);
    most_nmm = is_first ? energy_nmm : std::max(most_nmm, energy_nmm);
    least_rad = is_first ? theta_rad : std::min(least_rad, theta_rad);
    most_rad = is_first ? theta_rad : std::max(most_rad, theta_rad);
    const auto known = std::find_if(optima.begin(), optima.end(), [&](const auto& other) {
      return is_same_equilibrium(*other.first, end);
    });
    if (known == optima.end()) {
      optima.emplace_back(&end, &end);
    } else if (lowest == &end || energy_nmm < known->second->balance.energy_nmm - same_energy_nmm) {
      known->second = &end;
    }
  }
  step.chosen = lowest == nullptr ? ends.front() : *lowest;
  step.n_optima = static_cast<std::int32_t>(optima.size());
  for (const auto& [first, found] : optima)
    step.equilibria.push_back({found->pose, found->varus_rad, found->balance.energy_nmm, found == lowest});
  step.theta_spread_rad = most_rad - least_rad;
  step.energy_spread_nmm = most_nmm - least_nmm;
  return step;
}

}  // namespace vrda::solve
