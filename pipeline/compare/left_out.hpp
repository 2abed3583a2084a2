/// The errors at left-out cells, made comparable between degrees.
#pragma once

#include <vector>

#include "compare/recommend.hpp"
#include "smooth/smooth.hpp"

namespace vrda {

/// [n_fits] For recommend(): the error of each cell's pose, rules in compare/compare.hpp. Cells are those
/// fitted in translation. Robust where the fits are. `fits` are of one model by rising degree.
std::vector<DegreeErrors> degree_errors(const std::vector<SmoothFit>& fits);

}  // namespace vrda
