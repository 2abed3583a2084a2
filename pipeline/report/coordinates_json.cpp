// Roles of the joint's coordinates and the loads that hold them, along the spine, for the page.
#include "model/joint_coordinates.hpp"
#include "report/clinical_curve.hpp"
#include "report/model_json.hpp"

namespace vrda::report {

Json coordinates_json(const store::MotionModel& model)
{
  if (!model.coordinates) return nullptr;
  const store::CoordinateSurfaces& c = *model.coordinates;
  const std::vector<Eigen::Index> spine = solved_spine(model);
  Json list = Json::array();
  for (std::size_t q = 0; q < n_joint_coordinates; ++q) {
    const std::vector<double>& loads = is_rotation(q) ? c.holding_moment_nmm : c.holding_force_n;
    std::vector<double> load;
    std::int32_t n_determined = 0, n_solved = 0;
    for (const Eigen::Index cell : spine) {
      const auto row = static_cast<std::size_t>(cell);
      load.push_back(cell < 0 ? nan : loads[3 * row + q % 3]);
      if (cell < 0) continue;
      ++n_solved;
      n_determined += c.determined[n_joint_coordinates * row + q] == 1;
    }
    list.push_back({{"name", joint_coordinate_names[q]},
                    {"role", name_of(static_cast<CoordinateRole>(c.role[q]))},
                    {"solved", n_solved},
                    {"determined", n_determined},
                    {"holding_load", short_numbers(load)}});
  }
  return list;
}

}  // namespace vrda::report
