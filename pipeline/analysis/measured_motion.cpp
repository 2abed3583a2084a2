#include "analysis/measured_motion.hpp"

#include <algorithm>
#include <boost/math/statistics/univariate_statistics.hpp>
#include <cmath>
#include <limits>

#include "core/error.hpp"
#include "core/text.hpp"
#include "core/units.hpp"

namespace vrda::analysis {
namespace {

// Matrix elements of tables have six digits or more.
constexpr double rigid_tolerance = 1e-5;
// Standard deviation of a normal number over its median absolute deviation.
constexpr double normal_scale = 1.4826022185056018;

std::string text_of(double value)
{
  return shortest_decimal(value);
}

std::string frame_of(const MeasuredMotion& measured, std::size_t k)
{
  return "frame " + std::to_string(k + 1) + " (key " + text_of(measured.key[k]) + ")";
}

void require_noise(const MeasuredMotion& measured, const char* field, const Eigen::Vector3d& deviation,
                   double unit)
{
  for (Eigen::Index k = 0; k < 3; ++k) {
    if (deviation(k) >= 0.0 && std::isfinite(deviation(k))) continue;
    throw InputError({measured.name, field, text_of(deviation(k) / unit), "a finite number, at least 0"});
  }
}

void require_options(const MeasuredMotion& measured, const RepairOptions& options)
{
  require_noise(measured, "--noise-deg", options.noise.rotation_rad, rad_from_deg(1.0));
  require_noise(measured, "--noise-mm", options.noise.translation_mm, 1.0);
  if (options.noise.rotation_rad.isZero(0.0) && options.noise.translation_mm.isZero(0.0)) {
    throw InputError(
        {measured.name, "--noise-mm, --noise-deg", "no noise",
         "standard deviations of the measured translations and rotations; at least one above 0"});
  }
  if (options.smoothing == Smoothing::of_period &&
      !(options.period_frames > 2.0 && std::isfinite(options.period_frames)))
    throw InputError({measured.name, "--smooth", text_of(options.period_frames), "more than 2 frames"});
  if (options.gap_limit == GapLimit::of_length &&
      !(options.gap_limit_mm >= 0.0 && std::isfinite(options.gap_limit_mm)))
    throw InputError(
        {measured.name, "--gap-mm", text_of(options.gap_limit_mm), "a finite number, at least 0"});
}

void require_pose(const MeasuredMotion& measured, std::size_t k)
{
  const Pose& X = measured.X_reference_moving[k];
  if (!X.matrix().allFinite())
    throw InputError(
        {measured.name, frame_of(measured, k), "a pose that is not finite", "12 finite numbers"});
  const Eigen::Matrix3d R = X.linear();
  const double error = (R * R.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  const double volume = R.col(0).cross(R.col(1)).dot(R.col(2));
  if (error > rigid_tolerance || volume < 0.0)
    throw InputError({measured.name, frame_of(measured, k), "a matrix that is not a rotation",
                      "an orthogonal matrix with determinant 1"});
}

double squared(double value)
{
  return value * value;
}

// Standard deviation about `middle` of normal numbers, from the median absolute deviation.
double spread_of(std::vector<double> values, double middle)
{
  for (double& value : values) value = std::abs(value - middle);
  return normal_scale * boost::math::statistics::median(values);
}

}  // namespace

void require_repairable(const MeasuredMotion& measured, const RepairOptions& options)
{
  require_options(measured, options);
  check(measured.key.size() == measured.X_reference_moving.size(), "one key a pose");
  if (measured.key.empty()) throw InputError({measured.name, "frames", "none", "at least one"});
  for (std::size_t k = 0; k < measured.key.size(); ++k) {
    if (!std::isfinite(measured.key[k]))
      throw InputError({measured.name, "key of frame " + std::to_string(k + 1), text_of(measured.key[k]),
                        "a finite number"});
    if (k > 0 && measured.key[k] <= measured.key[k - 1])
      throw InputError({measured.name, "key of frame " + std::to_string(k + 1), text_of(measured.key[k]),
                        "a number above " + text_of(measured.key[k - 1])});
    require_pose(measured, k);
    if (k == 0) continue;
    const Eigen::Matrix3d turn = Eigen::Matrix3d(measured.X_reference_moving[k].linear()) *
                                 measured.X_reference_moving[k - 1].linear().transpose();
    if (turn.trace() > 1.0) continue;  // 1 + 2 cos
    throw InputError({measured.name, frame_of(measured, k), "a rotation of 90 degrees or more since the last",
                      "less between neighbouring frames"});
  }
}

double supported_gap_mm(const std::vector<MeasuredGap>& gaps)
{
  if (gaps.empty()) return std::numeric_limits<double>::infinity();
  std::vector<double> values, differences;
  double noise_sq_mm2 = 0.0;
  for (std::size_t k = 0; k < gaps.size(); ++k) {
    values.push_back(gaps[k].mm);
    noise_sq_mm2 += gaps[k].noise_mm * gaps[k].noise_mm / static_cast<double>(gaps.size());
    if (k >= 2) differences.push_back(gaps[k].mm - 2.0 * gaps[k - 1].mm + gaps[k - 2].mm);
  }
  // Independent errors have second differences with six times their variance; a gap that changes smoothly has
  // smaller ones, and its change is real.
  if (!differences.empty()) noise_sq_mm2 = std::min(noise_sq_mm2, squared(spread_of(differences, 0.0)) / 6.0);
  const double middle = boost::math::statistics::median(values);
  const double real_sq_mm2 = squared(spread_of(values, middle)) - noise_sq_mm2;
  return std::max(0.0, middle) + 2.0 * std::sqrt(std::max(0.0, real_sq_mm2));
}

}  // namespace vrda::analysis
