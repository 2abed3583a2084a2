/// Numbers of a report in JSON. NaN and infinity are null.
#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "store/grid.hpp"

namespace vrda {

using Json = nlohmann::ordered_json;

/// Rounded to 1e-6 of the unit: a page shows fewer digits, and the file is a third as long.
Json short_number(double value);
Json short_numbers(const std::vector<double>& values);
/// Rows of flexion, each with the values over varus.
Json short_grid(const GridD& grid);
/// Rows of `width` numbers.
Json short_rows(const std::vector<double>& values, std::size_t width);

}  // namespace vrda
