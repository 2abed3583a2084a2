#include "calibration/functional_fit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "calibration/functional_problem.hpp"
#include "calibration/linear_algebra.hpp"
#include "core/units.hpp"
#include "show/settings_text.hpp"
#include "bench/screw.hpp"

namespace vrda::calibration {
namespace {

constexpr std::size_t least_trials = 2;
constexpr double least_factor = 1e-3;  // of the noise; keeps weights finite if the motion fits exactly
/// The samples of a trial, held out or not, must fit within this multiple of the tracker's stated noise. A
/// larger residual means that a body moved on the skin, or that the joint differs from the model.
constexpr double most_factor = 5.0;
/// A motion that leaves more of the landmarks' expected error does not determine the placement.
constexpr double most_of_landmarks = 0.85;
/// Beyond these the landmarks are not a valid start of the fit: bodies exchanged, or another leg.
constexpr double most_start_mm = 60.0, most_start_rad = rad_from_deg(40.0);
constexpr double joint_arm_mm = 30.0;

std::string angle_text(double rad)
{
  return bench::text(deg_from_rad(rad), 0, "degrees");
}

std::string error_text(const MotionError& error)
{
  return bench::text(error.mm, 2, "mm") + " and " + bench::text(deg_from_rad(error.rad), 2, "degrees");
}

/// Root mean squares of twists.
class TwistSum {
 public:
  void add(const Vector6& twist, double weight = 1.0)
  {
    mm2_ += weight * twist.head<3>().squaredNorm();
    rad2_ += weight * twist.tail<3>().squaredNorm();
    n_ += weight;
  }
  MotionError rms() const
  {
    if (n_ <= 0.0) return {};
    return {std::sqrt(mm2_ / n_), std::sqrt(rad2_ / n_)};
  }

