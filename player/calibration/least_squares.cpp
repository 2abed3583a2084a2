#include "calibration/least_squares.hpp"

#include <nlopt.h>
#include <Eigen/LU>
#include <Eigen/SVD>

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <memory>
#include <vector>

#include "core/text.hpp"

namespace vrda::calibration {
namespace {

/// Relative to `scale`: errors of 1e-10 by truncation, and by rounding of drawn positions (1e-13 px / 1e-3
/// px).
constexpr double difference_step = 1e-5;
/// Remaining step in standard deviations at convergence, and change of y that ends a run.
constexpr double most_step_left = 1e-6, least_change = 1e-7;

Eigen::MatrixXd jacobian(const FitProblem& problem, const Eigen::VectorXd& x, Eigen::Index m)
{
  if (problem.derivatives) return problem.derivatives(x);
  Eigen::MatrixXd J(m, x.size());
  Eigen::VectorXd at = x;
  for (Eigen::Index k = 0; k < x.size(); ++k) {
    const double step = difference_step * problem.scale[k];
    at[k] = x[k] + step;
    const Eigen::VectorXd high = problem.residuals(at);
    at[k] = x[k] - step;
    J.col(k) = (high - problem.residuals(at)) / (2.0 * step);
    at[k] = x[k];
  }
  return J;
}

/// Linearisation of the residuals at x.
struct Linearisation {
  Eigen::VectorXd x, r;
  Eigen::MatrixXd J;
  Eigen::MatrixXd P;         ///< J P has orthonormal columns; undetermined directions have no column
  Eigen::VectorXd gradient;  ///< of half the sum of squares, by y in x + P y: the remaining step
};

Linearisation linearise(const FitProblem& problem, const Eigen::VectorXd& x)
{
  Linearisation at;
  at.x = x;
  at.r = problem.residuals(x);
  at.J = jacobian(problem, x, at.r.size());
  at.P.resize(x.size(), 0);
  if (!at.r.allFinite() || !at.J.allFinite()) return at;
  at.P = inverse_root_of(square(at.J.transpose()), problem.scale);
  at.gradient = transformed(at.P.transpose(), transformed(at.J.transpose(), at.r));
  return at;
}

bool is_converged(const Linearisation& at)
{
  return at.P.cols() > 0 && at.gradient.norm() <= most_step_left * (1.0 + at.r.norm());
}

/// One run of NLopt in y, started at `from`.
struct Run {
  const FitProblem& problem;
  const Linearisation& from;
  Eigen::VectorXd y, gradient;  ///< the latest gradient and its place
  nlopt_opt optimiser = nullptr;
  std::exception_ptr thrown;
};

/// Half the sum of squares, relative to that at y = 0. Near y = 0 rounding hides the difference, which
/// determines only half of the digits of y; there it is the integral of the gradient, which determines all
/// of them (trapezoidal rule). Source: Hager, Zhang (2005) SIAM J Optim 16:170-192, "approximate Wolfe
/// conditions".
double objective(unsigned n, const double* y_data, double* gradient_data, void* data)
{
  constexpr double nearby = 1e-3;  // standard deviations; rounding is 1e-6, the error of the rule is cubic
  Run& run = *static_cast<Run*>(data);
  try {
    const Eigen::Map<const Eigen::VectorXd> y(y_data, n);
    const Eigen::VectorXd x = run.from.x + transformed(run.from.P, y);
    const Eigen::VectorXd r = run.problem.residuals(x);
    const bool is_nearby = y.norm() <= nearby;
    double value = 0.5 * (r.squaredNorm() - run.from.r.squaredNorm());
    if ((gradient_data != nullptr || is_nearby) && y != run.y) {
      run.y = y;
      run.gradient =
          transformed(run.from.P.transpose(), transformed(jacobian(run.problem, x, r.size()).transpose(), r));
    }
    if (gradient_data != nullptr) Eigen::Map<Eigen::VectorXd>(gradient_data, n) = run.gradient;
    if (is_nearby) value = 0.5 * y.dot(run.from.gradient + run.gradient);
    return std::isfinite(value) ? value : HUGE_VAL;
  } catch (...) {
    run.thrown = std::current_exception();
    nlopt_force_stop(run.optimiser);
    return HUGE_VAL;
  }
}

/// Best x of an NLopt run. Its return code is not used: linearise() decides convergence.
Eigen::VectorXd minimise(const FitProblem& problem, const Linearisation& from)
{
  constexpr int most_evaluations = 200;
  constexpr double least_ratio = 1e-3;  // of y; a restart in its own coordinates then converges faster
  const auto n = static_cast<unsigned>(from.P.cols());
  Run run{problem, from, Eigen::VectorXd::Zero(n), from.gradient, nullptr, nullptr};
  const std::unique_ptr<std::remove_pointer_t<nlopt_opt>, decltype(&nlopt_destroy)> optimiser(
      nlopt_create(NLOPT_LD_SLSQP, n), nlopt_destroy);
  run.optimiser = optimiser.get();
  check(run.optimiser != nullptr, "NLopt makes an optimiser");
  nlopt_set_min_objective(run.optimiser, objective, &run);
  nlopt_set_xtol_rel(run.optimiser, least_ratio);
  nlopt_set_xtol_abs1(run.optimiser, least_change);
  nlopt_set_maxeval(run.optimiser, most_evaluations);
  Eigen::VectorXd y = Eigen::VectorXd::Zero(n);
  double value = 0.0;
  const nlopt_result result = nlopt_optimize(run.optimiser, y.data(), &value);
  if (run.thrown) std::rethrow_exception(run.thrown);
  check(result != NLOPT_INVALID_ARGS && result != NLOPT_OUT_OF_MEMORY, "NLopt takes the problem");
  return from.x + transformed(from.P, y);
}

LeastSquaresStatus status_of(const Linearisation& at)
{
  if (!is_converged(at)) return LeastSquaresStatus::iteration_limit;
  return at.P.cols() < at.x.size() ? LeastSquaresStatus::undetermined : LeastSquaresStatus::converged;
}

/// Blocks of the hat matrix of the marks.
std::vector<Eigen::Matrix2d> leverages(const LeastSquares& fit, Eigen::Index n_marks)
{
  const Eigen::MatrixXd gain = product(fit.J.topRows(2 * n_marks), fit.covariance);
  std::vector<Eigen::Matrix2d> blocks(static_cast<std::size_t>(n_marks));
  for (Eigen::Index k = 0; k < 4 * n_marks; ++k) {
    const Eigen::Index mark = k / 4, row = k / 2 % 2, column = k % 2;
    blocks[static_cast<std::size_t>(mark)](row, column) =
        gain.row(2 * mark + row).dot(fit.J.row(2 * mark + column));
  }
  return blocks;
}

}  // namespace

const char* name_of(LeastSquaresStatus status)
{
  return std::array{"converged", "iteration limit", "undetermined"}.at(static_cast<std::size_t>(status));
}

LeastSquares fit_least_squares(const FitProblem& problem)
{
  constexpr int most_runs = 20;
  const Eigen::Index n = problem.start.size();
  check(n > 0 && problem.scale.size() == n && (problem.scale.array() > 0.0).all(),
        "every number has a scale");
  Linearisation at = linearise(problem, problem.start);
  // Each run starts in coordinates of its own.
  for (int run = 0; run < most_runs && at.P.cols() > 0 && !is_converged(at); ++run) {
    Linearisation next = linearise(problem, minimise(problem, at));
    const bool is_better = next.r.squaredNorm() < at.r.squaredNorm() ||
                           (next.P.cols() > 0 && next.gradient.norm() < at.gradient.norm());
    if (!is_better) break;
    at = std::move(next);
  }
  LeastSquares fit;
  fit.status = status_of(at);
  fit.covariance = Eigen::MatrixXd::Zero(n, n);
  if (at.P.cols() == n) fit.covariance = square(at.P);
  fit.x = std::move(at.x);
  fit.residuals = std::move(at.r);
  fit.J = std::move(at.J);
  return fit;
}

double noise_dof(const LeastSquares& fit, Eigen::Index n_marks)
{
  double dof = 2.0 * static_cast<double>(n_marks);
  for (const Eigen::Matrix2d& leverage : leverages(fit, n_marks)) dof -= leverage.trace();
  return dof;
}

double interval_dof(const LeastSquares& fit, Eigen::Index n_marks, const Eigen::MatrixXd& to_numbers)
{
  const Eigen::MatrixXd numbers_covariance = product(to_numbers, fit.covariance);
  const Eigen::MatrixXd gain =
      product(numbers_covariance, fit.J.topRows(2 * n_marks).transpose());  // of numbers by marks
  const Eigen::VectorXd by_marks = gain.rowwise().squaredNorm();
  const Eigen::VectorXd all = numbers_covariance.cwiseProduct(to_numbers).rowwise().sum();
  double shares = 0.0, n = 0.0;
  for (Eigen::Index k = 0; k < all.size(); ++k) {
    if (!(all[k] > 0.0)) continue;
    shares += by_marks[k] / all[k];
    n += 1.0;
  }
  const double share = n > 0.0 ? shares / n : 0.0;
  return noise_dof(fit, n_marks) / (share * share);
}

OutlierCandidate largest_outlier(const LeastSquares& fit, Eigen::Index n_marks)
{
  constexpr double alone = 1e-9;  // the other marks do not determine this one
  constexpr double least_sum = std::numeric_limits<double>::min();
  const double square_sum = fit.residuals.head(2 * n_marks).squaredNorm();
  const double dof_without = noise_dof(fit, n_marks) - 2.0;
  const std::vector<Eigen::Matrix2d> hat = leverages(fit, n_marks);
  OutlierCandidate furthest;
  for (Eigen::Index mark = 0; mark < n_marks; ++mark) {
    const Eigen::Matrix2d redundancy = Eigen::Matrix2d::Identity() - hat[static_cast<std::size_t>(mark)];
    if (redundancy.determinant() < alone || dof_without <= 0.0) continue;
    const Eigen::Vector2d residual = fit.residuals.segment<2>(2 * mark);
    const Eigen::Vector2d off = redundancy.inverse() * residual;
    const double gain = residual.dot(off);
    const double variance_without = std::max(square_sum - gain, least_sum) / dof_without;
    const double deviations = std::sqrt(std::max(gain, 0.0) / variance_without);
    if (deviations > furthest.deviations) furthest = {mark, deviations, off};
  }
  return furthest;
}

std::vector<double> MarksFit::residuals_px() const
{
  std::vector<double> lengths_px;
  for (Eigen::Index i = 0; i < n(); ++i)
    lengths_px.push_back(sds_px[i] * fit.residuals.segment<2>(2 * i).norm());
  return lengths_px;
}

void require_converged(const LeastSquares& fit, const std::string& field, const std::string& what,
                       const std::string& wanted, const bench::FitErrorContext& context)
{
  if (fit.status != LeastSquaresStatus::converged)
    context.fail(field, what + " with status: " + name_of(fit.status), wanted);
}

void refuse_outlier(const MarksFit& marks, const OutlierLimits& limits,
                    const std::function<std::string(std::size_t)>& field_of,
                    const bench::FitErrorContext& context)
{
  const OutlierCandidate furthest = largest_outlier(marks.fit, marks.n());
  const double off_px = marks.sds_px[furthest.mark] * furthest.off.norm();
  if (furthest.deviations <= limits.deviations || off_px <= limits.px) return;
  const auto mark = static_cast<std::size_t>(furthest.mark);
  context.fail(field_of(mark),
               "a mark " + bench::text(off_px, 1, "px") + " from the position predicted by all others",
               std::string("a consistent mark: ") + limits.again, {mark});
}

// Lazy products are loops of scalar products: fast enough for these sizes, and quick to compile.

// Of a square positive semi-definite matrix the singular values are the eigenvalues. Jacobi rotations compile
// faster than the Householder reflections of the other decompositions.
PrincipalAxes principal_axes(const Eigen::MatrixXd& semi_definite)
{
  const Eigen::JacobiSVD<Eigen::MatrixXd, Eigen::NoQRPreconditioner> svd(semi_definite, Eigen::ComputeFullV);
  return {svd.singularValues(), svd.matrixV()};
}

Eigen::MatrixXd product(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B)
{
  if (A.cols() == 0) return Eigen::MatrixXd::Zero(A.rows(), B.cols());  // Eigen would offset a null pointer
  return A.lazyProduct(B);
}

Eigen::VectorXd transformed(const Eigen::MatrixXd& A, const Eigen::VectorXd& x)
{
  if (A.cols() == 0) return Eigen::VectorXd::Zero(A.rows());
  return A.lazyProduct(x);
}

Eigen::MatrixXd square(const Eigen::MatrixXd& A)
{
  return product(A, A.transpose());
}

Eigen::MatrixXd propagated(const Eigen::MatrixXd& A, const Eigen::MatrixXd& C)
{
  return product(product(A, C), A.transpose());
}

Eigen::MatrixXd root_of(const Eigen::MatrixXd& covariance)
{
  constexpr double least_share = 1e-12;  // rounding error of a correlation
  const Eigen::VectorXd sd = covariance.diagonal().cwiseSqrt();
  const Eigen::VectorXd per_sd = (sd.array() > 0.0).select(sd.cwiseInverse(), 0.0);
  const PrincipalAxes axes = principal_axes(per_sd.asDiagonal() * covariance * per_sd.asDiagonal());
  const Eigen::Index rank = (axes.values.array() > least_share).count();
  return sd.asDiagonal() * axes.vectors.leftCols(rank) * axes.values.head(rank).cwiseSqrt().asDiagonal();
}

Eigen::MatrixXd inverse_root_of(const Eigen::MatrixXd& N, const Eigen::VectorXd& scale)
{
  constexpr double least_share = 1e-13;  // rounding error of the eigenvalues of some twenty unknowns
  const PrincipalAxes axes = principal_axes(scale.asDiagonal() * N * scale.asDiagonal());
  const Eigen::Index rank = (axes.values.array() > least_share * axes.values[0]).count();
  return scale.asDiagonal() * axes.vectors.leftCols(rank) *
         axes.values.head(rank).cwiseSqrt().cwiseInverse().asDiagonal();
}

Eigen::MatrixXd inverse_root_of(const Eigen::MatrixXd& N)
{
  return inverse_root_of(N, N.diagonal().cwiseSqrt().cwiseInverse());
}

}  // namespace vrda::calibration
