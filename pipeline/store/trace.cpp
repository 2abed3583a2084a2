#include "store/trace.hpp"

#include <cmath>
#include <cstdio>

#include "core/error.hpp"

namespace vrda::store {
namespace {

/// Tolerance of angles typed by a user; grid values have fewer digits.
constexpr double same_angle_deg = 1e-6;

std::string degrees(double angle_deg)
{
  char text[32];
  std::snprintf(text, sizeof text, "%g", angle_deg);
  return text;
}

/// The value of an axis nearest to `wanted_deg`; "any" without one.
std::string nearest(const std::vector<double>& axis_deg, const std::optional<double>& wanted_deg)
{
  if (!wanted_deg) return "any";
  double best_deg = axis_deg.front();
  for (const double value_deg : axis_deg) {
    if (std::abs(value_deg - *wanted_deg) < std::abs(best_deg - *wanted_deg)) best_deg = value_deg;
  }
  return degrees(best_deg);
}

}  // namespace

MoveRange moves_of(const Trace& trace, std::size_t search)
{
  return {static_cast<std::size_t>(trace.searches.move_start[search]),
          static_cast<std::size_t>(trace.searches.move_start[search + 1])};
}

std::vector<std::size_t> moves_in_contact(const Trace& trace, std::size_t search)
{
  std::vector<std::size_t> moves;
  const MoveRange range = moves_of(trace, search);
  for (std::size_t m = range.first; m < range.end; ++m) {
    if (trace.moves.in_contact[m] == 1) moves.push_back(m);
  }
  return moves;
}

std::vector<std::size_t> searches_at(const Trace& trace, const std::string& file,
                                     const AttitudeFilter& filter)
{
  const TraceSearches& searches = trace.searches;
  const auto matches = [](const std::optional<double>& wanted_deg, double value_deg) {
    return !wanted_deg || std::abs(*wanted_deg - value_deg) < same_angle_deg;
  };
  std::vector<std::size_t> found;
  for (std::size_t s = 0; s < searches.node.size(); ++s) {
    if (matches(filter.flexion_deg, searches.flexion_deg[s]) &&
        matches(filter.varus_deg, searches.varus_deg[s])) {
      found.push_back(s);
    }
  }
  if (!found.empty()) return found;
  if (searches.node.empty()) throw InputError({file, "/searches", "no searches", "at least one"});
  const auto text = [](const std::optional<double>& angle_deg) {
    return angle_deg ? degrees(*angle_deg) : std::string("any");
  };
  throw InputError({file, "attitude",
                    "no search at flexion " + text(filter.flexion_deg) + ", varus " + text(filter.varus_deg),
                    "one of the grid; the nearest is flexion " +
                        nearest(searches.flexion_deg, filter.flexion_deg) + ", varus " +
                        nearest(searches.varus_deg, filter.varus_deg)});
}

}  // namespace vrda::store
