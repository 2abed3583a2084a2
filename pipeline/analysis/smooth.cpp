#include "analysis/smooth.hpp"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <Eigen/SVD>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <set>
#include <utility>

#include "core/text.hpp"
#include "core/units.hpp"

namespace vrda::analysis {
namespace {

/// A cell with a higher leverage cannot be omitted; the difference to 1 is rounding.
constexpr double saturated_leverage = 1.0 - 1e-10;

/// One least-squares problem, shared by tx, ty, tz and usually theta.
struct Problem {
  std::vector<Cell> cells;
  PivotedQr qr;
  Eigen::VectorXd leverage;  ///< [n_cells]
  double condition_number = 0.0;
};

Exponents exponents_of(const SmoothInput& input, int degree)
{
  return terms_of_degree(degree, input.flexion_deg.size() > 1, input.varus_deg.size() > 1);
}

std::vector<Cell> cells_where(const store::GridB& grid, std::int8_t code)
{
  std::vector<Cell> cells;
  for (Eigen::Index i = 0; i < grid.rows(); ++i) {
    for (Eigen::Index j = 0; j < grid.cols(); ++j)
      if (grid(i, j) == code) cells.push_back({i, j});
  }
  return cells;
}

std::vector<Cell> cells_of(const SmoothInput& input, bool theta_only)
{
  std::vector<Cell> cells = cells_where(input.status, status_stable);
  if (theta_only)
    std::erase_if(cells, [&](const Cell& c) { return input.theta_determined(c.flexion, c.varus) != 1; });
  return cells;
}

bool is_determined(const SmoothInput& input, const std::vector<Cell>& cells, int degree)
{
  const AxisTables tables = axis_tables(input.flexion_deg, input.varus_deg, degree);
  return is_full_rank(decompose_design(cells, exponents_of(input, degree), tables));
}

int largest_degree_of(const SmoothInput& input, const std::vector<Cell>& cells, int limit)
{
  // Cells that determine a degree determine every lower one. Usually they determine the limit.
  if (limit >= 0 && is_determined(input, cells, limit)) return limit;
  int degree = -1;
  while (degree + 1 < limit && is_determined(input, cells, degree + 1)) ++degree;
  return degree;
}

[[noreturn]] void refuse(const SmoothInput& input, const std::vector<Cell>& cells, int degree)
{
  std::set<Eigen::Index> rows, columns;
  for (const Cell& cell : cells) {
    rows.insert(cell.flexion);
    columns.insert(cell.varus);
  }
  const std::string found = std::to_string(cells.size()) + " solved cells in " + std::to_string(rows.size()) +
                            " values of flexion and " + std::to_string(columns.size()) + " of varus";
  const int possible = largest_degree_of(input, cells, degree - 1);
  const std::string wanted =
      "enough for the " + std::to_string(exponents_of(input, degree).rows()) + " terms of degree " +
      std::to_string(degree) +
      (possible < 0 ? "; these allow no degree" : "; these allow degree " + std::to_string(possible));
  throw InputError({input.name, "smooth.degrees", found, wanted});
}

Problem problem_of(std::vector<Cell> cells, PivotedQr qr)
{
  Problem problem{std::move(cells), std::move(qr), {}, 0.0};
  problem.leverage = leverages(problem.qr);
  problem.condition_number = condition_number(problem.qr);
  return problem;
}

/// The problem of the cells that determine theta. Empty if the problem of all cells applies: both are the
/// same, or too few cells determine theta (a ball in a socket, which keeps the theta of its seed).
std::optional<Problem> theta_problem(const SmoothInput& input, const store::SmoothedSet& set,
                                     const AxisTables& tables, std::size_t n_solved)
{
  std::vector<Cell> determined = cells_of(input, true);
  if (determined.size() == n_solved) return std::nullopt;
  PivotedQr qr = decompose_design(determined, set.exponents, tables);
  if (!is_full_rank(qr)) return std::nullopt;
  return problem_of(std::move(determined), std::move(qr));
}

Eigen::VectorXd data_of(const store::GridD& grid, const std::vector<Cell>& cells)
{
  Eigen::VectorXd data(static_cast<Eigen::Index>(cells.size()));
  std::transform(cells.begin(), cells.end(), data.begin(),
                 [&](const Cell& cell) { return grid(cell.flexion, cell.varus); });
  check(data.allFinite(), "a stable cell has finite parameters");
  return data;
}

/// One surface with its errors, as in SmoothFit.
struct FittedSurface {
  store::SmoothedSurface surface;
  store::GridD residual, leave_one_out, weight;
  bool is_converged = true;
};

/// Sets residuals and leave-one-out errors.
void set_errors(FittedSurface& fit, const Problem& problem, const store::GridD& grid,
                const Eigen::VectorXd& leverage)
{
  store::SmoothedSurface& surface = fit.surface;
  fit.residual = fit.leave_one_out = store::GridD::Constant(grid.rows(), grid.cols(), nan);
  double sum_sq = 0.0, left_out_sum_sq = 0.0;
  for (std::size_t c = 0; c < problem.cells.size(); ++c) {
    const auto& [i, j] = problem.cells[c];
    const double residual = grid(i, j) - surface.values(i, j);
    fit.residual(i, j) = residual;
    const double own_leverage = leverage(static_cast<Eigen::Index>(c));
    fit.leave_one_out(i, j) = own_leverage > saturated_leverage ? nan : residual / (1.0 - own_leverage);
    surface.largest_residual = std::max(surface.largest_residual, std::abs(residual));
    sum_sq += residual * residual;
    left_out_sum_sq += fit.leave_one_out(i, j) * fit.leave_one_out(i, j);
  }
  const double n = static_cast<double>(problem.cells.size());
  surface.rms = std::sqrt(sum_sq / n);
  surface.leave_one_out_rms = std::sqrt(left_out_sum_sq / n);
}

FittedSurface fitted_surface(const store::SmoothedSet& set, const std::string& name, const store::GridD& grid,
                             const Problem& problem, const AxisTables& tables)
{
  const Eigen::VectorXd data = data_of(grid, problem.cells);
  FittedSurface fit;
  store::SmoothedSurface& surface = fit.surface;
  surface.name = name;
  surface.condition_number = problem.condition_number;
  surface.n_cells = static_cast<std::int32_t>(data.size());
  std::optional<HuberFit> huber;
  if (set.is_robust) huber = huber_fit(problem.qr, data);
  const Eigen::VectorXd coefficients = huber ? huber->coefficients : solve(problem.qr, data);
  surface.coefficients.assign(coefficients.begin(), coefficients.end());
  surface.values = grid_values(surface.coefficients, set.exponents, tables);
  set_errors(fit, problem, grid, huber ? huber->leverage : problem.leverage);
  fit.weight = store::GridD::Constant(grid.rows(), grid.cols(), nan);
  for (std::size_t c = 0; c < problem.cells.size(); ++c) {
    fit.weight(problem.cells[c].flexion, problem.cells[c].varus) =
        huber ? huber->weights(static_cast<Eigen::Index>(c)) : 1.0;
  }
  fit.is_converged = !huber || huber->is_converged;
  return fit;
}

void add_surface(SmoothFit& fit, const std::string& name, const store::GridD& grid, const Problem& problem,
                 const AxisTables& tables)
{
  FittedSurface found = fitted_surface(fit.set, name, grid, problem, tables);
  fit.residual.push_back(std::move(found.residual));
  fit.leave_one_out.push_back(std::move(found.leave_one_out));
  fit.weight.push_back(std::move(found.weight));
  fit.is_converged.push_back(found.is_converged);
  fit.set.surfaces.push_back(std::move(found.surface));
}

void add_follower(SmoothFit& fit, const FollowerInput& input, const AxisTables& tables)
{
  std::vector<Cell> cells = cells_where(input.status, status_stable);
  PivotedQr qr = decompose_design(cells, fit.set.exponents, tables);
  if (!is_full_rank(qr)) return;
  const Problem problem = problem_of(std::move(cells), std::move(qr));
  store::SmoothedFollower follower;
  follower.name = input.name;
  for (std::size_t k = 0; k < input.coordinates.size(); ++k) {
    FittedSurface found =
        fitted_surface(fit.set, store::follower_surface_names[k], input.coordinates[k], problem, tables);
    fit.is_converged.push_back(found.is_converged);
    follower.surfaces.push_back(std::move(found.surface));
  }
  fit.set.followers.push_back(std::move(follower));
}

void require_shapes(const SmoothInput& input)
{
  const Eigen::Index n_flexion = static_cast<Eigen::Index>(input.flexion_deg.size());
  const Eigen::Index n_varus = static_cast<Eigen::Index>(input.varus_deg.size());
  const auto fits = [&](const auto& grid) { return grid.rows() == n_flexion && grid.cols() == n_varus; };
  check(n_flexion > 0 && n_varus > 0 && fits(input.tx_mm) && fits(input.ty_mm) && fits(input.tz_mm) &&
            fits(input.theta_deg) && fits(input.status) && fits(input.theta_determined) &&
            (input.varus_solved_deg.size() == 0 || fits(input.varus_solved_deg)),
        "every surface to smooth has the shape of the axes");
}

bool is_varus_free(const store::MotionModel& model)
{
  if (model.varus_deg.size() != 1) return false;
  for (Eigen::Index i = 0; i < model.status.rows(); ++i) {
    const bool is_stable = model.status(i, 0) == status_stable;
    if (is_stable && model.varus_solved_deg(i, 0) != model.varus_deg.front()) return true;
  }
  return false;
}

}  // namespace

SmoothInput smooth_input(const store::MotionModel& model, const std::string& name)
{
  store::require_grid(model, name, "smoothing");
  SmoothInput input{name,
                    model.flexion_deg,
                    model.varus_deg,
                    model.tx_mm,
                    model.ty_mm,
                    model.tz_mm,
                    model.theta_deg,
                    model.status,
                    model.theta_determined,
                    is_varus_free(model) ? model.varus_solved_deg : store::GridD()};
  for (const store::FollowerRows& follower : model.followers) {
    input.followers.push_back({follower.name, follower.status, follower.coordinates});
  }
  return input;
}

SmoothFit smooth_fit(const SmoothInput& input, int degree, const SmoothOptions& options)
{
  require_shapes(input);
  if (degree < 0 || degree > store::max_smoothed_degree) {
    throw InputError({input.name, "smooth.degrees", std::to_string(degree),
                      "a degree from 0 to " + std::to_string(store::max_smoothed_degree)});
  }
  SmoothFit fit;
  fit.set.degree = degree;
  fit.set.is_robust = options.is_robust;
  fit.set.exponents = exponents_of(input, degree);
  const AxisTables tables = axis_tables(input.flexion_deg, input.varus_deg, degree);
  std::vector<Cell> cells = cells_of(input, false);
  PivotedQr qr = decompose_design(cells, fit.set.exponents, tables);
  if (!is_full_rank(qr)) refuse(input, cells, degree);
  const Problem solved = problem_of(std::move(cells), std::move(qr));
  const std::optional<Problem> theta = theta_problem(input, fit.set, tables, solved.cells.size());
  add_surface(fit, "tx", input.tx_mm, solved, tables);
  add_surface(fit, "ty", input.ty_mm, solved, tables);
  add_surface(fit, "tz", input.tz_mm, solved, tables);
  add_surface(fit, "theta", input.theta_deg, theta ? *theta : solved, tables);
  if (input.varus_solved_deg.size() > 0) add_surface(fit, "varus", input.varus_solved_deg, solved, tables);
  for (const FollowerInput& follower : input.followers) add_follower(fit, follower, tables);
  return fit;
}

store::SmoothedSet smooth(const SmoothInput& input, int degree, const SmoothOptions& options)
{
  return smooth_fit(input, degree, options).set;
}

int largest_degree(const SmoothInput& input, int limit)
{
  require_shapes(input);
  return largest_degree_of(input, cells_of(input, false), limit);
}

namespace {

using Decomposition = Eigen::ColPivHouseholderQR<Eigen::MatrixXd>;

/// householderQ() * Identity, one reflection at a time: Eigen applies 48 or more in blocks, whose products
/// depend on the cache sizes.
Eigen::MatrixXd thin_q(const Decomposition& decomposition)
{
  const Eigen::Index m = decomposition.rows(), n = decomposition.cols();
  Eigen::MatrixXd Q = Eigen::MatrixXd::Identity(m, n);
  Eigen::VectorXd workspace(n);
  for (Eigen::Index k = n; k-- > 0;) {
    Q.bottomRightCorner(m - k, n - k)
        .applyHouseholderOnTheLeft(decomposition.matrixQR().col(k).tail(m - k - 1),
                                   decomposition.hCoeffs()(k), workspace.data());
  }
  return Q;
}

}  // namespace

PivotedQr pivoted_qr(const Eigen::MatrixXd& A)
{
  const Eigen::Index m = A.rows(), n = A.cols();
  check(m >= n && n > 0, "least squares needs a column, and at least as many rows as columns");
  Decomposition decomposition(A);
  decomposition.setThreshold(static_cast<double>(m) * std::numeric_limits<double>::epsilon());
  return {thin_q(decomposition), decomposition.matrixR().topRows(n).triangularView<Eigen::Upper>(),
          decomposition.colsPermutation().indices(), decomposition.rank()};
}

Eigen::VectorXd coefficients_of(const PivotedQr& qr, const Eigen::VectorXd& along)
{
  check(qr.rank == qr.R.cols(), "the rank is full");
  check(along.size() == qr.R.cols(), "one value per column");
  const Eigen::VectorXd x = qr.R.triangularView<Eigen::Upper>().solve(along);
  return Eigen::PermutationMatrix<Eigen::Dynamic>(qr.order) * x;
}

Eigen::VectorXd solve(const PivotedQr& qr, const Eigen::VectorXd& data)
{
  check(data.size() == qr.Q.rows(), "one datum per row");
  return coefficients_of(qr, qr.Q.transpose() * data);
}

Eigen::VectorXd leverages(const PivotedQr& qr)
{
  return qr.Q.rowwise().squaredNorm();
}

double condition_number(const PivotedQr& qr)
{
  check(qr.rank == qr.R.cols(), "the rank is full");
  const Eigen::VectorXd singular_values = Eigen::JacobiSVD<Eigen::MatrixXd>(qr.R).singularValues();
  return singular_values(0) / singular_values(singular_values.size() - 1);
}

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

namespace {

/// Enough to converge with few outliers, at a tenth of the cost.
constexpr int unweighted_steps = 30;
/// Enough for the scale to converge if a third of the rows are outliers.
constexpr int steps_with_new_scale = 50;
/// Fraction of the noise; smaller changes of the fit are imperceptible.
constexpr double convergence_tolerance = 1e-6;
/// Residuals this far below the data are rounding of the sums over the terms.
constexpr double rounding = 64.0 * std::numeric_limits<double>::epsilon();

Eigen::VectorXd weights_of(const Eigen::VectorXd& residuals, double scale)
{
  const double limit = huber_constant * scale;
  return residuals.unaryExpr([&](double r) { return std::abs(r) <= limit ? 1.0 : limit / std::abs(r); });
}

using WeightedNormal = Eigen::LDLT<Eigen::MatrixXd>;

/// Decomposes Q^T diag(weights) Q. Matrix-vector products and LDLT (not LLT) do not depend on the cache sizes
/// (least_squares.hpp).
WeightedNormal weighted_normal(const PivotedQr& qr, const Eigen::VectorXd& weights)
{
  const Eigen::Index n = qr.Q.cols();
  Eigen::MatrixXd lower = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const Eigen::VectorXd weighted = weights.cwiseProduct(qr.Q.col(k));
    lower.col(k).tail(n - k).noalias() = qr.Q.rightCols(n - k).transpose() * weighted;
  }
  WeightedNormal normal(lower);
  check(normal.vectorD().minCoeff() > 0.0, "positive weights leave the rank full");
  return normal;
}

/// weights(i) * row i of Q * (Q^T diag(weights) Q)^-1 * row i of Q.
Eigen::VectorXd weighted_leverages(const PivotedQr& qr, const WeightedNormal& normal,
                                   const Eigen::VectorXd& weights)
{
  Eigen::VectorXd leverage(qr.Q.rows());
  for (Eigen::Index i = 0; i < qr.Q.rows(); ++i) {
    Eigen::VectorXd y = normal.transpositionsP() * qr.Q.row(i).transpose();
    normal.matrixL().solveInPlace(y);
    leverage(i) = weights(i) * (y.array().square() / normal.vectorD().array()).sum();
  }
  return leverage;
}

/// Iterates weights and scale; does not set the coefficients.
HuberFit iterated_weights(const PivotedQr& qr, const Eigen::VectorXd& data, int most_steps)
{
  const double largest = data.cwiseAbs().maxCoeff();
  const double root_n = std::sqrt(static_cast<double>(data.size()));
  Eigen::VectorXd along = qr.Q.transpose() * data;
  HuberFit fit;
  fit.weights = Eigen::VectorXd::Ones(data.size());
  while (fit.n_iterations < most_steps && !fit.is_converged) {
    const Eigen::VectorXd residuals = data - qr.Q * along;
    const double scale = fit.n_iterations < steps_with_new_scale ? robust_scale(residuals) : fit.scale;
    if (scale <= rounding * largest) {  // more than half of the rows are on the surface
      fit.is_converged = true;
      break;
    }
    fit.scale = scale;
    fit.weights = weights_of(residuals, scale);
    Eigen::VectorXd move = qr.Q.transpose() * fit.weights.cwiseProduct(residuals);
    if (fit.n_iterations >= unweighted_steps) move = weighted_normal(qr, fit.weights).solve(move).eval();
    along += move;
    fit.is_converged = move.norm() <= convergence_tolerance * scale * root_n;
    ++fit.n_iterations;
  }
  return fit;
}

}  // namespace

