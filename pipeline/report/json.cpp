#include "report/json.hpp"

#include <cmath>

namespace vrda {

Json short_number(double value)
{
  if (!std::isfinite(value)) return nullptr;
  constexpr double per_unit = 1e6;
  return std::round(value * per_unit) / per_unit;
}

Json short_numbers(const std::vector<double>& values)
{
  Json list = Json::array();
  for (const double value : values) list.push_back(short_number(value));
  return list;
}

Json short_grid(const GridD& grid)
{
  Json rows = Json::array();
  for (Eigen::Index i = 0; i < grid.rows(); ++i) {
    Json row = Json::array();
    for (Eigen::Index j = 0; j < grid.cols(); ++j) row.push_back(short_number(grid(i, j)));
    rows.push_back(std::move(row));
  }
  return rows;
}

Json short_rows(const std::vector<double>& values, std::size_t width)
{
  Json rows = Json::array();
  for (std::size_t begin = 0; begin + width <= values.size(); begin += width) {
    Json row = Json::array();
    for (std::size_t k = begin; k < begin + width; ++k) row.push_back(short_number(values[k]));
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace vrda
