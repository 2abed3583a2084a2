#include "player/calibration/fit_support.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "bench/rigid_body.hpp"
#include "core/units.hpp"

namespace vrda::test {

void Coverage::add(const std::string& name, double error, double half_width)
{
  // Both eyes are pooled, which doubles the number of cases.
  const bool is_left = name.starts_with("left."), is_right = name.starts_with("right.");
  Count& count = counts_[is_left || is_right ? "an eye's" + name.substr(name.find('.')) : name];
  ++count.n;
  if (std::abs(error) <= half_width) ++count.n_within;
}

void Coverage::add(const bench::Estimate& estimate, const Eigen::VectorXd& error)
{
  ASSERT_LE(error.size(), estimate.values.size());
  for (Eigen::Index k = 0; k < error.size(); ++k)
    add(estimate.names[static_cast<std::size_t>(k)], error(k), bench::half_width_95(estimate, k));
}

void Coverage::expect_honest() const
{
  EXPECT_FALSE(counts_.empty());
  for (const auto& [name, count] : counts_) {
    const double share = static_cast<double>(count.n_within) / count.n;
    EXPECT_GE(share, 0.90) << name << ", " << count.n << " cases";
    EXPECT_LE(share, 0.98) << name << ", " << count.n << " cases";
  }
}

Eigen::VectorXd place_error(const Pose& X_found, const Pose& X_true)
{
  Eigen::VectorXd error(6);
  error << X_found.translation() - X_true.translation(),
      bench::turn_of(X_found.linear() * X_true.linear().transpose()) * deg_from_rad(1.0);
  return error;
}

double Noise::uniform()
{
  constexpr double unit = 1.0 / 9007199254740992.0;  // 2^-53
  return static_cast<double>(bits_() >> 11U) * unit;
}

double Noise::normal()
{
  double sum = -6.0;
  for (int i = 0; i < 12; ++i) sum += uniform();
  return sum;
}

Eigen::VectorXd Noise::normals(Eigen::Index n)
{
  Eigen::VectorXd values(n);
  for (double& value : values) value = normal();
  return values;
}

calibration::JointCurve knee_curve()
{
  calibration::JointCurve curve;
  curve.centre_mm = {5.0, -3.0, 2.0};
  curve.step_rad = rad_from_deg(3.0);
  for (int k = 0; k <= 30; ++k) {
    const double flexion_rad = k * curve.step_rad, share = k / 30.0;
    const Eigen::Matrix3d R = rotation_z(-flexion_rad) * rotation_x(rad_from_deg(3.0) * share * share) *
                              rotation_y(rad_from_deg(15.0) * std::sqrt(share + 0.01));
    const Eigen::Vector3d at_mm(-12.0 * share * share, 3.0 * share * (1.0 - share), 2.0 * share);
    calibration::JointCurve::Knot knot;
    knot << at_mm + curve.centre_mm - R * curve.centre_mm, bench::turn_of(R);
    curve.knots.push_back(knot);
  }
  return curve;
}

}  // namespace vrda::test
