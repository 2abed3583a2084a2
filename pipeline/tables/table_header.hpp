/// The header of an OpenSim table: key=value lines and text up to `endheader`.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tables/motion_convention.hpp"

namespace vrda::tables {

/// What the keys state; unknown keys and text state nothing.
struct TableHeader {
  std::optional<AngleUnit> angles = {};           ///< inDegrees
  std::optional<LengthPoint> lengths = {};        ///< translations
  std::optional<Eigen::Vector3d> point_mm = {};   ///< rotation_centre_mm, canonical
  std::string key_name = {};                      ///< key
  std::vector<std::string> negated_columns = {};  ///< negated
  std::vector<std::string> warnings = {};         ///< one line each, with file and line
};

/// Reads the lines of `text` before line `end_line` (from 1). Case, quotes, and blanks, `_` and `-` in a key
/// or word do not matter. Warns of a key that differs from a known one by a typing slip, and of a known key
/// in a comment. Throws InputError naming file, line and key for another value than the known ones, and for
/// two lines of one key that differ.
TableHeader table_header(const std::string& file, std::string_view text, std::size_t end_line);

}  // namespace vrda::tables