double robust_scale(Eigen::VectorXd values)
{
  if (values.size() == 0) return 0.0;
  values = values.cwiseAbs();
  double* const middle = values.data() + values.size() / 2;
  std::nth_element(values.data(), middle, values.data() + values.size());
  if (values.size() % 2 == 1) return normal_scale * *middle;
  return normal_scale * 0.5 * (*middle + *std::max_element(values.data(), middle));
}

HuberFit huber_fit(const PivotedQr& qr, const Eigen::VectorXd& data, const HuberOptions& options)
{
  HuberFit fit = iterated_weights(qr, data, options.max_iterations);
  const WeightedNormal normal = weighted_normal(qr, fit.weights);
  const Eigen::VectorXd along = normal.solve(qr.Q.transpose() * fit.weights.cwiseProduct(data));
  fit.coefficients = coefficients_of(qr, along);
  fit.leverage = weighted_leverages(qr, normal, fit.weights);
  return fit;
}

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

/// For the errors e = (I - Q Q^T)^-1 r of a block's rows Q. Of more rows than columns the smaller I - Q^T Q
/// is decomposed: (I - Q Q^T)^-1 = I + Q (I - Q^T Q)^-1 Q^T (Woodbury).
struct LeftOutBlock {
  Eigen::MatrixXd Q;
  PivotedQr qr;
};

