#include "analysis/statistics.hpp"

#include <cmath>

#include "core/error.hpp"

namespace vrda::analysis {
namespace {

double mean_of(const std::vector<double>& values)
{
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

/// Sum of the products of both quantities' deviations from their means.
double joint_deviation(const std::vector<double>& a, const std::vector<double>& b)
{
  const double mean_a = mean_of(a), mean_b = mean_of(b);
  double sum = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) sum += (a[k] - mean_a) * (b[k] - mean_b);
  return sum;
}

/// Whether the deviations from the mean are more than its rounding.
bool varies(const std::vector<double>& values)
{
  double largest = 0.0;
  for (const double value : values) largest = std::max(largest, std::abs(value));
  const double rounding = 1e-14 * largest;
  return joint_deviation(values, values) > static_cast<double>(values.size()) * rounding * rounding;
}

double rms_about(const std::vector<double>& values, double centre)
{
  double sum = 0.0;
  for (const double value : values) sum += (value - centre) * (value - centre);
  return std::sqrt(sum / static_cast<double>(values.size()));
}

}  // namespace

Statistics statistics(const std::vector<double>& found, const std::vector<double>& measured)
{
  check(found.size() == measured.size(), "a found value belongs to each measured one");
  Statistics result;
  result.n = found.size();
  if (found.empty()) return result;
  std::vector<double> differences;
  for (std::size_t k = 0; k < found.size(); ++k) differences.push_back(found[k] - measured[k]);
  result.rms = rms_about(differences, 0.0);
  result.bias = mean_of(differences);
  result.shape = rms_about(differences, result.bias);
  result.largest = 0.0;
  for (std::size_t k = 0; k < differences.size(); ++k) {
    if (std::abs(differences[k]) <= result.largest) continue;
    result.largest = std::abs(differences[k]);
    result.largest_at = k;
  }
  if (varies(found) && varies(measured)) {
    result.correlation = joint_deviation(found, measured) /
                         std::sqrt(joint_deviation(found, found) * joint_deviation(measured, measured));
  }
  return result;
}

Line constant(const std::vector<double>& values)
{
  check(!values.empty(), "a mean has values");
  return {0.0, mean_of(values), 0.0};
}

Line straight_line(const std::vector<double>& x, const std::vector<double>& values)
{
  check(x.size() == values.size(), "a line has a value for each x");
  if (x.empty() || !varies(x)) return constant(values);
  return {mean_of(x), mean_of(values), joint_deviation(x, values) / joint_deviation(x, x)};
}

double rms_of(const Line& line, const std::vector<double>& x, const std::vector<double>& values)
{
  check(x.size() == values.size(), "a line has a value for each x");
  if (values.empty()) return nan;
  std::vector<double> differences;
  for (std::size_t k = 0; k < values.size(); ++k) differences.push_back(line.at(x[k]) - values[k]);
  return rms_about(differences, 0.0);
}

}  // namespace vrda::analysis
