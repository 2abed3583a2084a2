#include "analysis/flexion_curves.hpp"

#include <algorithm>

#include "core/units.hpp"
#include "store/solved_cells.hpp"

namespace vrda::analysis {
namespace {

struct CurvesRow {
  const char* name;  ///< how the name of each curve begins
  std::vector<CurveGroup> (*curves_of)(const store::MotionModel&, const std::vector<store::JointPose>&,
                                       int n_threads);
};

/// The analyses over flexion.
constexpr CurvesRow all_curves[] = {{"contact_area", contact_area}, {"follower", follower_curves}};

}  // namespace

std::vector<CurveGroup> flexion_curves(const store::MotionModel& model,
                                       const std::vector<store::JointPose>& poses, int n_threads)
{
  std::vector<CurveGroup> groups;
  for (const CurvesRow& row : all_curves) {
    for (CurveGroup& group : row.curves_of(model, poses, n_threads)) {
      for (const Curve& curve : group.curves)
        check(curve.name.starts_with(row.name), "the name of a curve begins with that of its row");
      groups.push_back(std::move(group));
    }
  }
  return groups;
}

std::vector<CurveGroup> spine_curves(const store::MotionModel& model, int n_threads)
{
  const std::vector<Eigen::Index> spine = store::solved_spine(model);
  const store::Motion motion(model, "raw");
  const auto n_varus = static_cast<Eigen::Index>(model.varus_deg.size());
  std::vector<store::JointPose> poses;
  for (const Eigen::Index cell : spine) {
    if (cell < 0) continue;
    const auto flexion = static_cast<std::size_t>(cell / n_varus),
               varus = static_cast<std::size_t>(cell % n_varus);
    poses.push_back(motion.is_sequence() ? motion.at_frame(motion.keys()[flexion])
                                         : motion.at({rad_from_deg(model.flexion_deg[flexion]),
                                                      rad_from_deg(model.varus_deg[varus])}));
    poses.back().X_reference_moving =
        store::pose_in(model.X_reference_moving, static_cast<std::size_t>(cell));
  }
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
