#include "reduce/varus_choice.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/units.hpp"

namespace vrda {
namespace {

// A mean of two columns that misses a third by no more than this is that column: rounding of degrees.
constexpr double same_varus_deg = 1e-9;

/// One flexion of the grid.
struct Row {
  const MotionModel& model;
  Eigen::Index flexion;
  double spine_varus_deg;

  Eigen::Index n_columns() const { return model.status.cols(); }
  double varus_deg(Eigen::Index j) const { return model.varus_deg[static_cast<std::size_t>(j)]; }
  bool is_solved(Eigen::Index j) const { return model.status(flexion, j) == status_stable; }
  bool touches_with_both(Eigen::Index j) const
  {
    return model.contact_medial(flexion, j) == 1 && model.contact_lateral(flexion, j) == 1;
  }
  /// NaN where a compartment faces nothing.
  double imbalance_mm(Eigen::Index j) const
  {
    return model.gap_medial_mm(flexion, j) - model.gap_lateral_mm(flexion, j);
  }
};

struct Run {
  Eigen::Index first, last;
};

/// Columns that touch with both, parted by solved ones that do not.
std::vector<Run> touching_runs(const Row& row)
{
  std::vector<Run> runs;
  bool is_open = false;
  for (Eigen::Index j = 0; j < row.n_columns(); ++j) {
    if (!row.is_solved(j)) continue;
    const bool touches = row.touches_with_both(j);
    if (touches && is_open) runs.back().last = j;
    if (touches && !is_open) runs.push_back({j, j});
    is_open = touches;
  }
  return runs;
}

double distance_deg(const Row& row, const Run& run)
{
  return std::max(
      {row.varus_deg(run.first) - row.spine_varus_deg, 0.0, row.spine_varus_deg - row.varus_deg(run.last)});
}

/// Puts `varus_deg`, which lies between solved columns, among them.
VarusChoice placed(const Row& row, ZeroVarusSource source, double varus_deg)
{
  VarusChoice choice;
  choice.source = source;
  choice.varus_deg = varus_deg;
  for (Eigen::Index j = row.n_columns(); j-- > 0;) {
    if (row.is_solved(j) && row.varus_deg(j) >= varus_deg - same_varus_deg) choice.after = j;
  }
  for (Eigen::Index j = 0; j < row.n_columns(); ++j) {
    if (row.is_solved(j) && row.varus_deg(j) <= varus_deg + same_varus_deg) choice.before = j;
  }
  const double before_deg = row.varus_deg(choice.before), after_deg = row.varus_deg(choice.after);
  if (choice.before != choice.after) choice.share_after = (varus_deg - before_deg) / (after_deg - before_deg);
  return choice;
}

VarusChoice mean_of(const Row& row, const std::vector<Run>& runs)
{
  const Run run = *std::min_element(runs.begin(), runs.end(), [&](const Run& a, const Run& b) {
    return distance_deg(row, a) < distance_deg(row, b);
  });
  const double first_deg = row.varus_deg(run.first), last_deg = row.varus_deg(run.last);
  VarusChoice choice = placed(row, ZeroVarusSource::both_touch, 0.5 * (first_deg + last_deg));
  choice.first_deg = first_deg;
  choice.last_deg = last_deg;
  return choice;
}

/// Varus of every change of sign, ascending.
std::vector<double> balanced_deg(const Row& row)
{
  std::vector<double> roots_deg;
  std::optional<Eigen::Index> before;
  for (Eigen::Index j = 0; j < row.n_columns(); ++j) {
    if (!row.is_solved(j) || std::isnan(row.imbalance_mm(j))) continue;
    const double here_mm = row.imbalance_mm(j);
    if (here_mm == 0.0) roots_deg.push_back(row.varus_deg(j));
    const double before_mm = before ? row.imbalance_mm(*before) : here_mm;
    if (before_mm * here_mm < 0.0) {
      const double width_deg = row.varus_deg(j) - row.varus_deg(*before);
      roots_deg.push_back(row.varus_deg(*before) + width_deg * (before_mm / (before_mm - here_mm)));
    }
    before = j;
  }
  return roots_deg;
}

VarusChoice given_varus_choice(const Row& row)
{
  const std::vector<Run> runs = touching_runs(row);
  if (!runs.empty()) return mean_of(row, runs);
  const std::vector<double> roots_deg = balanced_deg(row);
  if (roots_deg.empty()) return {};
  const double nearest_deg = *std::min_element(roots_deg.begin(), roots_deg.end(), [&](double a, double b) {
    return std::abs(a - row.spine_varus_deg) < std::abs(b - row.spine_varus_deg);
  });
  return placed(row, ZeroVarusSource::interpolated, nearest_deg);
}

VarusChoice free_varus_choice(const Row& row)
{
  VarusChoice choice;
  if (!row.is_solved(0)) return choice;
  choice.source = ZeroVarusSource::free;
  choice.varus_deg = row.model.varus_solved_deg(row.flexion, 0);
  return choice;
}

}  // namespace

std::vector<VarusChoice> varus_choices(const MotionModel& model, const Motion& raw)
{
  std::vector<VarusChoice> choices;
  for (Eigen::Index i = 0; i < model.status.rows(); ++i) {
    const double flexion_rad = rad_from_deg(model.flexion_deg[static_cast<std::size_t>(i)]);
    const Row row{model, i, deg_from_rad(raw.balanced_varus_rad(flexion_rad))};
    choices.push_back(raw.is_varus_free() ? free_varus_choice(row) : given_varus_choice(row));
  }
  return choices;
}

}  // namespace vrda
