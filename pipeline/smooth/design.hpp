/// The least-squares problem of a degree: which cells, which terms, decomposed once for all that share it.
#pragma once

#include <string>
#include <vector>

#include "smooth/least_squares.hpp"
#include "store/evaluate_smoothed.hpp"

namespace vrda {

struct Cell {
  Eigen::Index flexion = 0;  ///< row of the grid
  Eigen::Index varus = 0;    ///< column
};

/// Legendre polynomials at every value of both axes.
struct AxisTables {
  std::vector<LegendreTable> flexion, varus;
};
AxisTables axis_tables(const std::vector<double>& flexion_deg, const std::vector<double>& varus_deg,
                       int degree);

/// [n_terms, 2] (i, j), i + j <= degree, by rising i + j; i (j) is 0 throughout where an axis has one value.
using Exponents = decltype(SmoothedSet::exponents);
Exponents terms_up_to(int degree, bool has_flexion, bool has_varus);

/// P_i(u) P_j(v) of each cell (row) and term (column), decomposed. Rank 0 where there are fewer cells than
/// terms.
PivotedQr decomposed(const std::vector<Cell>& cells, const Exponents& exponents, const AxisTables& tables);

/// The rank is full: the cells carry the terms.
bool is_carried(const PivotedQr& qr);

/// The polynomial at every attitude of the axes, the same bits as evaluate() of store/evaluate_smoothed.hpp.
GridD grid_values(const std::vector<double>& coefficients, const Exponents& exponents,
                  const AxisTables& tables);

}  // namespace vrda
