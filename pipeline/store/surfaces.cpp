#include "store/surfaces.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <functional>
#include <string>

#include "core/error.hpp"
#include "core/units.hpp"

namespace vrda::store {
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

void check_model(const store::MotionModel& model)
{
  const auto rows = static_cast<Eigen::Index>(model.flexion_deg.size());
  const auto columns = static_cast<Eigen::Index>(model.varus_deg.size());
  check(rows > 0 && columns > 0, "a motion model has at least one flexion and one varus");
  check(ascends(model.flexion_deg) && ascends(model.varus_deg), "the axes of a motion model ascend");
  for (const store::GridD* grid : {&model.tx_mm, &model.ty_mm, &model.tz_mm, &model.theta_deg}) {
    check(grid->rows() == rows && grid->cols() == columns,
          "the surfaces of a motion model have the size of its axes");
  }
  check(model.status.rows() == rows && model.status.cols() == columns, "status has the size of the axes");
}

}  // namespace

RawSurfaces raw_surfaces(const store::MotionModel& model)
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

namespace {

constexpr std::array<const char*, 5> names{"tx", "ty", "tz", "theta", "varus"};
constexpr std::size_t varus = 4;

/// Null if the set has no such surface; only varus may be missing.
const store::SmoothedSurface* surface_named(const store::SmoothedSet& set, std::size_t number)
{
  const auto found = std::find_if(set.surfaces.begin(), set.surfaces.end(),
                                  [&](const store::SmoothedSurface& s) { return s.name == names[number]; });
  if (found == set.surfaces.end()) {
    check(number == varus, "a smoothed set has the surfaces tx, ty, tz and theta");
    return nullptr;
  }
  check(found->coefficients.size() == static_cast<std::size_t>(set.exponents.rows()),
        "a smoothed surface has one coefficient per term");
  return &*found;
}

}  // namespace

SmoothedSurfaces smoothed_surfaces(const store::MotionModel& model, const store::SmoothedSet& set)
{
  SmoothedSurfaces result;
  result.ranges = store::axis_ranges(model.flexion_deg, model.varus_deg);
  std::array<const store::SmoothedSurface*, names.size()> surfaces{};
  for (std::size_t number = 0; number < names.size(); ++number) surfaces[number] = surface_named(set, number);
  result.has_varus = surfaces[varus] != nullptr;
  for (Eigen::Index k = 0; k < set.exponents.rows(); ++k) {
    SmoothedTerm term{set.exponents(k, 0), set.exponents(k, 1), {}};
    result.degree = std::max({result.degree, term.flexion_degree, term.varus_degree});
    check(
        std::min(term.flexion_degree, term.varus_degree) >= 0 && result.degree <= store::max_smoothed_degree,
        "the exponents of a smoothed set fit the table of polynomials");
    for (std::size_t number = 0; number < names.size(); ++number) {
      if (surfaces[number] == nullptr) continue;
      const double c = surfaces[number]->coefficients[static_cast<std::size_t>(k)];
      term.coefficient[number] = number < 3 ? c : rad_from_deg(c);
    }
    result.terms.push_back(term);
  }
  return result;
}

PoseAndVarus evaluate(const SmoothedSurfaces& surfaces, const Attitude& attitude)
{
  const double u = store::unit_coordinate(deg_from_rad(attitude.flexion_rad), surfaces.ranges.flexion);
  const double v = store::unit_coordinate(deg_from_rad(attitude.varus_rad), surfaces.ranges.varus);
  const store::LegendreTable P = store::legendre(u, surfaces.degree), Q = store::legendre(v, surfaces.degree);
  PoseAndVarus numbers{};
  for (const SmoothedTerm& term : surfaces.terms) {
    const double basis = P.value[term.flexion_degree] * Q.value[term.varus_degree];
    for (std::size_t number = 0; number < numbers.size(); ++number)
      numbers[number] += term.coefficient[number] * basis;
  }
  return numbers;
}

}  // namespace vrda::store
