/// Warnings about the axes, the side and the rotation centre of a joint, judged from its geometry.
#pragma once

#include "load/axis_map.hpp"

namespace vrda::load {

/// One sentence each, with the value to write into the job: axes, side, then rotation centre. `loaded` must
/// be unscaled (factor 1), so that positions agree with the mesh files.
std::vector<std::string> anatomy_warnings(const Job& job, const Case& loaded);

}  // namespace vrda::load
