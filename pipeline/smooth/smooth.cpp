#include "smooth/smooth.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "core/error.hpp"
#include "smooth/least_squares.hpp"
#include "store/evaluate_smoothed.hpp"

namespace vrda {
namespace {

using Exponents = decltype(SmoothedSet::exponents);

/// A cell whose own datum decides its fitted value this far cannot be left out: rounding alone.
constexpr double saturated_leverage = 1.0 - 1e-10;

struct Cell {
  Eigen::Index flexion = 0;
  Eigen::Index varus = 0;
};

/// One least-squares problem: tx, ty and tz share theirs.
struct Problem {
  std::vector<Cell> cells;
  PivotedQr qr;
  std::vector<double> leverage;  ///< [n_cells]
  double condition_number = 0.0;
};

Exponents exponents_of(int degree, bool has_flexion, bool has_varus)
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

Exponents exponents_of(const SmoothInput& input, int degree)
{
  return exponents_of(degree, input.flexion_deg.size() > 1, input.varus_deg.size() > 1);
}

std::vector<Cell> cells_of(const SmoothInput& input, bool theta_only)
{
  std::vector<Cell> cells;
  for (Eigen::Index i = 0; i < input.status.rows(); ++i) {
    for (Eigen::Index j = 0; j < input.status.cols(); ++j) {
      const bool is_stable = input.status(i, j) == static_cast<std::int8_t>(StepStatus::stable);
      if (is_stable && (!theta_only || input.theta_determined(i, j) == 1)) cells.push_back({i, j});
    }
  }
  return cells;
}

Eigen::MatrixXd design_matrix(const SmoothInput& input, const std::vector<Cell>& cells, int degree)
{
  const Exponents exponents = exponents_of(input, degree);
  const AxisRanges ranges = axis_ranges(input.flexion_deg, input.varus_deg);
  Eigen::MatrixXd A(static_cast<Eigen::Index>(cells.size()), exponents.rows());
  for (Eigen::Index row = 0; row < A.rows(); ++row) {
    const Cell& cell = cells[static_cast<std::size_t>(row)];
    const double flexion_deg = input.flexion_deg[static_cast<std::size_t>(cell.flexion)];
    const double varus_deg = input.varus_deg[static_cast<std::size_t>(cell.varus)];
    const LegendreTable P = legendre(unit_coordinate(flexion_deg, ranges.flexion), degree);
    const LegendreTable Q = legendre(unit_coordinate(varus_deg, ranges.varus), degree);
    for (Eigen::Index k = 0; k < A.cols(); ++k)
      A(row, k) = P.value[exponents(k, 0)] * Q.value[exponents(k, 1)];
  }
  return A;
}

/// Decomposes the design matrix; rank 0 where there are fewer cells than terms.
PivotedQr decomposed(const SmoothInput& input, const std::vector<Cell>& cells, int degree)
{
  const Eigen::Index n_terms = exponents_of(input, degree).rows();
  if (static_cast<Eigen::Index>(cells.size()) < n_terms) return {};
  return pivoted_qr(design_matrix(input, cells, degree));
}

bool carries(const SmoothInput& input, const std::vector<Cell>& cells, int degree)
{
  const PivotedQr qr = decomposed(input, cells, degree);
  return qr.rank > 0 && qr.rank == qr.R.cols();
}

int largest_degree_of(const SmoothInput& input, const std::vector<Cell>& cells, int limit)
{
  // A set of cells that carries a degree carries every lower one.
  int degree = -1;
  while (degree < limit && carries(input, cells, degree + 1)) ++degree;
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
      (possible < 0 ? "; they carry no degree" : "; they carry degree " + std::to_string(possible));
  throw InputError({input.name, "smooth.degrees", found, wanted});
}

/// Cells theta is fitted to: those that determine it, or all where these are too few for the degree (a ball
/// in a socket determines it nowhere, and keeps the theta of its seed).
std::vector<Cell> theta_cells(const SmoothInput& input, int degree)
{
  const std::vector<Cell> determined = cells_of(input, true);
  return carries(input, determined, degree) ? determined : cells_of(input, false);
}

Problem problem_of(const SmoothInput& input, const std::vector<Cell>& cells, int degree)
{
  Problem problem;
  problem.cells = cells;
  problem.qr = decomposed(input, problem.cells, degree);
  if (problem.qr.rank == 0 || problem.qr.rank < problem.qr.R.cols()) refuse(input, problem.cells, degree);
  problem.leverage = leverages(problem.qr);
  problem.condition_number = condition_number(problem.qr);
  return problem;
}

GridD values_of(const SmoothInput& input, const SmoothedSet& set, const SmoothedSurface& surface)
{
  const AxisRanges ranges = axis_ranges(input.flexion_deg, input.varus_deg);
  GridD values(static_cast<Eigen::Index>(input.flexion_deg.size()),
               static_cast<Eigen::Index>(input.varus_deg.size()));
  for (Eigen::Index i = 0; i < values.rows(); ++i) {
    for (Eigen::Index j = 0; j < values.cols(); ++j) {
      values(i, j) = evaluate(set, surface, ranges, input.flexion_deg[static_cast<std::size_t>(i)],
                              input.varus_deg[static_cast<std::size_t>(j)])
                         .value;
    }
  }
  return values;
}

/// Fits one parameter and measures what it leaves; left out means: as if the cell were not in the fit.
SmoothedSurface fitted_surface(const SmoothInput& input, const SmoothedSet& set, const Problem& problem,
                               const GridD& grid)
{
  std::vector<double> data;
  for (const Cell& cell : problem.cells) {
    data.push_back(grid(cell.flexion, cell.varus));
    check(std::isfinite(data.back()), "a stable cell has finite parameters");
  }
  SmoothedSurface surface;
  surface.coefficients = solve(problem.qr, data);
  surface.condition_number = problem.condition_number;
  surface.n_cells = static_cast<std::int32_t>(data.size());
  surface.values = values_of(input, set, surface);
  double sum_sq = 0.0, left_out_sum_sq = 0.0;
  bool is_saturated = false;
  for (std::size_t c = 0; c < data.size(); ++c) {
    const double residual = data[c] - surface.values(problem.cells[c].flexion, problem.cells[c].varus);
    surface.largest_residual = std::max(surface.largest_residual, std::abs(residual));
    sum_sq += residual * residual;
    is_saturated = is_saturated || problem.leverage[c] > saturated_leverage;
    const double left_out = residual / (1.0 - problem.leverage[c]);
    left_out_sum_sq += left_out * left_out;
  }
  const double n = static_cast<double>(data.size());
  surface.rms = std::sqrt(sum_sq / n);
  surface.leave_one_out_rms =
      is_saturated ? std::numeric_limits<double>::quiet_NaN() : std::sqrt(left_out_sum_sq / n);
  return surface;
}

void require_shapes(const SmoothInput& input)
{
  const Eigen::Index n_flexion = static_cast<Eigen::Index>(input.flexion_deg.size());
  const Eigen::Index n_varus = static_cast<Eigen::Index>(input.varus_deg.size());
  const auto fits = [&](const auto& grid) { return grid.rows() == n_flexion && grid.cols() == n_varus; };
  check(n_flexion > 0 && n_varus > 0 && fits(input.tx_mm) && fits(input.ty_mm) && fits(input.tz_mm) &&
            fits(input.theta_deg) && fits(input.status) && fits(input.theta_determined),
        "every surface to smooth has the shape of the axes");
}

}  // namespace

SmoothInput smooth_input(const MotionModel& model, const std::string& name)
{
  return {name,        model.flexion_deg, model.varus_deg, model.tx_mm,           model.ty_mm,
          model.tz_mm, model.theta_deg,   model.status,    model.theta_determined};
}

SmoothedSet smooth(const SmoothInput& input, int degree)
{
  require_shapes(input);
  if (degree < 0 || degree > largest_smoothed_degree) {
    throw InputError({input.name, "smooth.degrees", std::to_string(degree),
                      "a degree from 0 to " + std::to_string(largest_smoothed_degree)});
  }
  SmoothedSet set;
  set.degree = degree;
  set.exponents = exponents_of(input, degree);
  const Problem translation = problem_of(input, cells_of(input, false), degree);
  const Problem rotation = problem_of(input, theta_cells(input, degree), degree);
  set.surfaces = {fitted_surface(input, set, translation, input.tx_mm),
                  fitted_surface(input, set, translation, input.ty_mm),
                  fitted_surface(input, set, translation, input.tz_mm),
                  fitted_surface(input, set, rotation, input.theta_deg)};
  const char* names[] = {"tx", "ty", "tz", "theta"};
  for (std::size_t s = 0; s < set.surfaces.size(); ++s) set.surfaces[s].name = names[s];
  return set;
}

int largest_degree(const SmoothInput& input)
{
  require_shapes(input);
  return largest_degree_of(input, cells_of(input, false), largest_smoothed_degree);
}

}  // namespace vrda
