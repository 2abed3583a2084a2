#include "analysis/flexion_curves.hpp"

#include <algorithm>

#include "store/solved_cells.hpp"

namespace vrda::analysis {
namespace {

struct CurvesRow {
  const char* name;  ///< how the name of each curve begins
  CurveGroup (*curves_of)(const store::MotionModel&, const std::vector<Pose>&, int n_threads);
};

/// The analyses over flexion.
constexpr CurvesRow all_curves[] = {{"contact_area", contact_area}};

}  // namespace

std::vector<CurveGroup> flexion_curves(const store::MotionModel& model,
                                       const std::vector<Pose>& X_reference_moving, int n_threads)
{
  std::vector<CurveGroup> groups;
  for (const CurvesRow& row : all_curves) {
    groups.push_back(row.curves_of(model, X_reference_moving, n_threads));
    for (const Curve& curve : groups.back().curves)
      check(curve.name.starts_with(row.name), "the name of a curve begins with that of its row");
  }
  return groups;
}

std::vector<CurveGroup> spine_curves(const store::MotionModel& model, int n_threads)
{
  const std::vector<Eigen::Index> spine = store::solved_spine(model);
  std::vector<Pose> poses;
  for (const Eigen::Index cell : spine)
    if (cell >= 0) poses.push_back(store::pose_in(model.X_reference_moving, static_cast<std::size_t>(cell)));
  std::vector<CurveGroup> groups = flexion_curves(model, poses, n_threads);
  for (CurveGroup& group : groups) {
    for (Curve& curve : group.curves) {
      auto next = curve.values.begin();
      std::vector<double> values;
      for (const Eigen::Index cell : spine) values.push_back(cell < 0 ? nan : *next++);
      curve.values = std::move(values);
    }
  }
  return groups;
}

bool is_flexion_curve(std::string_view column)
{
  return std::ranges::any_of(all_curves, [&](const CurvesRow& row) { return column.starts_with(row.name); });
}

}  // namespace vrda::analysis
