#include "tables/osim_surfaces.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "model/side.hpp"
#include "core/text.hpp"
#include "core/trig.hpp"
#include "store/poses.hpp"

namespace vrda::tables {
namespace {

// More points than the largest order: the terms between show whether the series has ended.
constexpr int n_nodes = largest_osim_order + 6;
using Terms = Eigen::Matrix<double, n_nodes, n_nodes>;  // (degree in flexion, degree in varus)

struct Range {
  double first_rad, last_rad;
  double middle() const { return 0.5 * (first_rad + last_rad); }
  double half() const { return 0.5 * (last_rad - first_rad); }
};

/// cos(degree * angle of the k-th Chebyshev point).
double chebyshev(int degree, int k)
{
  return cosine(pi * degree * (2 * k + 1) / (2.0 * n_nodes));
}

/// Internal rotation (rad) and translation of the rotation centre (m).
using Values = std::array<double, 4>;

Values values_at(const store::MotionModel& model, const store::Motion& motion, const std::string& file,
                 const Attitude& attitude)
{
  const store::JointPose pose = motion.at(attitude);
  if (pose.status != store::PoseStatus::solved) {
    throw InputError({file, "status",
                      std::string("no pose at flexion ") +
                          shortest_decimal(deg_from_rad(attitude.flexion_rad)) + ", varus " +
                          shortest_decimal(deg_from_rad(attitude.varus_rad)) + " degrees",
                      "a pose at every attitude for --varus driven; a smoothed set has one"});
  }
  const Eigen::Vector3d& centre_mm = model.rotation_centre_mm;
  const Pose& X = pose.X_reference_moving;
  const Eigen::Vector3d t_m = metres_per_mm * (X * centre_mm - centre_mm);
  // About Delta = +Y theta is the internal rotation, without its wraps.
  const double internal_rad =
      clinical_coordinates(X, side_named(model.side), centre_mm).internal_rotation_rad;
  return {nearest_turn(internal_rad, pose.theta_rad), t_m.x(), t_m.y(), t_m.z()};
}

/// Discrete Chebyshev transform of the values at all pairs of points.
Terms terms_of(const Terms& values)
{
  Terms basis;  // (degree, point)
  for (int degree = 0; degree < n_nodes; ++degree)
    for (int k = 0; k < n_nodes; ++k)
      basis(degree, k) = (degree == 0 ? 1.0 : 2.0) / n_nodes * chebyshev(degree, k);
  return basis * values * basis.transpose();
}

/// The least order whose neglected terms sum to at most the error; largest_osim_order + 1 if all are larger.
int order_of(const Terms& terms)
{
  std::array<double, 2 * n_nodes> of_order{};
  for (int i = 0; i < n_nodes; ++i)
    for (int j = 0; j < n_nodes; ++j) of_order[static_cast<std::size_t>(i + j)] += std::abs(terms(i, j));
  double neglected = 0.0;
  int order = 2 * n_nodes - 2;
  while (order > 0 && neglected + of_order[static_cast<std::size_t>(order)] <= osim_surface_error)
    neglected += of_order[static_cast<std::size_t>(order--)];
  // OpenSim's derivative of a constant fails.
  return std::clamp(order, 1, largest_osim_order + 1);
}

/// Coefficients by power of T_degree((x - middle) / half), a row each.
Terms powers_of(const Range& range)
{
  const double scale = 1.0 / range.half(), shift = -range.middle() / range.half();
  Terms powers = Terms::Zero();
  powers(0, 0) = 1.0;
  powers(1, 0) = shift;
  powers(1, 1) = scale;
  for (int degree = 2; degree < n_nodes; ++degree) {
    for (int k = 0; k < n_nodes; ++k) {
      const double times_x = k > 0 ? powers(degree - 1, k - 1) : 0.0;
      powers(degree, k) = 2.0 * (scale * times_x + shift * powers(degree - 1, k)) - powers(degree - 2, k);
    }
  }
  return powers;
}

BivariatePolynomial polynomial_of(Terms terms, const Range& flexion, const Range& varus)
{
  BivariatePolynomial result;
  result.order = order_of(terms);
  for (int i = 0; i < n_nodes; ++i)
    for (int j = 0; j < n_nodes; ++j)
      if (i + j > result.order) terms(i, j) = 0.0;
  const Terms coefficients = powers_of(flexion).transpose() * terms * powers_of(varus);
  for (int i = 0; i <= result.order; ++i)
    for (int j = 0; i + j <= result.order; ++j) result.coefficients.push_back(coefficients(i, j));
  return result;
}

void require_surfaces(const store::MotionModel& model, const store::Motion& motion, const std::string& file,
                      const std::string& set)
{
  constexpr const char* wanted = "a smoothed set (degree_N) over a range of varus";
  if (model.frames || motion.is_varus_free() || model.varus_deg.size() < 2 || model.flexion_deg.size() < 2)
    throw InputError({file, "--varus", "driven, of a model over flexion only", wanted});
  if (set == "two_sided" || set == "zero_varus")
    throw InputError(
        {file, "--varus", "driven, of the set " + set + ", which depends on flexion only", wanted});
  if (store::has_turned_axes(model))
    throw InputError({file, "--varus", "driven, with a Delta other than proximal",
                      "Delta = +Y: the joint's angles are then those of the grid"});
}

}  // namespace

OsimSurfaces osim_surfaces(const store::MotionModel& model, const std::string& file, const std::string& set)
{
  const store::Motion motion(model, set);
  require_surfaces(model, motion, file, set);
  const Range flexion{motion.first_flexion_rad(), motion.last_flexion_rad()};
  const Range varus{motion.first_varus_rad(), motion.last_varus_rad()};
  std::array<Terms, 4> values;
  for (int i = 0; i < n_nodes; ++i) {
    for (int j = 0; j < n_nodes; ++j) {
      const Attitude attitude{flexion.middle() + flexion.half() * chebyshev(1, i),
                              varus.middle() + varus.half() * chebyshev(1, j)};
      const Values at = values_at(model, motion, file, attitude);
      for (std::size_t k = 0; k < at.size(); ++k) values[k](i, j) = at[k];
    }
  }
  OsimSurfaces result;
  result.flexion_rad = {flexion.first_rad, flexion.last_rad};
  result.varus_rad = {varus.first_rad, varus.last_rad};
  for (std::size_t k = 0; k < values.size(); ++k) {
    BivariatePolynomial polynomial = polynomial_of(terms_of(values[k]), flexion, varus);
    if (polynomial.order > largest_osim_order) {
      throw InputError({file, "--set", set + ", which is not smooth enough",
                        "a smoothed set: polynomials of order " + std::to_string(largest_osim_order) +
                            " must describe it within 1e-7 m and rad"});
    }
    (k == 0 ? result.internal_rad : result.translation_m[k - 1]) = std::move(polynomial);
  }
  return result;
}

}  // namespace vrda::tables
