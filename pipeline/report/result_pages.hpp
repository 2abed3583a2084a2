/// Pages of other results than motion models, with the report's style, plots and scripts (page/laxity.js,
/// page/range_of_motion.js). Angles in degrees, lengths in mm.
#pragma once

#include <string>

#include "analysis/laxity.hpp"
#include "analysis/rom_files.hpp"

namespace vrda::report {

/// Tables, laxity over flexion, load against displacement, shares; published values with their differences.
std::string laxity_page(const analysis::LaxityDocument& document);

/// Limits, volume, the ends through the neutral attitude and a map of each slice.
std::string range_page(const analysis::RomDocument& document);

/// Limits and volumes of two ranges over the same rotations, and the maps of both.
/// Throws InputError naming the title of `b` if the rotations differ.
std::string range_comparison_page(const analysis::RomDocument& a, const analysis::RomDocument& b);

}  // namespace vrda::report
