/// Whether the angles of a table can be meant in the unit in which they are read.
#pragma once

#include <string>
#include <vector>

#include "tables/motion_table.hpp"

namespace vrda::tables {

/// Where the unit of the angles comes from.
enum class UnitSource {
  option,   ///< the user states it
  file,     ///< the table's names or header
  assumed,  ///< nothing states it
  found,    ///< the search of `vrda import`
};

/// Warnings, one line each, of angles that are hardly meant in `unit`: rotations that are small as degrees
/// and usual as radians, in all columns or in one, or the reverse; also that the unit is assumed, or that an
/// option replaces the file's. Throws InputError naming file and column instead where the unit is almost
/// certainly another one, unless `source` is an option or a search. schemas/motion-files.md lists the bounds.
std::vector<std::string> unit_warnings(const MotionTable& table, AngleUnit unit, UnitSource source,
                                       const JointFrame& joint);

}  // namespace vrda::tables
