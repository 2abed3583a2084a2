#include "analysis/design.hpp"

#include <utility>

namespace vrda::analysis {
namespace {

std::vector<store::LegendreTable> tables_of(const std::vector<double>& values_deg,
                                            const store::AxisRange& range, int degree)
{
  std::vector<store::LegendreTable> tables;
  for (const double value_deg : values_deg)
    tables.push_back(store::legendre(store::unit_coordinate(value_deg, range), degree));
  return tables;
}

}  // namespace

AxisTables axis_tables(const std::vector<double>& flexion_deg, const std::vector<double>& varus_deg,
                       int degree)
{
  const store::AxisRanges ranges = store::axis_ranges(flexion_deg, varus_deg);
  return {tables_of(flexion_deg, ranges.flexion, degree), tables_of(varus_deg, ranges.varus, degree)};
}

Exponents terms_of_degree(int degree, bool has_flexion, bool has_varus)
{
  std::vector<std::pair<std::int32_t, std::int32_t>> pairs;
  for (std::int32_t total = 0; total <= degree; ++total) {
    for (std::int32_t j = 0; j <= total; ++j) {
      const std::int32_t i = total - j;
      if ((i == 0 || has_flexion) && (j == 0 || has_varus)) pairs.emplace_back(i, j);
    }
  }
  Exponents exponents(static_cast<Eigen::Index>(pairs.size()), 2);
  for (Eigen::Index k = 0; k < exponents.rows(); ++k) {
    exponents.row(k) << pairs[static_cast<std::size_t>(k)].first, pairs[static_cast<std::size_t>(k)].second;
  }
  return exponents;
}

PivotedQr decompose_design(const std::vector<Cell>& cells, const Exponents& exponents,
                           const AxisTables& tables)
{
  const auto n_cells = static_cast<Eigen::Index>(cells.size());
  if (n_cells < exponents.rows()) return {};
  Eigen::MatrixXd A(n_cells, exponents.rows());
  for (Eigen::Index row = 0; row < n_cells; ++row) {
    const Cell& cell = cells[static_cast<std::size_t>(row)];
    const store::LegendreTable& P = tables.flexion[static_cast<std::size_t>(cell.flexion)];
    const store::LegendreTable& Q = tables.varus[static_cast<std::size_t>(cell.varus)];
    for (Eigen::Index k = 0; k < A.cols(); ++k)
      A(row, k) = P.value[exponents(k, 0)] * Q.value[exponents(k, 1)];
  }
  return pivoted_qr(A);
}

bool is_full_rank(const PivotedQr& qr)
{
  return qr.rank > 0 && qr.rank == qr.R.cols();
}

store::GridD grid_values(const std::vector<double>& coefficients, const Exponents& exponents,
                         const AxisTables& tables)
{
  store::GridD values = store::GridD::Zero(static_cast<Eigen::Index>(tables.flexion.size()),
                                           static_cast<Eigen::Index>(tables.varus.size()));
  for (Eigen::Index i = 0; i < values.rows(); ++i) {
    for (Eigen::Index j = 0; j < values.cols(); ++j) {
      const store::LegendreTable& P = tables.flexion[static_cast<std::size_t>(i)];
      const store::LegendreTable& Q = tables.varus[static_cast<std::size_t>(j)];
      double value = 0.0;
      for (Eigen::Index k = 0; k < exponents.rows(); ++k)
        value +=
            coefficients[static_cast<std::size_t>(k)] * P.value[exponents(k, 0)] * Q.value[exponents(k, 1)];
      values(i, j) = value;
    }
  }
  return values;
}

}  // namespace vrda::analysis
