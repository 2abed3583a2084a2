/// Tables over the attitudes of a grid.
#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace vrda::store {

/// Values over (flexion, varus). NaN (or -1 for flags) where a cell has no value.
template <typename Scalar>
using Grid = Eigen::Array<Scalar, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using GridD = Grid<double>;
using GridI = Grid<std::int32_t>;
using GridB = Grid<std::int8_t>;

}  // namespace vrda::store
