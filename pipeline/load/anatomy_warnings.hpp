/// What can be noticed about where the objects of a joint and its rotation centre lie.
#pragma once

#include "load/axis_map.hpp"

namespace vrda {

/// One sentence each: axes, side, then rotation centre, each with the value to write into the job. `loaded`
/// is at factor 1, so that places are those of the mesh files.
std::vector<std::string> anatomy_warnings(const Job& job, const AxisMap& map, const Case& loaded);

}  // namespace vrda