 private:
  double mm2_ = 0.0, rad2_ = 0.0, n_ = 0.0;
};

/// Expected rms overlay error of both bones for a covariance of their placements at the joint's centre.
double expected_joint_mm(const Eigen::MatrixXd& C)
{
  double sum = 0.0;
  // A turn moves the six points by 2/3 of the arm's square, about each axis.
  for (const Eigen::Index k : {0, 6}) {
    sum += C.block(k, k, 3, 3).trace() +
           2.0 / 3.0 * joint_arm_mm * joint_arm_mm * C.block(k + 3, k + 3, 3, 3).trace();
  }
  return std::sqrt(0.5 * sum);
}

void require_trials(std::span<const FlexionTrial> trials, const bench::FitErrorContext& context)
{
  if (trials.size() < least_trials)
    context.fail("bends", std::to_string(trials.size()) + " bends", "two or more: each is held out once");
  for (std::size_t k = 0; k < trials.size(); ++k) {
    const auto is_finite = [](const Pose& X) { return X.matrix().allFinite(); };
    if (trials[k].X_thigh_shank.empty() || !std::ranges::all_of(trials[k].X_thigh_shank, is_finite))
      context.fail(trials[k].name, "samples that are missing or not finite",
                   "tracked poses of thigh and shank", {k});
  }
}

/// Checks each trial with the placements by landmarks.
void require_start(const FunctionalProblem& problem, std::span<const FlexionTrial> trials,
                   const bench::FitErrorContext& context)
{
  const Eigen::VectorXd landmarks = Eigen::VectorXd::Zero(n_functional);
  for (std::size_t k = 0; k < trials.size(); ++k) {
    TwistSum sum;
    std::size_t n = 0;
    for (const FunctionalSample& sample : problem.samples()) {
      if (sample.trial != k) continue;
      sum.add(problem.difference(sample, landmarks).twist);
      ++n;
    }
    constexpr std::size_t least_samples = 10;
    if (n < least_samples) {
      context.fail(
          trials[k].name, std::to_string(n) + " samples within the model's flexions, by the landmarks",
          std::to_string(least_samples) + " or more; bend within the model's range, and check the landmarks",
          {k});
    }
    const MotionError start = sum.rms();
    if (start.mm > most_start_mm || start.rad > most_start_rad) {
      context.fail(trials[k].name, "a motion " + error_text(start) + " from that of the landmarks",
                   "at most " + bench::text(most_start_mm, 0, "mm") + " and " + angle_text(most_start_rad) +
                       "; check which body is on which bone, and the landmarks",
                   {k});
    }
  }
  if (problem.flexion_range_rad() < least_flexion_range_rad) {
    context.fail(
        "bends", "a flexion range of " + angle_text(problem.flexion_range_rad()),
        angle_text(least_flexion_range_rad) + " or more; a smaller motion does not determine the joint");
  }
}

void require_converged(const LeastSquares& fit, const bench::FitErrorContext& context)
{
  if (fit.status == LeastSquaresStatus::converged) return;
  context.fail("bends", std::string("a fit with status: ") + name_of(fit.status),
               "bends that determine the placement; repeat them, or the landmarks");
}

/// Factor of the tracker's stated noise that the residuals of the motion have.
double noise_factor(const FunctionalProblem& problem, const LeastSquares& fit, double factor)
{
  const Eigen::Index n = fit.residuals.size() - n_functional;
  const Eigen::MatrixXd J = fit.J.bottomRows(n);
  const double used = product(J, fit.covariance).cwiseProduct(J).sum();
  // Each sample has its own flexion.
  const double dof = static_cast<double>(n) - static_cast<double>(problem.samples().size()) - used;
  return std::max(least_factor, factor * std::sqrt(fit.residuals.tail(n).squaredNorm() / std::max(1.0, dof)));
}

struct Solution {
  LeastSquares fit;
  double factor = 1.0;
};

/// May not have converged, as with a trial that contradicts the others.
Solution solve(const FunctionalProblem& problem)
{
  constexpr int n_rounds = 3;
  Solution solution;
  solution.fit.x = Eigen::VectorXd::Zero(n_functional);
  for (int round = 0; round < n_rounds; ++round) {
    solution.fit = problem.fit(solution.fit.x, solution.factor, FunctionalProblem::without_none);
    if (solution.fit.status != LeastSquaresStatus::converged) return {solution.fit, 1.0};
    if (round + 1 < n_rounds) solution.factor = noise_factor(problem, solution.fit, solution.factor);
  }
  return solution;
}

/// Differences of a trial, with its residual in units of the stated noise.
struct TrialError {
  TwistSum sum;
  double whitened = 0.0;
};

TrialError error_of(const FunctionalProblem& problem, const Eigen::VectorXd& x, std::size_t trial)
{
  constexpr double n_free = 5.0;  // of the six coordinates: flexion is fitted
  TrialError error;
  double sum_sq = 0.0, n = 0.0;
  for (const FunctionalSample& sample : problem.samples()) {
    if (sample.trial != trial) continue;
    const FunctionalProblem::Difference found = problem.difference(sample, x);
    error.sum.add(found.twist);
    sum_sq += found.whitened.squaredNorm();
    n += n_free;
  }
  error.whitened = std::sqrt(sum_sq / n);
  return error;
}

MotionError rms_of(const std::vector<MotionError>& errors)
{
  double mm2 = 0.0, rad2 = 0.0;
  const auto n = static_cast<double>(errors.size());
  for (const MotionError& error : errors) {
    mm2 += error.mm * error.mm / n;
    rad2 += error.rad * error.rad / n;
  }
  return {std::sqrt(mm2), std::sqrt(rad2)};
}

/// Errors of each trial by the fit to the others; refuses the trial that contradicts them most.
std::vector<MotionError> held_out(const FunctionalProblem& problem, const Solution& solution,
                                  std::span<const FlexionTrial> trials, const bench::FitErrorContext& context)
{
  std::vector<MotionError> errors(trials.size());
  double worst = 0.0;
  std::size_t worst_trial = 0;
  const bool is_converged = solution.fit.status == LeastSquaresStatus::converged;
  const Eigen::VectorXd start = is_converged ? solution.fit.x : Eigen::VectorXd::Zero(n_functional);
  for (std::size_t k = 0; k < trials.size(); ++k) {
    const LeastSquares others = problem.fit(start, solution.factor, k);
    // Without the trial that contradicts, the others fit.
    if (others.status != LeastSquaresStatus::converged) {
      if (is_converged) require_converged(others, context);
      continue;
    }
    const TrialError error = error_of(problem, others.x, k);
    errors[k] = error.sum.rms();
    if (error.whitened <= worst) continue;
    worst = error.whitened;
    worst_trial = k;
  }
  if (worst > most_factor) {
    context.fail(trials[worst_trial].name,
                 error_text(errors[worst_trial]) + " from the placement that fits the other bends, " +
                     bench::text(worst, 1, "times the tracker's noise"),
                 "at most " + bench::text(most_factor, 0, "times") +
                     "; the bodies must not move on the skin. Bend again, without pressing the leg sideways",
                 {worst_trial});
  }
  require_converged(solution.fit, context);
  return errors;
}

MotionError deviation_of(const FunctionalProblem& problem, const Eigen::VectorXd& x)
{
  TwistSum sum;
  for (const FunctionalSample& sample : problem.samples())
    sum.add(problem.deviation(x, problem.difference(sample, x).flexion_rad));
  return sum.rms();
}

bench::Estimate estimate_of(const FunctionalFit& fit, const Eigen::MatrixXd& covariance)
{
  bench::Estimate estimate;
  append(estimate, bench::pose_estimate("femur", fit.X_thigh_femur, covariance.block<6, 6>(0, 0)));
  append(estimate, bench::pose_estimate("tibia", fit.X_shank_tibia, covariance.block<6, 6>(6, 6)));
  Eigen::VectorXd unit = Eigen::VectorXd::Ones(n_placement);
  for (const Eigen::Index k : {3, 9}) unit.segment<3>(k).setConstant(deg_from_rad(1.0));
  estimate.covariance = unit.asDiagonal() * covariance * unit.asDiagonal();
  estimate.dof = std::numeric_limits<double>::infinity();
  return estimate;
}

std::vector<std::string> remarks_of(const FunctionalFit& fit, const bench::FunctionalSettings& settings)
{
  std::vector<std::string> remarks{"expected error at the joint " + bench::text(fit.joint_mm, 1, "mm") +
                                       ", from landmarks alone " + bench::text(fit.landmarks_joint_mm, 1, "mm"),
                                   "held-out bends fit to " + error_text(fit.held_out) +
                                       " (rms), with landmarks alone to " + error_text(fit.by_landmarks),
                                   "flexion range " + angle_text(fit.flexion_range_rad) +
                                       "; the joint deviates from the model by " + error_text(fit.deviation)};
  if (fit.n_beyond > 0)
    remarks.push_back(std::to_string(fit.n_beyond) + " samples beyond the model's flexions were not used");
  constexpr double much = 2.0;
  if (fit.deviation.mm > much * settings.model_sd_mm || fit.deviation.rad > much * settings.model_sd_rad) {
    remarks.push_back(
        "the deviation is more than twice that of calibration.model_sd_mm and model_sd_deg: the "
        "intervals are too small");
  }
  return remarks;
}

}  // namespace

double joint_error_mm(const Pose& X_found, const Pose& X_true, const Eigen::Vector3d& centre_mm)
{
  const Pose X_off = X_true.inverse() * X_found;
  double sum_sq = 0.0;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    for (const double arm_mm : {-joint_arm_mm, joint_arm_mm}) {
      const Eigen::Vector3d p_mm = centre_mm + arm_mm * Eigen::Vector3d::Unit(axis);
      sum_sq += (X_off * p_mm - p_mm).squaredNorm();
    }
  }
  return std::sqrt(sum_sq / 6.0);
}