/// `Q` has the rows of all cells.
std::vector<LeftOutBlock> decompose_blocks(const Eigen::MatrixXd& Q, const FittedCells& fitted)
{
  std::vector<LeftOutBlock> decomposed;
  for (const std::vector<Eigen::Index>& block : fitted.blocks) {
    LeftOutBlock& left_out = decomposed.emplace_back();
    if (block.empty()) continue;
    left_out.Q = Q(block, Eigen::all);
    Eigen::MatrixXd shorter = left_out.Q.transpose();
    if (shorter.cols() > shorter.rows()) shorter = left_out.Q;
    const Eigen::Index n = shorter.cols();
    Eigen::MatrixXd M = Eigen::MatrixXd::Identity(n, n);
    for (Eigen::Index a = 0; a < n; ++a)
      for (Eigen::Index b = 0; b < n; ++b) M(a, b) -= shorter.col(a).dot(shorter.col(b));
    left_out.qr = pivoted_qr(M);
  }
  return decomposed;
}

/// Errors of the rows of a block; NaN if the other rows do not determine the fit.
Eigen::VectorXd errors_without(const LeftOutBlock& block, const Eigen::VectorXd& own_residuals)
{
  const Eigen::Index n = own_residuals.size();
  const bool is_determined =
      is_full_rank(block.qr) && block.qr.R.diagonal().cwiseAbs().minCoeff() > smallest_pivot;
  if (!is_determined) return Eigen::VectorXd::Constant(n, nan);
  if (block.qr.R.cols() == n) return solve(block.qr, own_residuals);
  return own_residuals + block.Q * solve(block.qr, block.Q.transpose() * own_residuals);
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
  std::vector<LeftOutBlock> decomposed;
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
