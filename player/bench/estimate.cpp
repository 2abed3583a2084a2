#include "bench/estimate.hpp"

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>

#include "core/units.hpp"
#include "show/settings_text.hpp"
#include "bench/screw.hpp"

namespace vrda::bench {

std::string text(double value, int decimals, const char* unit)
{
  return show::rounded_text(value, decimals) + " " + unit;
}

std::vector<std::string> pose_number_names(const std::string& name)
{
  std::vector<std::string> names;
  for (const char* number : {".shift_x", ".shift_y", ".shift_z", ".turn_x", ".turn_y", ".turn_z"})
    names.push_back(name + number);
  return names;
}

Estimate pose_estimate(const std::string& name, const Pose& X,
                       const Eigen::Matrix<double, 6, 6>& covariance_mm_rad)
{
  const PoseParameters six = pose_parameters_of(X);
  Estimate estimate;
  estimate.names = pose_number_names(name);
  estimate.units = {"mm", "mm", "mm", "deg", "deg", "deg"};
  Eigen::Matrix<double, 6, 1> unit = Eigen::Matrix<double, 6, 1>::Ones();
  unit.tail<3>().setConstant(deg_from_rad(1.0));
  estimate.values.resize(6);
  estimate.values << six.shift_mm, six.turn_rad * deg_from_rad(1.0);
  estimate.covariance = unit.asDiagonal() * covariance_mm_rad * unit.asDiagonal();
  return estimate;
}

double t_95(double dof)
{
  constexpr double normal_95 = 1.959963984540054;
  if (std::isinf(dof)) return normal_95;
  return boost::math::quantile(boost::math::students_t(dof), 0.975);
}

double half_width_95(const Estimate& estimate, Eigen::Index k)
{
  return t_95(estimate.dof) * std::sqrt(estimate.covariance(k, k));
}

int decimals_for(double size)
{
  constexpr int most = 9;
  if (!(size > 0.0) || !std::isfinite(size)) return 3;
  return std::clamp(1 - static_cast<int>(std::floor(std::log10(size))), 0, most);
}

std::string interval_text(const Estimate& estimate, Eigen::Index k)
{
  const double half_width = half_width_95(estimate, k);
  const int decimals = decimals_for(half_width);
  const std::string& unit = estimate.units[static_cast<std::size_t>(k)];
  return show::rounded_text(estimate.values[k], decimals) + " +- " +
         show::rounded_text(half_width, decimals) + (unit.empty() ? "" : " " + unit);
}

void append(Estimate& whole, const Estimate& part)
{
  const Eigen::Index n = whole.values.size(), m = part.values.size();
  whole.dof = n == 0 ? part.dof : std::min(whole.dof, part.dof);
  whole.names.insert(whole.names.end(), part.names.begin(), part.names.end());
  whole.units.insert(whole.units.end(), part.units.begin(), part.units.end());
  Eigen::VectorXd values(n + m);
  values << whole.values, part.values;
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(n + m, n + m);
  covariance.topLeftCorner(n, n) = whole.covariance;
  covariance.bottomRightCorner(m, m) = part.covariance;
  whole.values = values;
  whole.covariance = covariance;
  const auto square_sum = [](const Estimate& e) {
    return e.residual_rms * e.residual_rms * static_cast<double>(e.residuals.size());
  };
  const double sum = square_sum(whole) + square_sum(part);
  whole.residuals.insert(whole.residuals.end(), part.residuals.begin(), part.residuals.end());
  whole.residual_unit = part.residual_unit;
  if (!whole.residuals.empty())
    whole.residual_rms = std::sqrt(sum / static_cast<double>(whole.residuals.size()));
  whole.remarks.insert(whole.remarks.end(), part.remarks.begin(), part.remarks.end());
}

void set_residuals(Estimate& estimate, const std::vector<double>& residuals, const std::string& unit)
{
  double sum_sq = 0.0;
  for (const double residual : residuals) sum_sq += residual * residual;
  estimate.residuals = residuals;
  estimate.residual_unit = unit;
  estimate.residual_rms = residuals.empty() ? 0.0 : std::sqrt(sum_sq / static_cast<double>(residuals.size()));
}

Eigen::Index index_of(const Estimate& estimate, const std::string& name)
{
  const auto found = std::ranges::find(estimate.names, name);
  return found == estimate.names.end() ? -1 : found - estimate.names.begin();
}

}  // namespace vrda::bench
