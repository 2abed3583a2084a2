/// The design matrix of a degree: its cells and terms, decomposed once for all surfaces that share it.
#pragma once

#include <string>
#include <vector>

#include "analysis/least_squares.hpp"
#include "store/evaluate_smoothed.hpp"

namespace vrda::analysis {

struct Cell {
  Eigen::Index flexion = 0;  ///< row of the grid
  Eigen::Index varus = 0;    ///< column
};

/// Legendre polynomials at every value of both axes.
struct AxisTables {
  std::vector<store::LegendreTable> flexion, varus;
};
AxisTables axis_tables(const std::vector<double>& flexion_deg, const std::vector<double>& varus_deg,
                       int degree);

/// [n_terms, 2] (i, j), i + j <= degree, by ascending i + j; i (j) is always 0 if its axis has one value.
using Exponents = decltype(store::SmoothedSet::exponents);
Exponents terms_of_degree(int degree, bool has_flexion, bool has_varus);

/// Decomposes the matrix P_i(u) P_j(v) of cells (rows) and terms (columns). Rank 0 if there are fewer cells
/// than terms.
PivotedQr decompose_design(const std::vector<Cell>& cells, const Exponents& exponents,
                           const AxisTables& tables);

/// True if the cells determine all terms.
bool is_full_rank(const PivotedQr& qr);

/// Polynomial at every grid attitude, bitwise equal to evaluate() of store/evaluate_smoothed.hpp.
store::GridD grid_values(const std::vector<double>& coefficients, const Exponents& exponents,
                         const AxisTables& tables);

}  // namespace vrda::analysis
