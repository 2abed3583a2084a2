#include "tables/angle_plausibility.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>

#include "core/error.hpp"
#include "core/units.hpp"

namespace vrda::tables {
namespace {

// As numbers, of radians that are taken for degrees or the reverse.
constexpr double turn_rad = 2.0 * pi;    // no joint turns further
constexpr double usual_flexion = 1.6;    // 92 degrees in rad
constexpr double largest_flexion = 2.8;  // 160 degrees in rad
constexpr double least_span = 0.1;       // 6 degrees in rad: a motion, not a posture
constexpr double least_angle = 0.005;    // 0.3 degrees in rad: more than rounding of a constrained joint
// Rotations other than flexion stay below 29 degrees in most motions of a knee; half a degree over ten
// degrees of flexion is less than in any measured one (the least known is 0.7, varus of a knee replacement).
constexpr double small_other = 0.5, large_flexion_deg = 10.0;

struct Extent {
  double least = std::numeric_limits<double>::infinity(), most = -least;
  double largest() const { return std::max(std::abs(least), std::abs(most)); }
  double span() const { return most - least; }
};

std::array<Extent, 3> extents_of(const MotionTable& table)
{
  std::array<Extent, 3> extents;
  for (const PoseCoordinates& row : table.coordinates) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      extents[axis].least = std::min(extents[axis].least, row.angle[axis]);
      extents[axis].most = std::max(extents[axis].most, row.angle[axis]);
    }
  }
  return extents;
}

std::string digits(double value)
{
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value);
  return text;
}

/// An angle that is hardly meant so.
struct Doubt {
  std::size_t axis = 0;
  bool is_certain = false;  ///< the unit is almost certainly the other one
};

/// The axis of flexion: Z by name, else the one that turns most.
std::size_t flexion_axis(const MotionTable& table, const std::array<Extent, 3>& extents)
{
  if (table.are_angles_clinical) return 2;
  const auto most = std::max_element(extents.begin(), extents.end(),
                                     [](const Extent& a, const Extent& b) { return a.span() < b.span(); });
  return static_cast<std::size_t>(most - extents.begin());
}

std::vector<Doubt> doubts_of_degrees(const std::array<Extent, 3>& extents, std::size_t flexion,
                                     std::optional<bool> has_large_flexion)
{
  const Extent& main = extents[flexion];
  double others = 0.0;
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (axis != flexion) others = std::max(others, extents[axis].largest());
  const bool is_small_throughout = std::max(others, main.largest()) <= usual_flexion;
  if (main.span() >= least_span && main.largest() <= largest_flexion) {
    const bool is_certain =
        main.largest() <= usual_flexion && (has_large_flexion.value_or(true) || is_small_throughout);
    // A joint that flexes little may turn more about the other axes.
    if (is_certain || has_large_flexion.value_or(false) || others <= usual_flexion)
      return {{flexion, is_certain}};
  } else if (main.span() < least_span && is_small_throughout &&
             std::max(others, main.largest()) >= least_angle) {
    return {{main.largest() >= others ? flexion : flexion == 0 ? std::size_t{1} : std::size_t{0}, false}};
  }
  std::vector<Doubt> doubts;
  if (main.span() < large_flexion_deg) return doubts;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Extent& other = extents[axis];
    if (axis != flexion && other.span() >= least_angle && other.largest() <= small_other)
      doubts.push_back({axis, false});
  }
  return doubts;
}

std::vector<Doubt> doubts_of_radians(const std::array<Extent, 3>& extents, std::size_t flexion)
{
  std::vector<Doubt> doubts;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const bool is_certain = extents[axis].largest() > turn_rad;
    if (is_certain || (axis == flexion && extents[axis].largest() > largest_flexion))
      doubts.push_back({axis, is_certain});
  }
  return doubts;
}

/// "at most 1.571 degrees (90 if they are radians)".
std::string found_text(const Extent& extent, AngleUnit unit, UnitSource source)
{
  const bool is_degrees = unit == AngleUnit::degrees;
  const double other = is_degrees ? deg_from_rad(extent.largest()) : rad_from_deg(extent.largest());
  return "at most " + digits(extent.largest()) + (is_degrees ? " degrees" : " rad") +
         (source == UnitSource::assumed ? ", which the file does not state" : "") +
         (is_degrees ? " (" + digits(other) + " degrees if they are radians: times 57.2958)"
                     : " (" + digits(deg_from_rad(extent.largest())) + " degrees; " + digits(other) +
                           " rad if they are degrees: divided by 57.2958)");
}

}  // namespace

std::vector<std::string> unit_warnings(const MotionTable& table, AngleUnit unit, UnitSource source,
                                       const JointFrame& joint)
{
  std::vector<std::string> warnings;
  if (table.coordinates.empty()) return warnings;
  const bool is_degrees = unit == AngleUnit::degrees;
  const char* other = is_degrees ? "rad" : "deg";
  if (source == UnitSource::option && table.stated.angles && *table.stated.angles != unit)
    warnings.push_back(table.file + ": --angles " + name_of(unit) + " replaces the file's unit of angles, " +
                       other);
  if (source == UnitSource::assumed)
    warnings.push_back(
        table.file +
        ": no inDegrees in the header and no unit in the column names: the angles are taken for "
        "degrees; --angles states their unit");
  const std::array<Extent, 3> extents = extents_of(table);
  const std::size_t flexion = flexion_axis(table, extents);
  const bool may_refuse = source == UnitSource::file || source == UnitSource::assumed;
  for (const Doubt& doubt : is_degrees ? doubts_of_degrees(extents, flexion, joint.has_large_flexion)
                                       : doubts_of_radians(extents, flexion)) {
    const std::string column = "column " + table.angle_columns[doubt.axis];
    const std::string found = found_text(extents[doubt.axis], unit, source);
    if (doubt.is_certain && may_refuse) {
      throw InputError({table.file, column, found,
                        std::string("rotations of a joint in one unit; --angles ") + other +
                            " if it is that of all columns, --angles " + name_of(unit) +
                            " if they are right"});
    }
    warnings.push_back(table.file + ": " + column + ": " + found + "; check the unit of the column");
  }
  return warnings;
}

}  // namespace vrda::tables
