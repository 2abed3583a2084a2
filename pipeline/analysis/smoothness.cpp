#include "analysis/smoothness.hpp"

#include <cmath>
#include <limits>

#include "core/error.hpp"
#include "core/trig.hpp"
#include "core/units.hpp"
#include "analysis/band_matrix.hpp"

namespace vrda::analysis {
namespace {

// Weights tried: periods of half amplitude from 2.4 frames to 12,000.
constexpr double least_weight = 0.0625, largest_weight = 1099511627776.0 * 16.0;

// Coefficients of the values before, at and after frame k.
std::array<double, 3> coefficients(const std::vector<double>& key, std::size_t k)
{
  const double spacing = (key.back() - key.front()) / static_cast<double>(key.size() - 1);
  const double before = (key[k] - key[k - 1]) / spacing, after = (key[k + 1] - key[k]) / spacing;
  const double mean = 0.5 * (before + after);
  return {1.0 / (before * mean), -1.0 / (before * mean) - 1.0 / (after * mean), 1.0 / (after * mean)};
}

// Inverse left Jacobian of SO(3) at v; with -v the inverse right one. The error is v^4 / 720.
Eigen::Matrix3d inverse_left_jacobian(const Eigen::Vector3d& v)
{
  const Eigen::Matrix3d K = cross_matrix(v);
  return Eigen::Matrix3d::Identity() - 0.5 * K + K * K / 12.0;
}

Vector6d first_difference(const Pose& from, const Pose& to)
{
  Vector6d out;
  out << rotation_vector(Eigen::Matrix3d(to.linear()) * from.linear().transpose()),
      to.translation() - from.translation();
  return out;
}

Vector6d in_noise_units(const Vector6d& twist, const NoiseScale& scale)
{
  Vector6d out;
  out << scale.inverse_rotation * twist.head<3>(), scale.inverse_translation * twist.tail<3>();
  return out;
}

double sum(const std::vector<double>& values)
{
  double total = 0.0;
  for (const double value : values) total += value;
  return total;
}

// I + weight D^T D, factorised.
BandMatrix smoother(const std::vector<double>& key, double weight)
{
  const auto n = static_cast<Eigen::Index>(key.size());
  BandMatrix matrix(n, 2);
  for (Eigen::Index i = 0; i < n; ++i) matrix.at(i, i) = 1.0;
  for (Eigen::Index k = 1; k + 1 < n; ++k) {
    const std::array<double, 3> c = coefficients(key, static_cast<std::size_t>(k));
    for (Eigen::Index i = 0; i < 3; ++i) {
      for (Eigen::Index j = 0; j <= i; ++j)
        matrix.at(k - 1 + i, k - 1 + j) +=
            weight * c[static_cast<std::size_t>(i)] * c[static_cast<std::size_t>(j)];
    }
  }
  matrix.factorise();
  return matrix;
}

}  // namespace

std::vector<SecondDifference> second_differences(const std::vector<double>& key, const std::vector<Pose>& X,
                                                 const std::vector<Vector6d>& twist, const NoiseScale& scale)
{
  std::vector<SecondDifference> out;
  for (std::size_t k = 1; k + 1 < X.size(); ++k) {
    const std::array<double, 3> c = coefficients(key, k);
    const Vector6d before = first_difference(X[k - 1], X[k]), after = first_difference(X[k], X[k + 1]);
    SecondDifference difference;
    difference.frame = k;
    difference.value = in_noise_units(c[2] * after - c[0] * before, scale);
    const Eigen::Matrix3d at_before = inverse_left_jacobian(-Eigen::Vector3d(before.head<3>()));
    const Eigen::Matrix3d after_before = inverse_left_jacobian(before.head<3>());
    const Eigen::Matrix3d at_after = inverse_left_jacobian(-Eigen::Vector3d(after.head<3>()));
    const Eigen::Matrix3d after_after = inverse_left_jacobian(after.head<3>());
    const std::array<Eigen::Matrix3d, 3> turn = {c[0] * at_before, -c[2] * at_after - c[0] * after_before,
                                                 c[2] * after_after};
    for (std::size_t i = 0; i < 3; ++i) {
      Matrix6d& J = difference.jacobian[i];
      J.setZero();
      J.topLeftCorner<3, 3>() = scale.inverse_rotation * turn[i] * turn_per_twist(twist[k - 1 + i], scale);
      J.bottomRightCorner<3, 3>() = c[i] * (scale.inverse_translation * scale.translation);
    }
    out.push_back(difference);
  }
  return out;
}

Vector6d weights_from_noise(const std::vector<double>& key, const std::vector<Pose>& X_measured,
                            const NoiseScale& scale)
{
  Vector6d weights = Vector6d::Zero();
  const std::size_t n = key.size();
  if (n < 3) return weights;
  std::vector<Vector6d> path(n, Vector6d::Zero());
  for (std::size_t k = 1; k < n; ++k)
    path[k] = path[k - 1] + in_noise_units(first_difference(X_measured[k - 1], X_measured[k]), scale);
  Vector6d best = Vector6d::Constant(2.0 * static_cast<double>(n));
  for (double weight = least_weight; weight <= largest_weight; weight *= 2.0) {
    const BandMatrix matrix = smoother(key, weight);
    const double trace = sum(matrix.inverse_diagonal());
    for (Eigen::Index c = 0; c < 6; ++c) {
      std::vector<double> values(n);
      for (std::size_t k = 0; k < n; ++k) values[k] = path[k](c);
      const std::vector<double> smooth = matrix.solve(values);
      double score = 2.0 * trace;
      for (std::size_t k = 0; k < n; ++k) score += (values[k] - smooth[k]) * (values[k] - smooth[k]);
      if (score >= best(c)) continue;
      best(c) = score;
      weights(c) = weight;
    }
  }
  for (Eigen::Index c = 0; c < 3; ++c) {
    if (scale.inverse_rotation.row(c).isZero(0.0)) weights(c) = 0.0;
    if (scale.inverse_translation.row(c).isZero(0.0)) weights(c + 3) = 0.0;
  }
  return weights;
}

double weight_of_period(double period_frames)
{
  check(period_frames > 2.0, "a period of half amplitude is above two frames");
  const double s = 2.0 * sine(pi / period_frames);
  return 1.0 / (s * s * s * s);
}

double period_of_weight(double weight)
{
  if (weight <= 0.0) return 2.0;
  const double half = 0.5 / std::sqrt(std::sqrt(weight));
  return half >= 1.0 ? 2.0 : pi / arc_sine(half);
}

}  // namespace vrda::analysis
