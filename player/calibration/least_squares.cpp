#include "calibration/least_squares.hpp"

#include <nlopt.h>

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <memory>

#include "core/error.hpp"

namespace vrda::calibration {
namespace {

/// Relative to `scale`; small rounding (1e-16 / 1e-6) and truncation (1e-12) errors.
constexpr double difference_step = 1e-6;
/// Reciprocal condition of J^T J below which the error of the differences (1e-10) dominates.
constexpr double least_condition = 1e-14;
/// Remaining step in standard deviations: convergence limit, and target of the final Gauss-Newton steps
/// (rounding error of the differences).
constexpr double most_step_left = 1e-6;
constexpr double least_step = 1e-10;
/// Relative to `scale`: a number this near to a bound counts as at the bound.
constexpr double at_bound = 1e-9;

bool is_bounded(const FitProblem& problem)
{
  return problem.lower_bounds.size() > 0;
}

Eigen::VectorXd within_bounds(const FitProblem& problem, const Eigen::VectorXd& x)
{
  return is_bounded(problem) ? x.cwiseMax(problem.lower_bounds).cwiseMin(problem.upper_bounds).eval() : x;
}

Eigen::MatrixXd jacobian(const FitProblem& problem, const Eigen::VectorXd& x, Eigen::Index m)
{
  Eigen::MatrixXd J(m, x.size());
  Eigen::VectorXd step = Eigen::VectorXd::Zero(x.size());
  for (Eigen::Index k = 0; k < x.size(); ++k) {
    step[k] = difference_step * problem.scale[k];
    const Eigen::VectorXd low = within_bounds(problem, x - step), high = within_bounds(problem, x + step);
    step[k] = 0.0;
    J.col(k) = (problem.residuals(high) - problem.residuals(low)) / (high[k] - low[k]);
  }
  return J;
}

/// Linearisation of the residuals at x.
struct Linearisation {
  Eigen::VectorXd x, r;
  Eigen::MatrixXd J;
  /// x + P y: J P has orthonormal columns (without bounds) or columns of equal length (with bounds).
  /// Undetermined directions have no column.
  Eigen::MatrixXd P;
  Eigen::VectorXd step;    ///< Gauss-Newton step within bounds
  double step_sd = 0.0;    ///< its length in standard deviations
  double condition = 0.0;  ///< reciprocal, of J^T J scaled by `scale`
  bool is_at_bound = false;
};

/// Sets P with orthonormal J P, and the reciprocal condition of J^T J.
void factorise(const FitProblem& problem, Linearisation& at)
{
  const Eigen::Index n = at.x.size();
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(at.J * problem.scale.asDiagonal(), Eigen::ComputeThinV);
  const Eigen::VectorXd& size = svd.singularValues();
  const double least = std::sqrt(least_condition) * size[0];
  const Eigen::Index rank = (size.array() > least).count();
  at.P =
      problem.scale.asDiagonal() * svd.matrixV().leftCols(rank) * size.head(rank).cwiseInverse().asDiagonal();
  const double ratio = size.size() < n || !(size[0] > 0.0) ? 0.0 : size[n - 1] / size[0];
  at.condition = ratio * ratio;
}

void set_free_step(Linearisation& at)
{
  const Eigen::VectorXd y = (at.J * at.P).transpose() * at.r;
  at.step = -at.P * y;
  at.step_sd = y.norm();
}

/// P is diagonal because the bounds are per number; a number at a bound stays if the step would violate it.
void set_bounded_step(const FitProblem& problem, Linearisation& at)
{
  const Eigen::Index n = at.x.size();
  Eigen::MatrixXd J = at.J * problem.scale.asDiagonal();
  const Eigen::VectorXd uphill = J.transpose() * at.r;
  for (Eigen::Index k = 0; k < n; ++k) {
    const double reach = at_bound * problem.scale[k];
    const bool is_least = at.x[k] <= problem.lower_bounds[k] + reach,
               is_most = at.x[k] >= problem.upper_bounds[k] - reach;
    if (is_least || is_most) at.is_at_bound = true;
    if ((is_least && uphill[k] > 0.0) || (is_most && uphill[k] < 0.0)) J.col(k).setZero();
  }
  Eigen::JacobiSVD<Eigen::MatrixXd> svd(J, Eigen::ComputeThinU | Eigen::ComputeThinV);
  svd.setThreshold(std::sqrt(least_condition));
  const Eigen::VectorXd scaled = svd.solve(-at.r);
  at.step_sd = (J * scaled).norm();
  at.step = within_bounds(problem, at.x + problem.scale.cwiseProduct(scaled)) - at.x;
  const double largest = std::max(J.colwise().norm().maxCoeff(), std::numeric_limits<double>::min());
  at.P = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const double size = J.col(k).norm();
    at.P(k, k) = problem.scale[k] / (size > std::sqrt(least_condition) * largest ? size : largest);
  }
}

Linearisation linearise(const FitProblem& problem, const Eigen::VectorXd& x)
{
  Linearisation at;
  at.x = x;
  at.r = problem.residuals(x);
  at.J = jacobian(problem, x, at.r.size());
  at.step = Eigen::VectorXd::Zero(x.size());
  if (!at.r.allFinite() || !at.J.allFinite()) {
    at.step_sd = std::numeric_limits<double>::infinity();
    return at;
  }
  factorise(problem, at);
  is_bounded(problem) ? set_bounded_step(problem, at) : set_free_step(at);
  return at;
}

bool is_within(const Linearisation& at, double step)
{
  return at.step_sd <= step * (1.0 + at.r.norm());
}

bool is_converged(const Linearisation& at)
{
  return is_within(at, most_step_left);
}

/// One run of NLopt in y, started at `from`.
struct Run {
  const FitProblem& problem;
  const Linearisation& from;
  nlopt_opt optimiser = nullptr;
  std::exception_ptr thrown;
};

double half_square_sum(unsigned n, const double* y_data, double* gradient, void* data)
{
  Run& run = *static_cast<Run*>(data);
  try {
    const Eigen::Map<const Eigen::VectorXd> y(y_data, n);
    const Eigen::VectorXd x = within_bounds(run.problem, run.from.x + run.from.P * y);
    const Eigen::VectorXd r = run.problem.residuals(x);
    if (gradient != nullptr) {
      Eigen::Map<Eigen::VectorXd>(gradient, n) =
          run.from.P.transpose() * (jacobian(run.problem, x, r.size()).transpose() * r);
    }
    const double value = 0.5 * r.squaredNorm();
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
  constexpr double least_y = 1e-9;  // in standard deviations of y
  const unsigned n = static_cast<unsigned>(from.P.cols());
  Run run{problem, from, nullptr, nullptr};
  const std::unique_ptr<std::remove_pointer_t<nlopt_opt>, decltype(&nlopt_destroy)> optimiser(
      nlopt_create(NLOPT_LD_SLSQP, n), nlopt_destroy);
  run.optimiser = optimiser.get();
  check(run.optimiser != nullptr, "NLopt makes an optimiser");
  nlopt_set_min_objective(run.optimiser, half_square_sum, &run);
  nlopt_set_xtol_abs1(run.optimiser, least_y);
  nlopt_set_maxeval(run.optimiser, most_evaluations);
  if (is_bounded(problem)) {
    const Eigen::VectorXd widths = from.P.diagonal();
    const Eigen::VectorXd least = (problem.lower_bounds - from.x).cwiseQuotient(widths).cwiseMin(0.0);
    const Eigen::VectorXd most = (problem.upper_bounds - from.x).cwiseQuotient(widths).cwiseMax(0.0);
    nlopt_set_lower_bounds(run.optimiser, least.data());
    nlopt_set_upper_bounds(run.optimiser, most.data());
  }
  Eigen::VectorXd y = Eigen::VectorXd::Zero(n);
  double value = 0.0;
  const nlopt_result result = nlopt_optimize(run.optimiser, y.data(), &value);
  if (run.thrown) std::rethrow_exception(run.thrown);
  check(result != NLOPT_INVALID_ARGS && result != NLOPT_OUT_OF_MEMORY, "NLopt takes the problem");
  return within_bounds(problem, from.x + from.P * y);
}

/// Final Gauss-Newton steps: near the minimum the sum of squares determines only half of the digits of x, its
/// gradient all of them.
Linearisation refine(const FitProblem& problem, Linearisation at)
{
  constexpr int most_steps = 4;
  for (int step = 0; step < most_steps && !is_within(at, least_step); ++step) {
    Linearisation next = linearise(problem, at.x + at.step);
    if (!(next.step_sd < 0.5 * at.step_sd)) break;
    at = std::move(next);
  }
  return at;
}

LeastSquaresStatus status_of(const Linearisation& at)
{
  if (!is_converged(at)) return LeastSquaresStatus::iteration_limit;
  if (at.condition < least_condition) return LeastSquaresStatus::undetermined;
  return at.is_at_bound ? LeastSquaresStatus::at_bound : LeastSquaresStatus::converged;
}

}  // namespace

const char* name_of(LeastSquaresStatus status)
{
  switch (status) {
    case LeastSquaresStatus::converged:
      return "converged";
    case LeastSquaresStatus::at_bound:
      return "at a bound";
    case LeastSquaresStatus::iteration_limit:
      return "iteration limit";
    case LeastSquaresStatus::undetermined:
      return "undetermined";
  }
  check(false, "every status of a fit has a name");
  return "";
}

LeastSquares fit_least_squares(const FitProblem& problem)
{
  constexpr int most_rounds = 20;
  const Eigen::Index n = problem.start.size();
  check(n > 0 && problem.scale.size() == n && (problem.scale.array() > 0.0).all(),
        "every number has a scale");
  check(problem.lower_bounds.size() == problem.upper_bounds.size() &&
            (!is_bounded(problem) || problem.lower_bounds.size() == n),
        "all numbers have bounds, or none");
  check(within_bounds(problem, problem.start) == problem.start, "a fit starts within its bounds");
  Linearisation at = linearise(problem, problem.start);
  for (int round = 0; round < most_rounds && !is_converged(at) && at.P.cols() > 0; ++round) {
    const double before = at.r.squaredNorm();
    Linearisation next = refine(problem, linearise(problem, minimise(problem, at)));
    if (!(next.r.squaredNorm() <= before) && !is_converged(next)) break;
    at = std::move(next);
  }
  LeastSquares fit;
  fit.status = status_of(at);
  fit.covariance = Eigen::MatrixXd::Zero(n, n);
  if (at.condition >= least_condition) {
    const Eigen::MatrixXd J = at.J * problem.scale.asDiagonal();
    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(J, Eigen::ComputeThinV);
    const Eigen::MatrixXd root =
        problem.scale.asDiagonal() * svd.matrixV() * svd.singularValues().cwiseInverse().asDiagonal();
    fit.covariance = root * root.transpose();
  }
  fit.x = std::move(at.x);
  fit.residuals = std::move(at.r);
  fit.J = std::move(at.J);
  return fit;
}

namespace {

Eigen::Matrix2d leverage(const LeastSquares& fit, Eigen::Index mark)
{
  const auto J = fit.J.middleRows<2>(2 * mark);
  return J * fit.covariance * J.transpose();
}

}  // namespace

double noise_dof(const LeastSquares& fit, Eigen::Index n_marks)
{
  double dof = 2.0 * static_cast<double>(n_marks);
  for (Eigen::Index mark = 0; mark < n_marks; ++mark) dof -= leverage(fit, mark).trace();
  return dof;
}

double interval_dof(const LeastSquares& fit, Eigen::Index n_marks, const Eigen::MatrixXd& to_numbers)
{
  const Eigen::MatrixXd gain =
      to_numbers * fit.covariance * fit.J.topRows(2 * n_marks).transpose();  // of numbers by marks
  const Eigen::VectorXd by_marks = gain.rowwise().squaredNorm();
  const Eigen::VectorXd all = (to_numbers * fit.covariance * to_numbers.transpose()).diagonal();
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
  OutlierCandidate furthest;
  for (Eigen::Index mark = 0; mark < n_marks; ++mark) {
    const Eigen::Matrix2d redundancy = Eigen::Matrix2d::Identity() - leverage(fit, mark);
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

}  // namespace vrda::calibration
