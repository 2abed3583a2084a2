#include "motion/smoothed_surfaces.hpp"

#include <algorithm>
#include <string>

#include "core/error.hpp"
#include "core/units.hpp"

namespace vrda {
namespace {

using Legendre = std::array<double, highest_smoothed_degree + 1>;

/// P_0 to P_n at x by Bonnet's recurrence.
Legendre legendre(double x)
{
  Legendre P{};
  P[0] = 1.0;
  P[1] = x;
  for (std::size_t k = 1; k + 1 < P.size(); ++k) {
    const auto n = static_cast<double>(k);
    P[k + 1] = ((2.0 * n + 1.0) * x * P[k] - n * P[k - 1]) / (n + 1.0);
  }
  return P;
}

/// x on [-1, 1]; 0 on an axis of one value.
double scaled(double x, double first, double last)
{
  return last > first ? (2.0 * x - first - last) / (last - first) : 0.0;
}

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
  check(!model.flexion_deg.empty() && !model.varus_deg.empty(), "a motion model has at least one attitude");
  SmoothedSurfaces result;
  result.first_flexion_rad = rad_from_deg(model.flexion_deg.front());
  result.last_flexion_rad = rad_from_deg(model.flexion_deg.back());
  result.first_varus_rad = rad_from_deg(model.varus_deg.front());
  result.last_varus_rad = rad_from_deg(model.varus_deg.back());
  const SmoothedSurface* surfaces[4] = {&surface_named(set, "tx"), &surface_named(set, "ty"),
                                        &surface_named(set, "tz"), &surface_named(set, "theta")};
  for (Eigen::Index k = 0; k < set.exponents.rows(); ++k) {
    SmoothedTerm term{set.exponents(k, 0), set.exponents(k, 1), {}};
    check(std::min(term.flexion_degree, term.varus_degree) >= 0 &&
              std::max(term.flexion_degree, term.varus_degree) <= highest_smoothed_degree,
          "the exponents of a smoothed set lie between 0 and 16");
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
  const Legendre P_u =
      legendre(scaled(attitude.flexion_rad, surfaces.first_flexion_rad, surfaces.last_flexion_rad));
  const Legendre P_v =
      legendre(scaled(attitude.varus_rad, surfaces.first_varus_rad, surfaces.last_varus_rad));
  PoseNumbers numbers{};
  for (const SmoothedTerm& term : surfaces.terms) {
    const double basis =
        P_u[static_cast<std::size_t>(term.flexion_degree)] * P_v[static_cast<std::size_t>(term.varus_degree)];
    for (std::size_t number = 0; number < 4; ++number) numbers[number] += term.coefficient[number] * basis;
  }
  return numbers;
}

}  // namespace vrda
