/// The motion over flexion and varus as polynomials of the joint's two coordinates, for OpenSim's
/// MultivariatePolynomialFunction (schemas/exports.md). Radians and metres.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "store/motion_model.hpp"

namespace vrda::tables {

/// Sum of coefficient * flexion^i * varus^j over i + j <= order, by ascending i, then j: OpenSim's order.
struct BivariatePolynomial {
  int order = 0;
  std::vector<double> coefficients;  ///< [(order + 1) (order + 2) / 2]
};

struct OsimSurfaces {
  std::array<double, 2> flexion_rad{}, varus_rad{};  ///< first and last
  BivariatePolynomial internal_rad;
  std::array<BivariatePolynomial, 3> translation_m;  ///< of the rotation centre, along the reference's axes
};

/// The largest order that is tried, and the error that the order keeps to: metres and radians.
inline constexpr int largest_osim_order = 20;
inline constexpr double osim_surface_error = 1e-7;

/// The surfaces of `set`, interpolated at Chebyshev points of the measured range, with the least order that
/// keeps the neglected terms below osim_surface_error. Throws InputError naming `file` for a set or a model
/// that depends on flexion only, turned axes (Delta other than +Y), an attitude without a pose, and a set
/// that needs a larger order, as one with kinks.
OsimSurfaces osim_surfaces(const store::MotionModel& model, const std::string& file, const std::string& set);

}  // namespace vrda::tables
