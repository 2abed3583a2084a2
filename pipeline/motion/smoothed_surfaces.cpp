#include "motion/smoothed_surfaces.hpp"

#include <algorithm>
#include <string>

#include "core/error.hpp"
#include "core/units.hpp"

namespace vrda {
namespace {

const SmoothedSurface& surface_named(const SmoothedSet& set, const std::string& name)
{
  const auto found = std::find_if(set.surfaces.begin(), set.surfaces.end(),
                                  [&](const SmoothedSurface& surface) { return surface.name == name; });
  check(found != set.surfaces.end(), "a smoothed set has the surfaces tx, ty, tz and theta");
  check(found->coefficients.size() == static_cast<std::size_t>(set.exponents.rows()),
        "a smoothed surface has one coefficient a term");
  return *found;
}

}  // namespace

SmoothedSurfaces smoothed_surfaces(const MotionModel& model, const SmoothedSet& set)
{
  SmoothedSurfaces result;
  result.ranges = axis_ranges(model.flexion_deg, model.varus_deg);
  const SmoothedSurface* surfaces[4] = {&surface_named(set, "tx"), &surface_named(set, "ty"),
                                        &surface_named(set, "tz"), &surface_named(set, "theta")};
  for (Eigen::Index k = 0; k < set.exponents.rows(); ++k) {
    SmoothedTerm term{set.exponents(k, 0), set.exponents(k, 1), {}};
    result.degree = std::max({result.degree, term.flexion_degree, term.varus_degree});
    check(std::min(term.flexion_degree, term.varus_degree) >= 0 && result.degree <= largest_smoothed_degree,
          "the exponents of a smoothed set fit the table of polynomials");
    for (std::size_t number = 0; number < 4; ++number) {
      term.coefficient[number] = surfaces[number]->coefficients[static_cast<std::size_t>(k)];
    }
    term.coefficient[3] = rad_from_deg(term.coefficient[3]);
    result.terms.push_back(term);
  }
  return result;
}

PoseNumbers evaluate(const SmoothedSurfaces& surfaces, const Attitude& attitude)
{
  const double u = unit_coordinate(deg_from_rad(attitude.flexion_rad), surfaces.ranges.flexion);
  const double v = unit_coordinate(deg_from_rad(attitude.varus_rad), surfaces.ranges.varus);
  const LegendreTable P = legendre(u, surfaces.degree), Q = legendre(v, surfaces.degree);
  PoseNumbers numbers{};
  for (const SmoothedTerm& term : surfaces.terms) {
    const double basis = P.value[term.flexion_degree] * Q.value[term.varus_degree];
    for (std::size_t number = 0; number < 4; ++number) numbers[number] += term.coefficient[number] * basis;
  }
  return numbers;
}

}  // namespace vrda
