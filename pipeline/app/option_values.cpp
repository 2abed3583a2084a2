#include "app/option_values.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "core/text.hpp"

namespace vrda::app {
namespace {

constexpr double most_attitudes = 100000.0;

std::optional<std::size_t> row_number(std::string_view text, std::size_t if_empty)
{
  if (text.empty()) return if_empty;
  std::size_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size() || number == 0) return {};
  return number;
}

}  // namespace

std::optional<double> finite_number(const std::string& text)
{
  double number = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(number)) return {};
  return number;
}

std::vector<double> angle_range(const CommandOption& option, const std::string& range)
{
  const auto refuse = [&](const std::string& wanted) {
    throw InputError({option.command, option.name, range, wanted});
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

analysis::RowRange rows_of(const CommandOption& option, const std::string& text, std::size_t n)
{
  if (text.empty()) return {};
  if (text == "first-half") return {0, n / 2};
  if (text == "second-half") return {n / 2, n};
  const std::size_t colon = text.find(':');
  const InputError refused(
      {option.command, option.name, "\"" + text + "\"",
       "A:B with A at most B, of rows 1 to " + std::to_string(n) + "; or first-half or second-half"});
  if (colon == std::string::npos) throw refused;
  const std::optional<std::size_t> first = row_number(std::string_view(text).substr(0, colon), 1);
  const std::optional<std::size_t> last = row_number(std::string_view(text).substr(colon + 1), n);
  if (!first || !last || *first > *last || *last > n) throw refused;
  return {*first - 1, *last};
}

}  // namespace vrda::app
