/// Names of coordinates in OpenSim tables.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace vrda::measured {

/// "knee_flex_r" for "/jointset/knee_r/knee_flex_r/value".
std::string coordinate_name(std::string_view column);

/// `names`, then those of `vrda export` for every kind of joint and side: of "flex" knee_flex_r, knee_flex_l,
/// hip_flex_r ...
std::vector<std::string> with_opensim_names(std::vector<std::string> names, const std::string& coordinate);

}  // namespace vrda::measured
