#include "analysis/leave_out.hpp"

#include <cmath>
#include <utility>

#include "core/error.hpp"
#include "core/units.hpp"
#include "analysis/design.hpp"

namespace vrda::analysis {
namespace {

/// A smaller pivot of I - H is rounding: the fit needs the block.
constexpr double smallest_pivot = 1e-10;

/// The cells of one surface; blocks list their positions in it.
struct FittedCells {
  std::vector<Cell> cells;
  std::vector<std::vector<Eigen::Index>> blocks;
};

FittedCells fitted_cells(const store::GridD& residual, const store::GridI& blocks)
{
  FittedCells fitted;
  fitted.blocks.resize(static_cast<std::size_t>(blocks.maxCoeff()) + 1);
  for (Eigen::Index i = 0; i < residual.rows(); ++i) {
    for (Eigen::Index j = 0; j < residual.cols(); ++j) {
      if (std::isnan(residual(i, j))) continue;
      fitted.blocks[static_cast<std::size_t>(blocks(i, j))].push_back(
          static_cast<Eigen::Index>(fitted.cells.size()));
      fitted.cells.push_back({i, j});
    }
  }
  return fitted;
}

Eigen::VectorXd values_at(const store::GridD& grid, const std::vector<Cell>& cells)
{
  Eigen::VectorXd values(static_cast<Eigen::Index>(cells.size()));
  for (std::size_t c = 0; c < cells.size(); ++c)
    values(static_cast<Eigen::Index>(c)) = grid(cells[c].flexion, cells[c].varus);
  return values;
}

/// I - H of each block, decomposed: e = (I - H)^-1 r. `Q` has the rows of all cells.
std::vector<PivotedQr> decompose_blocks(const Eigen::MatrixXd& Q, const FittedCells& fitted)
{
  std::vector<PivotedQr> decomposed;
  for (const std::vector<Eigen::Index>& block : fitted.blocks) {
    const auto n = static_cast<Eigen::Index>(block.size());
    Eigen::MatrixXd M = Eigen::MatrixXd::Identity(n, n);
    for (Eigen::Index a = 0; a < n; ++a) {
      for (Eigen::Index b = 0; b < n; ++b)
        M(a, b) -= Q.row(block[static_cast<std::size_t>(a)]).dot(Q.row(block[static_cast<std::size_t>(b)]));
    }
    decomposed.push_back(n == 0 ? PivotedQr{} : pivoted_qr(M));
  }
  return decomposed;
}

/// Errors of the rows of a block; NaN if the other rows do not determine the fit.
Eigen::VectorXd errors_without(const PivotedQr& qr, const Eigen::VectorXd& own_residuals)
{
  const Eigen::Index n = own_residuals.size();
  const bool is_determined = qr.rank == n && qr.R.diagonal().cwiseAbs().minCoeff() > smallest_pivot;
  if (!is_determined) return Eigen::VectorXd::Constant(n, nan);
  return solve(qr, own_residuals);
}

}  // namespace

store::GridI block_numbers(Eigen::Index n_flexion, Eigen::Index n_varus, const BlockSize& size)
{
  check(size.flexion >= 1 && size.varus >= 1, "a block has at least one cell");
  const Eigen::Index n_across = (n_varus + size.varus - 1) / size.varus;
  store::GridI numbers(n_flexion, n_varus);
  for (Eigen::Index i = 0; i < n_flexion; ++i) {
    for (Eigen::Index j = 0; j < n_varus; ++j)
      numbers(i, j) = static_cast<std::int32_t>(i / size.flexion * n_across + j / size.varus);
  }
  return numbers;
}

std::vector<store::GridD> leave_blocks_out(const SmoothInput& input, const SmoothFit& fit,
                                           const BlockSize& size)
{
  const AxisTables tables = axis_tables(input.flexion_deg, input.varus_deg, fit.set.degree);
  const store::GridI blocks = block_numbers(input.status.rows(), input.status.cols(), size);
  std::vector<store::GridD> errors;
  FittedCells fitted;
  std::vector<PivotedQr> decomposed;
  for (std::size_t s = 0; s < fit.residual.size(); ++s) {
    // Without weights, surfaces of the same cells have the same problem.
    const bool is_repeated =
        s > 0 && !fit.set.is_robust && (fit.residual[s].isNaN() == fit.residual[s - 1].isNaN()).all();
    if (!is_repeated) {
      fitted = fitted_cells(fit.residual[s], blocks);
      PivotedQr qr = decompose_design(fitted.cells, fit.set.exponents, tables);
      if (fit.set.is_robust)
        qr = pivoted_qr(values_at(fit.weight[s], fitted.cells).cwiseSqrt().asDiagonal() * qr.Q);
      decomposed = decompose_blocks(qr.Q, fitted);
    }
    const Eigen::VectorXd root_weight = values_at(fit.weight[s], fitted.cells).cwiseSqrt();
    const Eigen::VectorXd residuals = values_at(fit.residual[s], fitted.cells).cwiseProduct(root_weight);
    store::GridD left_out = store::GridD::Constant(blocks.rows(), blocks.cols(), nan);
    for (std::size_t b = 0; b < fitted.blocks.size(); ++b) {
      const std::vector<Eigen::Index>& block = fitted.blocks[b];
      if (block.empty()) continue;
      const Eigen::VectorXd found = errors_without(decomposed[b], residuals(block));
      for (std::size_t a = 0; a < block.size(); ++a) {
        const Cell& cell = fitted.cells[static_cast<std::size_t>(block[a])];
        left_out(cell.flexion, cell.varus) = found(static_cast<Eigen::Index>(a)) / root_weight(block[a]);
      }
    }
    errors.push_back(std::move(left_out));
  }
  return errors;
}

}  // namespace vrda::analysis