double flexion_range_rad(const FlexionTrial& trial, const FunctionalInput& input)
{
  FunctionalInput alone = input;
  alone.trials = {&trial, 1};
  return FunctionalProblem(alone).flexion_range_rad();
}

FunctionalFit fit_functional(const FunctionalInput& input, const std::string& file)
{
  const bench::FitErrorContext context{"", file};
  require_trials(input.trials, context);
  const FunctionalProblem problem(input);
  require_start(problem, input.trials, context);
  const Solution solution = solve(problem);
  const Eigen::VectorXd& x = solution.fit.x;
  const std::vector<MotionError> errors = held_out(problem, solution, input.trials, context);

  FunctionalFit fit;
  fit.X_thigh_femur = problem.X_thigh_femur(x);
  fit.X_shank_tibia = problem.X_shank_tibia(x);
  fit.flexion_range_rad = problem.flexion_range_rad();
  fit.n_beyond = problem.n_beyond();
  fit.landmarks_joint_mm = expected_joint_mm(problem.landmark_covariance());
  fit.joint_mm = expected_joint_mm(problem.centre_covariance(solution.fit));
  fit.held_out = rms_of(errors);
  std::vector<MotionError> by_landmarks;
  for (std::size_t k = 0; k < input.trials.size(); ++k)
    by_landmarks.push_back(error_of(problem, Eigen::VectorXd::Zero(n_functional), k).sum.rms());
  fit.by_landmarks = rms_of(by_landmarks);
  fit.deviation = deviation_of(problem, x);
  if (fit.joint_mm > most_of_landmarks * fit.landmarks_joint_mm) {
    context.fail("bends",
                 "an expected error at the joint of " + bench::text(fit.joint_mm, 1, "mm") +
                     ", from landmarks alone " + bench::text(fit.landmarks_joint_mm, 1, "mm"),
                 "a motion that determines the placement; bend further, or keep the landmarks");
  }
  fit.estimate = estimate_of(fit, problem.origin_covariance(solution.fit));
  std::vector<double> residuals_mm;
  for (const MotionError& error : errors) residuals_mm.push_back(error.mm);
  bench::set_residuals(fit.estimate, residuals_mm, "mm");
  fit.estimate.remarks = remarks_of(fit, input.settings);
  return fit;
}

}  // namespace vrda::calibration
