#include "app/angle_range.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "core/text.hpp"

namespace vrda::app {
namespace {

constexpr double most_attitudes = 100000.0;

}  // namespace

std::optional<double> finite_number(const std::string& text)
{
  double number = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(number)) return {};
  return number;
}

std::vector<double> angle_range(const AngleRangeOption& option)
{
  const std::string& range = option.text;
  const auto refuse = [&](const std::string& wanted) {
    throw InputError({option.command, option.option, range, wanted});
  };
  const std::string wanted = "FROM:TO:STEP in degrees, FROM at most TO, STEP above 0, such as 0:90:5";
  std::vector<double> parts;
  for (std::size_t begin = 0; begin <= range.size();) {
    const std::size_t end = std::min(range.find(':', begin), range.size());
    const std::optional<double> part = finite_number(range.substr(begin, end - begin));
    if (!part) refuse(wanted);
    parts.push_back(*part);
    begin = end + 1;
  }
  if (parts.size() != 3 || parts[0] > parts[1] || !(parts[2] > 0.0)) refuse(wanted);
  // Rounding may put the last step just beyond the end; it counts.
  const double n_steps = std::floor((parts[1] - parts[0]) / parts[2] + 1e-9);
  if (!(n_steps < most_attitudes)) refuse("at most 100000 attitudes");
  std::vector<double> angles;
  for (int k = 0; k <= static_cast<int>(n_steps); ++k) {
    angles.push_back(std::min(parts[0] + k * parts[2], parts[1]));
  }
  return angles;
}

}  // namespace vrda::app
