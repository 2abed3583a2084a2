#include "analysis/smooth.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include "core/error.hpp"
#include "core/units.hpp"
#include "analysis/design.hpp"
#include "analysis/huber.hpp"

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

std::vector<Cell> cells_of(const SmoothInput& input, bool theta_only)
{
  std::vector<Cell> cells;
  for (Eigen::Index i = 0; i < input.status.rows(); ++i) {
    for (Eigen::Index j = 0; j < input.status.cols(); ++j) {
      const bool is_stable = input.status(i, j) == status_stable;
      if (is_stable && (!theta_only || input.theta_determined(i, j) == 1)) cells.push_back({i, j});
    }
  }
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

/// Adds residuals and leave-one-out errors of a surface.
void add_errors(SmoothFit& fit, store::SmoothedSurface& surface, const Problem& problem,
                const store::GridD& grid, const Eigen::VectorXd& leverage)
{
  store::GridD residuals = store::GridD::Constant(grid.rows(), grid.cols(), nan), left_out = residuals;
  double sum_sq = 0.0, left_out_sum_sq = 0.0;
  for (std::size_t c = 0; c < problem.cells.size(); ++c) {
    const auto& [i, j] = problem.cells[c];
    const double residual = grid(i, j) - surface.values(i, j);
    residuals(i, j) = residual;
    const double own_leverage = leverage(static_cast<Eigen::Index>(c));
    left_out(i, j) = own_leverage > saturated_leverage ? nan : residual / (1.0 - own_leverage);
    surface.largest_residual = std::max(surface.largest_residual, std::abs(residual));
    sum_sq += residual * residual;
    left_out_sum_sq += left_out(i, j) * left_out(i, j);
  }
  const double n = static_cast<double>(problem.cells.size());
  surface.rms = std::sqrt(sum_sq / n);
  surface.leave_one_out_rms = std::sqrt(left_out_sum_sq / n);
  fit.residual.push_back(std::move(residuals));
  fit.leave_one_out.push_back(std::move(left_out));
}

void add_surface(SmoothFit& fit, const std::string& name, const store::GridD& grid, const Problem& problem,
                 const AxisTables& tables)
{
  const Eigen::VectorXd data = data_of(grid, problem.cells);
  store::SmoothedSurface surface;
  surface.name = name;
  surface.condition_number = problem.condition_number;
  surface.n_cells = static_cast<std::int32_t>(data.size());
  std::optional<HuberFit> huber;
  if (fit.set.is_robust) huber = huber_fit(problem.qr, data);
  const Eigen::VectorXd coefficients = huber ? huber->coefficients : solve(problem.qr, data);
  surface.coefficients.assign(coefficients.begin(), coefficients.end());
  surface.values = grid_values(surface.coefficients, fit.set.exponents, tables);
  add_errors(fit, surface, problem, grid, huber ? huber->leverage : problem.leverage);
  store::GridD weights = store::GridD::Constant(grid.rows(), grid.cols(), nan);
  for (std::size_t c = 0; c < problem.cells.size(); ++c) {
    weights(problem.cells[c].flexion, problem.cells[c].varus) =
        huber ? huber->weights(static_cast<Eigen::Index>(c)) : 1.0;
  }
  fit.weight.push_back(std::move(weights));
  fit.is_converged.push_back(!huber || huber->is_converged);
  fit.set.surfaces.push_back(std::move(surface));
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
  return {name,
          model.flexion_deg,
          model.varus_deg,
          model.tx_mm,
          model.ty_mm,
          model.tz_mm,
          model.theta_deg,
          model.status,
          model.theta_determined,
          is_varus_free(model) ? model.varus_solved_deg : store::GridD()};
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

}  // namespace vrda::analysis
