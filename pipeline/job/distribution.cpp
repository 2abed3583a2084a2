#include "job/distribution.hpp"

#include <algorithm>
#include <cmath>

#include "core/error.hpp"

namespace vrda::job {
namespace {

// Functions of the C library differ in their last bits between processors; these use arithmetic only.
constexpr double ln_2_high = 0x1.62e42fee00000p-1, ln_2_low = 0x1.a39ef35793c76p-33;
constexpr double root_of_2_pi = 2.50662827463100050242;
constexpr double farthest_score = 9.0;  // beyond: a probability of 1e-19

double exponential(double x)
{
  const double n = std::round(x / (ln_2_high + ln_2_low));
  const double rest = (x - n * ln_2_high) - n * ln_2_low;
  double sum = 1.0;
  for (int k = 20; k > 0; --k) sum = 1.0 + sum * rest / k;
  return std::ldexp(sum, static_cast<int>(n));
}

double logarithm(double x)
{
  int power = 0;
  double part = std::frexp(x, &power);  // from 0.5 to 1
  if (part < 0.70710678118654752) {
    part *= 2.0;
    --power;
  }
  const double s = (part - 1.0) / (part + 1.0);
  double sum = 0.0;
  for (int k = 41; k > 0; k -= 2) sum = 1.0 / k + sum * s * s;
  return 2.0 * s * sum + (power * ln_2_low + power * ln_2_high);
}

// Sum of z^(2n + 1) / (1 3 ... (2n + 1)) from n = `first` on.
double odd_series(double z, int first)
{
  double term = z, sum = first == 0 ? z : 0.0;
  for (int n = 1; n < 400 && term > 1e-18 * sum; ++n) {
    term *= z * z / (2 * n + 1);
    sum += term;
  }
  return sum;
}

double density(double score)
{
  return exponential(-0.5 * score * score) / root_of_2_pi;
}

double table_quantile(const std::vector<double>& values, double probability)
{
  const double at = probability * static_cast<double>(values.size() - 1);
  const auto below = std::min(static_cast<std::size_t>(at), values.size() - 2);
  const double share = at - static_cast<double>(below);
  return (1.0 - share) * values[below] + share * values[below + 1];
}

// The probability of values at or below `value`.
double table_probability(const std::vector<double>& values, double value)
{
  const auto above = std::upper_bound(values.begin(), values.end(), value);
  if (above == values.begin()) return 0.0;
  if (above == values.end()) return 1.0;
  const double before = *(above - 1);
  const double share = (value - before) / (*above - before);
  return (static_cast<double>(above - values.begin() - 1) + share) / static_cast<double>(values.size() - 1);
}

double probability_below(const job::Distribution& distribution, double value)
{
  switch (distribution.kind) {
    case job::DistributionKind::normal:
      return probability_of_score((value - distribution.mean) / distribution.sd);
    case job::DistributionKind::lognormal:
      return value > 0.0 ? probability_of_score(logarithm(value / distribution.mean) / distribution.sd) : 0.0;
    case job::DistributionKind::uniform:
      return std::clamp((value - distribution.from) / (distribution.to - distribution.from), 0.0, 1.0);
    case job::DistributionKind::table:
      return table_probability(distribution.values, value);
  }
  return 0.0;
}

}  // namespace

double probability_of_score(double score)
{
  const double size = std::abs(score);
  if (size > farthest_score) return score > 0.0 ? 1.0 : 0.0;
  const double half = density(size) * odd_series(size, 0);
  return score > 0.0 ? 0.5 + half : 0.5 - half;
}

double score_of_probability(double probability)
{
  if (probability > 0.5) return -score_of_probability(1.0 - probability);
  double low = -farthest_score, high = 0.0;
  for (int k = 0; k < 60; ++k) {
    const double middle = 0.5 * (low + high);
    (probability_of_score(middle) < probability ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

double radius_in_ball(double size)
{
  if (size > farthest_score) return 1.0;
  const double probability = 2.0 * density(size) * odd_series(size, 1);  // chi, three degrees of freedom
  double radius = 1.0;
  for (int k = 0; k < 200; ++k) radius -= (radius - probability / (radius * radius)) / 3.0;
  return radius;
}

double quantile_of(const job::Distribution& distribution, double probability)
{
  switch (distribution.kind) {
    case job::DistributionKind::normal:
      return distribution.mean + distribution.sd * score_of_probability(probability);
    case job::DistributionKind::lognormal:
      return distribution.mean * exponential(distribution.sd * score_of_probability(probability));
    case job::DistributionKind::uniform:
      return distribution.from + probability * (distribution.to - distribution.from);
    case job::DistributionKind::table:
      return table_quantile(distribution.values, probability);
  }
  return 0.0;
}

double quantile_above(const job::Distribution& distribution, double probability, double least)
{
  const double cut = probability_below(distribution, least);
  if (cut == 0.0) return quantile_of(distribution, probability);
  check(cut < 1.0, "a distribution reaches above its limit");
  return quantile_of(distribution, cut + probability * (1.0 - cut));
}

}  // namespace vrda::job
