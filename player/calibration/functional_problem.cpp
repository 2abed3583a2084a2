#include "calibration/functional_problem.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "calibration/linear_algebra.hpp"
#include "core/units.hpp"
#include "bench/screw.hpp"

namespace vrda::calibration {
namespace {

/// Samples of a trial that are used, evenly spaced: noise is far below the deviation of the model.
constexpr std::size_t most_samples = 20;
/// Flexions beyond the model's range that are still used, its poses being extended linearly.
constexpr double most_beyond_rad = rad_from_deg(3.0);
constexpr double shift_step_mm = 1e-3, turn_step_rad = 1e-5;

/// Of central differences of a coordinate: shifts, then turns.
double step_of(Eigen::Index coordinate)
{
  return coordinate % 6 < 3 ? shift_step_mm : turn_step_rad;
}

Pose moved_pose(const Pose& X, const Eigen::Vector3d& shift_mm, const Eigen::Vector3d& turn_rad)
{
  Pose moved = X;
  moved.linear() = bench::rotation_of(turn_rad) * X.linear();
  moved.translation() += shift_mm;
  return moved;
}

Pose at_centre(const Pose& X, const Eigen::Vector3d& centre_mm)
{
  Pose shifted = X;
  shifted.translation() = X * centre_mm;
  return shifted;
}

/// Covariance of a pose's error at a point `arm_mm` (fixed axes) from the pose's origin.
Matrix6 at_point(const Eigen::Vector3d& arm_mm)
{
  Matrix6 A = Matrix6::Identity();
  A.topRightCorner<3, 3>() = -bench::cross_matrix(arm_mm);
  return A;
}

/// Twist at the origin of frame B for a twist (shift, turn) in frame A.
Matrix6 adjoint_inverse(const Pose& X_a_b)
{
  const Eigen::Matrix3d R_t = X_a_b.linear().transpose();
  Matrix6 A = Matrix6::Zero();
  A.topLeftCorner<3, 3>() = A.bottomRightCorner<3, 3>() = R_t;
  A.topRightCorner<3, 3>() = -R_t * bench::cross_matrix(X_a_b.translation());
  return A;
}

/// W with W^T W = C^-1.
Matrix6 whitening_of(const Matrix6& covariance)
{
  const Eigen::LLT<Matrix6> root(covariance);
  return root.matrixL().solve(Matrix6::Identity());
}

/// Legendre polynomials of u in [-1, 1] with these mean squares, whose sum is 1: about those of a deviation
/// that changes within 60 to 120 degrees. For one that is constant, or changes within 30, intervals hold in
/// 97 and 94 %.
std::array<double, n_terms> terms_at(double u)
{
  static constexpr std::array<double, n_terms> mean_squares{0.6, 0.25, 0.11, 0.03, 0.01};
  std::array<double, n_terms> P{1.0, u};
  for (std::size_t k = 1; k + 1 < P.size(); ++k) {
    const auto n = static_cast<double>(k);
    P[k + 1] = ((2.0 * n + 1.0) * u * P[k] - n * P[k - 1]) / (n + 1.0);
  }
  for (std::size_t k = 0; k < P.size(); ++k)
    P[k] *= std::sqrt((2.0 * static_cast<double>(k) + 1.0) * mean_squares[k]);
  return P;
}

Vector6 twist_of(const Pose& X)
{
  Vector6 twist;
  twist << X.translation(), bench::turn_of(X.linear());
  return twist;
}

/// Left Jacobian of the rotation vector, to its third order.
Eigen::Matrix3d left_jacobian(const Eigen::Vector3d& turn_rad)
{
  const Eigen::Matrix3d W = bench::cross_matrix(turn_rad);
  return Eigen::Matrix3d::Identity() + 0.5 * W + W * W / 6.0;
}

}  // namespace

FunctionalProblem::FunctionalProblem(const FunctionalInput& input)
    : curve_(input.curve), settings_(input.settings)
{
  const std::array<const BonePlacement*, 2> bones{&input.femur, &input.tibia};
  for (std::size_t k = 0; k < bones.size(); ++k) {
    const Pose& X = bones[k]->X_body_bone;
    X_body_bone_[k] = at_centre(X, input.curve.centre_mm);
    const Matrix6 A = at_point(X.linear() * input.curve.centre_mm);
    covariance_[k] = A * bones[k]->covariance_mm_rad * A.transpose();
    prior_[k] = whitening_of(covariance_[k]);
  }
  for (std::size_t k = 0; k < input.trials.size(); ++k) {
    const std::vector<Pose>& all = input.trials[k].X_thigh_shank;
    const std::size_t n = std::min(all.size(), most_samples);
    for (std::size_t i = 0; i < n; ++i) add_sample(all[i * all.size() / n], k);
  }
}

void FunctionalProblem::add_sample(const Pose& X_thigh_shank, std::size_t trial)
{
  const Pose& X_shank_tibia = X_body_bone_[1];
  const Pose X_thigh_tibia = X_thigh_shank * X_shank_tibia;
  const double sd_rad = settings_.tracker_sd_rad;
  Vector6 variance;
  variance.head<3>().setConstant(settings_.tracker_sd_mm * settings_.tracker_sd_mm);
  variance.tail<3>().setConstant(sd_rad * sd_rad);
  Matrix6 covariance = Matrix6::Zero();
  for (const Matrix6& A : {adjoint_inverse(X_thigh_tibia), adjoint_inverse(X_shank_tibia)})
    covariance += A * variance.asDiagonal() * A.transpose();
  FunctionalSample sample{trial, X_thigh_shank, 0.0, whitening_of(covariance)};
  const Pose X_femur_tibia = X_body_bone_[0].inverse() * X_thigh_tibia;
  sample.start_rad = scanned_flexion(sample, X_femur_tibia);
  const bool is_beyond = sample.start_rad < curve_.first_rad - most_beyond_rad ||
                         sample.start_rad > curve_.last_rad() + most_beyond_rad;
  if (is_beyond) {
    ++n_beyond_;
  } else {
    samples_.push_back(sample);
  }
}

double FunctionalProblem::flexion_range_rad() const
{
  if (samples_.empty()) return 0.0;
  const auto [least, most] = std::ranges::minmax_element(samples_, {}, &FunctionalSample::start_rad);
  return most->start_rad - least->start_rad;
}

/// The nearest flexion without deviation, to a coarse step; up to 40 degrees beyond the ends.
double FunctionalProblem::scanned_flexion(const FunctionalSample& sample, const Pose& X_femur_tibia) const
{
  constexpr double step_rad = rad_from_deg(1.0), beyond_rad = rad_from_deg(40.0);
  double best_rad = curve_.first_rad, least = std::numeric_limits<double>::infinity();
  const double last_rad = curve_.last_rad() + beyond_rad;
  for (double at_rad = curve_.first_rad - beyond_rad; at_rad <= last_rad; at_rad += step_rad) {
    const double square =
        (sample.whitening * twist_of(X_femur_tibia_of_model(at_rad).inverse() * X_femur_tibia)).squaredNorm();
    if (square < least) {
      least = square;
      best_rad = at_rad;
    }
  }
  return best_rad;
}

/// Between frames at the joint's centre.
Pose FunctionalProblem::X_femur_tibia_of_model(double flexion_rad) const
{
  Pose X = at_centre(curve_.at(flexion_rad), curve_.centre_mm);
  X.translation() -= curve_.centre_mm;
  return X;
}

/// -1 at the first flexion of the model, 1 at its last.
double FunctionalProblem::share_of(double flexion_rad) const
{
  return 2.0 * (flexion_rad - curve_.first_rad) / (curve_.last_rad() - curve_.first_rad) - 1.0;
}

/// Standard deviation of one of the three coordinates of a length or angle.
double FunctionalProblem::deviation_sd(Eigen::Index coordinate) const
{
  const double whole = coordinate < 3 ? settings_.model_sd_mm : settings_.model_sd_rad;
  return whole * std::sqrt(1.0 / 3.0);
}

Vector6 FunctionalProblem::deviation(const Eigen::VectorXd& x, double flexion_rad) const
{
  const std::array<double, n_terms> terms = terms_at(share_of(flexion_rad));
  Vector6 six = Vector6::Zero();
  for (Eigen::Index k = 0; k < 6; ++k) {
    for (Eigen::Index term = 0; term < n_terms; ++term)
      six[k] += terms[static_cast<std::size_t>(term)] * x[n_placement + k * n_terms + term];
    six[k] *= deviation_sd(k);
  }
  return six;
}

FunctionalProblem::Moved FunctionalProblem::moved(const Eigen::VectorXd& x) const
{
  return {moved_pose(X_body_bone_[0], x.segment<3>(0), x.segment<3>(3)).inverse(),
          moved_pose(X_body_bone_[1], x.segment<3>(6), x.segment<3>(9))};
}

Vector6 FunctionalProblem::twist_at(double flexion_rad, const Pose& X_femur_tibia,
                                    const Eigen::VectorXd& x) const
{
  const Vector6 six = deviation(x, flexion_rad);
  const Pose X_deviation = moved_pose(Pose::Identity(), six.head<3>(), six.tail<3>());
  return twist_of(X_deviation.inverse() * (X_femur_tibia_of_model(flexion_rad).inverse() * X_femur_tibia));
}

Vector6 FunctionalProblem::flexion_derivative(const FunctionalSample& sample, double flexion_rad,
                                              const Pose& X_femur_tibia, const Eigen::VectorXd& x) const
{
  const Vector6 high = twist_at(flexion_rad + turn_step_rad, X_femur_tibia, x);
  const Vector6 low = twist_at(flexion_rad - turn_step_rad, X_femur_tibia, x);
  return sample.whitening * (high - low) / (2.0 * turn_step_rad);
}

/// Gauss-Newton in one unknown; the residual is nearly linear in it.
double FunctionalProblem::best_flexion(const FunctionalSample& sample, const Pose& X_femur_tibia,
                                       const Eigen::VectorXd& x) const
{
  constexpr int most_steps = 30;
  constexpr double resolution_rad = 1e-12;
  double flexion_rad = sample.start_rad;
  for (int step = 0; step < most_steps; ++step) {
    const Vector6 by_flexion = flexion_derivative(sample, flexion_rad, X_femur_tibia, x);
    const Vector6 r = sample.whitening * twist_at(flexion_rad, X_femur_tibia, x);
    const double move_rad = -by_flexion.dot(r) / by_flexion.squaredNorm();
    flexion_rad += move_rad;
    if (std::abs(move_rad) < resolution_rad) break;
  }
  return flexion_rad;
}

FunctionalProblem::Difference FunctionalProblem::difference(const FunctionalSample& sample,
                                                            const Eigen::VectorXd& x) const
{
  const Moved bones = moved(x);
  const Pose X_femur_tibia = bones.X_femur_thigh * sample.X_thigh_shank * bones.X_shank_tibia;
  Difference found;
  found.flexion_rad = best_flexion(sample, X_femur_tibia, x);
  found.twist = twist_at(found.flexion_rad, X_femur_tibia, x);
  found.whitened = sample.whitening * found.twist;
  return found;
}

Eigen::Index FunctionalProblem::n_used(std::size_t without) const
{
  return std::ranges::count_if(samples_, [&](const FunctionalSample& s) { return s.trial != without; });
}

Eigen::VectorXd FunctionalProblem::residuals(const Eigen::VectorXd& x, double factor,
                                             std::size_t without) const
{
  Eigen::VectorXd r(n_functional + 6 * n_used(without));
  r.segment<6>(0) = prior_[0] * x.segment<6>(0);
  r.segment<6>(6) = prior_[1] * x.segment<6>(6);
  r.segment(n_placement, n_deviation) = x.tail(n_deviation);
  Eigen::Index row = n_functional;
  for (const FunctionalSample& sample : samples_) {
    if (sample.trial == without) continue;
    r.segment<6>(row) = difference(sample, x).whitened / factor;
    row += 6;
  }
  return r;
}

std::array<FunctionalProblem::Sides, n_placement> FunctionalProblem::moved_sides(
    const Eigen::VectorXd& x) const
{
  std::array<Sides, n_placement> sides;
  for (Eigen::Index k = 0; k < n_placement; ++k) {
    Eigen::VectorXd high = x, low = x;
    high[k] += step_of(k);
    low[k] -= step_of(k);
    sides[static_cast<std::size_t>(k)] = {moved(high), moved(low)};
  }
  return sides;
}

/// With the flexion eliminated: its direction is projected out. Source: Kaufman (1975) BIT 15:49-57. By
/// central differences of one sample, which are exact enough and cheap.
Eigen::Matrix<double, 6, n_functional> FunctionalProblem::sample_derivatives(
    const FunctionalSample& sample, const Eigen::VectorXd& x,
    const std::array<Sides, n_placement>& sides) const
{
  const Moved here = moved(x);
  const Pose X_femur_tibia = here.X_femur_thigh * sample.X_thigh_shank * here.X_shank_tibia;
  const double flexion_rad = best_flexion(sample, X_femur_tibia, x);
  const Vector6 six = deviation(x, flexion_rad);
  const Pose X_tibia_femur = X_femur_tibia_of_model(flexion_rad).inverse();
  const auto twist = [&](const Vector6& off, const Moved& at) {
    const Pose X_deviation = moved_pose(Pose::Identity(), off.head<3>(), off.tail<3>());
    return twist_of(X_deviation.inverse() *
                    (X_tibia_femur * (at.X_femur_thigh * sample.X_thigh_shank * at.X_shank_tibia)));
  };
  const Vector6 direction = flexion_derivative(sample, flexion_rad, X_femur_tibia, x).normalized();
  const Matrix6 project = (Matrix6::Identity() - direction * direction.transpose()) * sample.whitening;
  Eigen::Matrix<double, 6, n_functional> J;
  for (Eigen::Index k = 0; k < n_placement; ++k) {
    const Sides& side = sides[static_cast<std::size_t>(k)];
    J.col(k) = project * (twist(six, side.high) - twist(six, side.low)) / (2.0 * step_of(k));
  }
  const std::array<double, n_terms> terms = terms_at(share_of(flexion_rad));
  for (Eigen::Index k = 0; k < 6; ++k) {
    Vector6 high = six, low = six;
    high[k] += step_of(k);
    low[k] -= step_of(k);
    const Vector6 column = project * (twist(high, here) - twist(low, here)) / (2.0 * step_of(k));
    for (Eigen::Index term = 0; term < n_terms; ++term)
      J.col(n_placement + k * n_terms + term) =
          deviation_sd(k) * terms[static_cast<std::size_t>(term)] * column;
  }
  return J;
}

Eigen::MatrixXd FunctionalProblem::derivatives(const Eigen::VectorXd& x, double factor,
                                               std::size_t without) const
{
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(n_functional + 6 * n_used(without), n_functional);
  J.block<6, 6>(0, 0) = prior_[0];
  J.block<6, 6>(6, 6) = prior_[1];
  J.block<n_deviation, n_deviation>(n_placement, n_placement).setIdentity();
  const std::array<Sides, n_placement> sides = moved_sides(x);
  Eigen::Index row = n_functional;
  for (const FunctionalSample& sample : samples_) {
    if (sample.trial == without) continue;
    J.block<6, n_functional>(row, 0) = sample_derivatives(sample, x, sides) / factor;
    row += 6;
  }
  return J;
}

LeastSquares FunctionalProblem::fit(const Eigen::VectorXd& start, double factor, std::size_t without) const
{
  FitProblem problem;
  problem.residuals = [=, this](const Eigen::VectorXd& x) { return residuals(x, factor, without); };
  problem.derivatives = [=, this](const Eigen::VectorXd& x) { return derivatives(x, factor, without); };
  problem.start = start;
  problem.scale = Eigen::VectorXd::Ones(n_functional);
  for (const Eigen::Index k : {3, 9}) problem.scale.segment<3>(k).setConstant(rad_from_deg(1.0));
  return fit_least_squares(problem);
}

Pose FunctionalProblem::X_thigh_femur(const Eigen::VectorXd& x) const
{
  return at_centre(moved(x).X_femur_thigh.inverse(), -curve_.centre_mm);
}

Pose FunctionalProblem::X_shank_tibia(const Eigen::VectorXd& x) const
{
  return at_centre(moved(x).X_shank_tibia, -curve_.centre_mm);
}

Eigen::MatrixXd FunctionalProblem::centre_covariance(const LeastSquares& fit) const
{
  Eigen::MatrixXd T = Eigen::MatrixXd::Identity(n_placement, n_placement);
  for (const Eigen::Index k : {3, 9}) T.block<3, 3>(k, k) = left_jacobian(fit.x.segment<3>(k));
  return propagated(T, fit.covariance.topLeftCorner(n_placement, n_placement));
}

Eigen::MatrixXd FunctionalProblem::origin_covariance(const LeastSquares& fit) const
{
  Eigen::MatrixXd T = Eigen::MatrixXd::Identity(n_placement, n_placement);
  T.block<6, 6>(0, 0) = at_point(-(X_thigh_femur(fit.x).linear() * curve_.centre_mm));
  T.block<6, 6>(6, 6) = at_point(-(X_shank_tibia(fit.x).linear() * curve_.centre_mm));
  return propagated(T, centre_covariance(fit));
}

Eigen::MatrixXd FunctionalProblem::landmark_covariance() const
{
  Eigen::MatrixXd C = Eigen::MatrixXd::Zero(n_placement, n_placement);
  C.block<6, 6>(0, 0) = covariance_[0];
  C.block<6, 6>(6, 6) = covariance_[1];
  return C;
}

}  // namespace vrda::calibration
