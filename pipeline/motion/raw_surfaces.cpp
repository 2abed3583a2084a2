#include "motion/raw_surfaces.hpp"

#include <algorithm>
#include <cstddef>
#include <functional>

#include "core/error.hpp"
#include "core/units.hpp"

namespace vrda {
namespace {

std::vector<double> radians(const std::vector<double>& angles_deg)
{
  std::vector<double> angles_rad;
  angles_rad.reserve(angles_deg.size());
  for (const double angle_deg : angles_deg) angles_rad.push_back(rad_from_deg(angle_deg));
  return angles_rad;
}

bool ascends(const std::vector<double>& axis)
{
  return std::adjacent_find(axis.begin(), axis.end(), std::greater_equal<>()) == axis.end();
}

void check_model(const MotionModel& model)
{
  const auto rows = static_cast<Eigen::Index>(model.flexion_deg.size());
  const auto columns = static_cast<Eigen::Index>(model.varus_deg.size());
  check(rows > 0 && columns > 0, "a motion model has at least one flexion and one varus");
  check(ascends(model.flexion_deg) && ascends(model.varus_deg), "the axes of a motion model ascend");
  for (const GridD* grid : {&model.tx_mm, &model.ty_mm, &model.tz_mm, &model.theta_deg}) {
    check(grid->rows() == rows && grid->cols() == columns,
          "the surfaces of a motion model have the size of its axes");
  }
  check(model.status.rows() == rows && model.status.cols() == columns, "status has the size of the axes");
}

}  // namespace

RawSurfaces raw_surfaces(const MotionModel& model)
{
  check_model(model);
  RawSurfaces surfaces{radians(model.flexion_deg), radians(model.varus_deg), {}};
  const std::size_t n_flexion = surfaces.flexion_rad.size(), n_varus = surfaces.varus_rad.size();
  surfaces.nodes.resize(n_flexion * n_varus);
  for (std::size_t i = 0; i < n_flexion; ++i) {
    for (std::size_t j = 0; j < n_varus; ++j) {
      const auto row = static_cast<Eigen::Index>(i), column = static_cast<Eigen::Index>(j);
      if (model.status(row, column) != status_stable) continue;
      RawNode& node = surfaces.nodes[i * n_varus + j];
      node.is_solved = true;
      node.value = {model.tx_mm(row, column), model.ty_mm(row, column), model.tz_mm(row, column),
                    rad_from_deg(model.theta_deg(row, column))};
    }
  }
  set_slopes(surfaces);
  return surfaces;
}

}  // namespace vrda
