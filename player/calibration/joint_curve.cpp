#include "calibration/joint_curve.hpp"

#include <algorithm>
#include <cmath>

#include "bench/estimate.hpp"
#include "core/units.hpp"
#include "bench/screw.hpp"

namespace vrda::calibration {
namespace {

constexpr std::size_t n_leading = 5, n_coordinates = 6;

/// Derivative at a knot by one step.
JointCurve::Knot slope_at(const std::vector<JointCurve::Knot>& knots, std::size_t k)
{
  const std::size_t before = k == 0 ? 0 : k - 1, after = std::min(k + 1, knots.size() - 1);
  return (knots[after] - knots[before]) / static_cast<double>(after - before);
}

JointCurve::Knot coordinates_at(const JointCurve& curve, double flexion_rad)
{
  const double at = (flexion_rad - curve.first_rad) / curve.step_rad;
  const double last = static_cast<double>(curve.knots.size() - 1);
  if (at <= 0.0) return curve.knots.front() + at * slope_at(curve.knots, 0);
  if (at >= last) return curve.knots.back() + (at - last) * slope_at(curve.knots, curve.knots.size() - 1);
  const auto k = std::min(static_cast<std::size_t>(at), curve.knots.size() - 2);
  const double s = at - static_cast<double>(k), r = 1.0 - s;
  return r * r * (1.0 + 2.0 * s) * curve.knots[k] + s * s * (1.0 + 2.0 * r) * curve.knots[k + 1] +
         s * r * r * slope_at(curve.knots, k) - s * s * r * slope_at(curve.knots, k + 1);
}

}  // namespace

Pose JointCurve::at(double flexion_rad) const
{
  const Knot six = coordinates_at(*this, flexion_rad);
  Pose X = Pose::Identity();
  X.linear() = bench::rotation_of(six.tail<3>());
  X.translation() = six.head<3>();
  return X;
}

JointCurve scaled(const JointCurve& curve, double scale)
{
  JointCurve result = curve;
  result.centre_mm *= scale;
  for (JointCurve::Knot& knot : result.knots) knot.head<3>() *= scale;
  return result;
}

std::vector<double> numbers_of(const JointCurve& curve)
{
  std::vector<double> numbers(curve.centre_mm.begin(), curve.centre_mm.end());
  numbers.push_back(deg_from_rad(curve.first_rad));
  numbers.push_back(deg_from_rad(curve.step_rad));
  for (const JointCurve::Knot& knot : curve.knots) {
    for (Eigen::Index k = 0; k < knot.size(); ++k) numbers.push_back(k < 3 ? knot[k] : deg_from_rad(knot[k]));
  }
  return numbers;
}

JointCurve joint_curve_of(std::span<const double> numbers, const std::string& field, const std::string& file)
{
  const bool is_whole = numbers.size() >= n_leading + 2 * n_coordinates &&
                        (numbers.size() - n_leading) % n_coordinates == 0 &&
                        std::ranges::all_of(numbers, [](double x) { return std::isfinite(x); });
  if (!is_whole || !(numbers[4] > 0.0)) {
    bench::FitErrorContext{"", file}.fail(
        field, std::to_string(numbers.size()) + " numbers",
        "the joint's motion: centre, first flexion, step above 0, then two or more poses");
  }
  JointCurve curve;
  curve.centre_mm = Eigen::Vector3d::Map(numbers.data());
  curve.first_rad = rad_from_deg(numbers[3]);
  curve.step_rad = rad_from_deg(numbers[4]);
  for (std::size_t at = n_leading; at < numbers.size(); at += n_coordinates) {
    curve.knots.emplace_back(JointCurve::Knot::Map(numbers.data() + at));
    curve.knots.back().tail<3>() *= rad_from_deg(1.0);
  }
  return curve;
}

}  // namespace vrda::calibration
