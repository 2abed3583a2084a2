
#include <Eigen/Cholesky>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "bench/rigid_body.hpp"
#include "calibration/calibrate.hpp"
#include "core/text.hpp"
#include "store/motion.hpp"
#include "store/motion_model.hpp"
#include "store/solved_cells.hpp"

namespace vrda::calibration {
namespace {

constexpr std::size_t n_leading = 5, n_coordinates = 6;

/// Derivative at a knot by one step.
JointCurve::Knot slope_at(const std::vector<JointCurve::Knot>& knots, std::size_t k)
{
  const std::size_t before = k == 0 ? 0 : k - 1, after = std::min(k + 1, knots.size() - 1);
  return (knots[after] - knots[before]) / static_cast<double>(after - before);
}

JointCurve::Knot coordinates_at(const JointCurve& curve, double flexion_rad)
{
  const double at = (flexion_rad - curve.first_rad) / curve.step_rad;
  const double last = static_cast<double>(curve.knots.size() - 1);
  if (at <= 0.0) return curve.knots.front() + at * slope_at(curve.knots, 0);
  if (at >= last) return curve.knots.back() + (at - last) * slope_at(curve.knots, curve.knots.size() - 1);
  const auto k = std::min(static_cast<std::size_t>(at), curve.knots.size() - 2);
  const double s = at - static_cast<double>(k), r = 1.0 - s;
  return r * r * (1.0 + 2.0 * s) * curve.knots[k] + s * s * (1.0 + 2.0 * r) * curve.knots[k + 1] +
         s * r * r * slope_at(curve.knots, k) - s * s * r * slope_at(curve.knots, k + 1);
}

}  // namespace

Pose JointCurve::at(double flexion_rad) const
{
  return bench::moved(Pose::Identity(), coordinates_at(*this, flexion_rad));
}

JointCurve scaled(const JointCurve& curve, double scale)
{
  JointCurve result = curve;
  result.centre_mm *= scale;
  for (JointCurve::Knot& knot : result.knots) knot.head<3>() *= scale;
  return result;
}

std::vector<double> numbers_of(const JointCurve& curve)
{
  std::vector<double> numbers(curve.centre_mm.begin(), curve.centre_mm.end());
  numbers.push_back(deg_from_rad(curve.first_rad));
  numbers.push_back(deg_from_rad(curve.step_rad));
  for (const JointCurve::Knot& knot : curve.knots) {
    for (Eigen::Index k = 0; k < knot.size(); ++k) numbers.push_back(k < 3 ? knot[k] : deg_from_rad(knot[k]));
  }
  return numbers;
}

JointCurve joint_curve_of(std::span<const double> numbers, const std::string& field, const std::string& file)
{
  const bool is_whole = numbers.size() >= n_leading + 2 * n_coordinates &&
                        (numbers.size() - n_leading) % n_coordinates == 0 &&
                        std::ranges::all_of(numbers, [](double x) { return std::isfinite(x); });
  if (!is_whole || !(numbers[4] > 0.0)) {
    bench::FitErrorContext{"", file}.fail(
        field, std::to_string(numbers.size()) + " numbers",
        "the joint's motion: centre, first flexion, step above 0, then two or more poses");
  }
  JointCurve curve;
  curve.centre_mm = Eigen::Vector3d::Map(numbers.data());
  curve.first_rad = rad_from_deg(numbers[3]);
  curve.step_rad = rad_from_deg(numbers[4]);
  for (std::size_t at = n_leading; at < numbers.size(); at += n_coordinates) {
    curve.knots.emplace_back(JointCurve::Knot::Map(numbers.data() + at));
    curve.knots.back().tail<3>() *= rad_from_deg(1.0);
  }
  return curve;
}

namespace {

// Residuals of a functional registration and their derivatives.
//
// The model's joint moves by F(flexion), and the subject's by F D, with a deviation D smooth in flexion.
// Tracked is X_thigh_shank = A F D B^-1, with the femur A in the thigh's body and the tibia B in the
// shank's. All frames of bones have their origin at the joint's centre, so that mm and degrees of D are
// those at the joint.

using Vector6 = Eigen::Matrix<double, 6, 1>;

/// A tracked pose with the flexion at which the solution for its own flexion starts.
struct FunctionalSample {
  std::size_t trial = 0;
  Pose X_thigh_shank = Pose::Identity();
  double start_rad = 0.0;
  Matrix6 whitening = Matrix6::Identity();  ///< makes the covariance of its twist the identity
};

/// Unknowns of a fit: shift (mm) and rotation vector (rad, fixed axes) of femur and tibia from the landmarks,
/// then coefficients of the deviation with unit variance, by coordinate.
constexpr Eigen::Index n_placement = 12, n_terms = 5, n_deviation = 6 * n_terms;
constexpr Eigen::Index n_functional = n_placement + n_deviation;

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
  A.topRightCorner<3, 3>() = -cross_matrix(arm_mm);
  return A;
}

/// Twist at the origin of frame B for a twist (shift, turn) in frame A.
Matrix6 adjoint_inverse(const Pose& X_a_b)
{
  const Eigen::Matrix3d R_t = X_a_b.linear().transpose();
  Matrix6 A = Matrix6::Zero();
  A.topLeftCorner<3, 3>() = A.bottomRightCorner<3, 3>() = R_t;
  A.topRightCorner<3, 3>() = -R_t * cross_matrix(X_a_b.translation());
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
  const Eigen::Matrix3d W = cross_matrix(turn_rad);
  return Eigen::Matrix3d::Identity() + 0.5 * W + W * W / 6.0;
}

class FunctionalProblem {
 public:
  explicit FunctionalProblem(const FunctionalInput& input) : curve_(input.curve), settings_(input.settings)
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

  const std::vector<FunctionalSample>& samples() const { return samples_; }
  int n_beyond() const { return n_beyond_; }
  /// Of the used samples' flexions by landmarks.
  double flexion_range_rad() const
  {
    if (samples_.empty()) return 0.0;
    const auto [least, most] = std::ranges::minmax_element(samples_, {}, &FunctionalSample::start_rad);
    return most->start_rad - least->start_rad;
  }

  /// Fit to the samples of all trials but `without`, with noise `factor` times the stated one.
  LeastSquares fit(const Eigen::VectorXd& start, double factor, std::size_t without) const
  {
    FitProblem problem;
    problem.residuals = [=, this](const Eigen::VectorXd& x) { return residuals(x, factor, without); };
    problem.derivatives = [=, this](const Eigen::VectorXd& x) { return derivatives(x, factor, without); };
    problem.start = start;
    problem.scale = Eigen::VectorXd::Ones(n_functional);
    for (const Eigen::Index k : {3, 9}) problem.scale.segment<3>(k).setConstant(rad_from_deg(1.0));
    return fit_least_squares(problem);
  }

  static constexpr std::size_t without_none = static_cast<std::size_t>(-1);

  /// Difference between the tracked pose of a sample and the fitted one at its best flexion: twist in the
  /// tibia's frame (shift mm, turn rad), and whitened.
  struct Difference {
    double flexion_rad = 0.0;
    Vector6 twist, whitened;
  };
  Difference difference(const FunctionalSample& sample, const Eigen::VectorXd& x) const
  {
    const Moved bones = moved(x);
    const Pose X_femur_tibia = bones.X_femur_thigh * sample.X_thigh_shank * bones.X_shank_tibia;
    Difference found;
    found.flexion_rad = best_flexion(sample, X_femur_tibia, x);
    found.twist = twist_at(found.flexion_rad, X_femur_tibia, x);
    found.whitened = sample.whitening * found.twist;
    return found;
  }

  /// Coordinates of the deviation at a flexion: mm, rad.
  Vector6 deviation(const Eigen::VectorXd& x, double flexion_rad) const
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

  /// Placements with the origin of the model.
  Pose X_thigh_femur(const Eigen::VectorXd& x) const
  {
    return at_centre(moved(x).X_femur_thigh.inverse(), -curve_.centre_mm);
  }

  Pose X_shank_tibia(const Eigen::VectorXd& x) const
  {
    return at_centre(moved(x).X_shank_tibia, -curve_.centre_mm);
  }

  /// [12, 12] of the fit's placements, with the conventions of an bench::Estimate, mm and rad; at the joint's
  /// centre or at the model's origin.
  Eigen::MatrixXd centre_covariance(const LeastSquares& fit) const
  {
    Eigen::MatrixXd T = Eigen::MatrixXd::Identity(n_placement, n_placement);
    for (const Eigen::Index k : {3, 9}) T.block<3, 3>(k, k) = left_jacobian(fit.x.segment<3>(k));
    return propagated(T, fit.covariance.topLeftCorner(n_placement, n_placement));
  }

  Eigen::MatrixXd origin_covariance(const LeastSquares& fit) const
  {
    Eigen::MatrixXd T = Eigen::MatrixXd::Identity(n_placement, n_placement);
    T.block<6, 6>(0, 0) = at_point(-(X_thigh_femur(fit.x).linear() * curve_.centre_mm));
    T.block<6, 6>(6, 6) = at_point(-(X_shank_tibia(fit.x).linear() * curve_.centre_mm));
    return propagated(T, centre_covariance(fit));
  }

  /// The landmarks' own at the joint's centre.
  Eigen::MatrixXd landmark_covariance() const
  {
    Eigen::MatrixXd C = Eigen::MatrixXd::Zero(n_placement, n_placement);
    C.block<6, 6>(0, 0) = covariance_[0];
    C.block<6, 6>(6, 6) = covariance_[1];
    return C;
  }

 private:
  struct Moved {
    Pose X_femur_thigh, X_shank_tibia;  ///< femur and tibia at the joint's centre
  };
  struct Sides {
    Moved high, low;  ///< one unknown moved by a step of central differences
  };
  Moved moved(const Eigen::VectorXd& x) const
  {
    return {bench::moved(X_body_bone_[0], x.segment<6>(0)).inverse(),
            bench::moved(X_body_bone_[1], x.segment<6>(6))};
  }

  std::array<Sides, n_placement> moved_sides(const Eigen::VectorXd& x) const
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

  /// Between frames at the joint's centre.
  Pose X_femur_tibia_of_model(double flexion_rad) const
  {
    Pose X = at_centre(curve_.at(flexion_rad), curve_.centre_mm);
    X.translation() -= curve_.centre_mm;
    return X;
  }

  /// -1 at the first flexion of the model, 1 at its last.
  double share_of(double flexion_rad) const
  {
    return 2.0 * (flexion_rad - curve_.first_rad) / (curve_.last_rad() - curve_.first_rad) - 1.0;
  }

  /// Standard deviation of one of the three coordinates of a length or angle.
  double deviation_sd(Eigen::Index coordinate) const
  {
    const double whole = coordinate < 3 ? settings_.model_sd_mm : settings_.model_sd_rad;
    return whole * std::sqrt(1.0 / 3.0);
  }

  Vector6 twist_at(double flexion_rad, const Pose& X_femur_tibia, const Eigen::VectorXd& x) const
  {
    const Vector6 six = deviation(x, flexion_rad);
    const Pose X_deviation = bench::moved(Pose::Identity(), six);
    return twist_of(X_deviation.inverse() * (X_femur_tibia_of_model(flexion_rad).inverse() * X_femur_tibia));
  }

  Vector6 flexion_derivative(const FunctionalSample& sample, double flexion_rad, const Pose& X_femur_tibia,
                             const Eigen::VectorXd& x) const
  {
    const Vector6 high = twist_at(flexion_rad + turn_step_rad, X_femur_tibia, x);
    const Vector6 low = twist_at(flexion_rad - turn_step_rad, X_femur_tibia, x);
    return sample.whitening * (high - low) / (2.0 * turn_step_rad);
  }

  /// Gauss-Newton in one unknown; the residual is nearly linear in it.
  double best_flexion(const FunctionalSample& sample, const Pose& X_femur_tibia,
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

  /// The nearest flexion without deviation, to a coarse step; up to 40 degrees beyond the ends.
  double scanned_flexion(const FunctionalSample& sample, const Pose& X_femur_tibia) const
  {
    constexpr double step_rad = rad_from_deg(1.0), beyond_rad = rad_from_deg(40.0);
    double best_rad = curve_.first_rad, least = std::numeric_limits<double>::infinity();
    const double last_rad = curve_.last_rad() + beyond_rad;
    for (double at_rad = curve_.first_rad - beyond_rad; at_rad <= last_rad; at_rad += step_rad) {
      const double square =
          (sample.whitening * twist_of(X_femur_tibia_of_model(at_rad).inverse() * X_femur_tibia))
              .squaredNorm();
      if (square < least) {
        least = square;
        best_rad = at_rad;
      }
    }
    return best_rad;
  }

  void add_sample(const Pose& X_thigh_shank, std::size_t trial)
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

  Eigen::VectorXd residuals(const Eigen::VectorXd& x, double factor, std::size_t without) const
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

  /// With the flexion eliminated: its direction is projected out. Source: Kaufman (1975) BIT 15:49-57. By
  /// central differences of one sample, which are exact enough and cheap.
  Eigen::Matrix<double, 6, n_functional> sample_derivatives(const FunctionalSample& sample,
                                                            const Eigen::VectorXd& x,
                                                            const std::array<Sides, n_placement>& sides) const
  {
    const Moved here = moved(x);
    const Pose X_femur_tibia = here.X_femur_thigh * sample.X_thigh_shank * here.X_shank_tibia;
    const double flexion_rad = best_flexion(sample, X_femur_tibia, x);
    const Vector6 six = deviation(x, flexion_rad);
    const Pose X_tibia_femur = X_femur_tibia_of_model(flexion_rad).inverse();
    const auto twist = [&](const Vector6& off, const Moved& at) {
      const Pose X_deviation = bench::moved(Pose::Identity(), off);
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

  Eigen::MatrixXd derivatives(const Eigen::VectorXd& x, double factor, std::size_t without) const
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

  Eigen::Index n_used(std::size_t without) const
  {
    return std::ranges::count_if(samples_, [&](const FunctionalSample& s) { return s.trial != without; });
  }

  JointCurve curve_;
  bench::FunctionalSettings settings_;
  std::array<Pose, 2> X_body_bone_;            ///< by landmarks, at the joint's centre
  std::array<Matrix6, 2> covariance_, prior_;  ///< prior: whitening of the landmarks
  std::vector<FunctionalSample> samples_;
  int n_beyond_ = 0;
};

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
  void add(const Vector6& twist)
  {
    mm2_ += twist.head<3>().squaredNorm();
    rad2_ += twist.tail<3>().squaredNorm();
    n_ += 1.0;
  }
  MotionError rms() const
  {
    if (n_ <= 0.0) return {};
    return {std::sqrt(mm2_ / n_), std::sqrt(rad2_ / n_)};
  }
  double n() const { return n_; }

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

/// Differences of a trial, with its residual in units of the stated noise.
struct TrialError {
  TwistSum sum;
  double whitened = 0.0;
};

TrialError error_of(const FunctionalProblem& problem, const Eigen::VectorXd& x, std::size_t trial)
{
  constexpr double n_free = 5.0;  // of the six coordinates: flexion is fitted
  TrialError error;
  double sum_sq = 0.0;
  for (const FunctionalSample& sample : problem.samples()) {
    if (sample.trial != trial) continue;
    const FunctionalProblem::Difference found = problem.difference(sample, x);
    error.sum.add(found.twist);
    sum_sq += found.whitened.squaredNorm();
  }
  error.whitened = std::sqrt(sum_sq / (n_free * error.sum.n()));
  return error;
}

/// Checks each trial with the placements by landmarks.
void require_start(const FunctionalProblem& problem, std::span<const FlexionTrial> trials,
                   const bench::FitErrorContext& context)
{
  const Eigen::VectorXd landmarks = Eigen::VectorXd::Zero(n_functional);
  for (std::size_t k = 0; k < trials.size(); ++k) {
    const TwistSum sum = error_of(problem, landmarks, k).sum;
    constexpr int least_samples = 10;
    if (sum.n() < least_samples) {
      context.fail(
          trials[k].name,
          short_decimal(sum.n(), 0) + " samples within the model's flexions, by the landmarks",
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
  require_converged(fit, "bends", "a fit",
                    "bends that determine the placement; repeat them, or the landmarks", context);
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
                                       ", from landmarks alone " +
                                       bench::text(fit.landmarks_joint_mm, 1, "mm"),
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

// The motion of a model along its flexion, for functional registration.

namespace {

JointCurve::Knot knot_at(const store::Motion& motion, double flexion_rad, const std::string& file)
{
  const store::JointPose pose = motion.at({flexion_rad, motion.balanced_varus_rad(flexion_rad)});
  if (pose.status != store::PoseStatus::solved) {
    throw InputError({file, "flexion",
                      "no solved pose at " + short_decimal(deg_from_rad(flexion_rad), 1) + " degrees",
                      "a motion solved at all flexions; choose another --set, as degree_6"});
  }
  JointCurve::Knot knot;
  knot << pose.X_reference_moving.translation(), bench::turn_of(pose.X_reference_moving.linear());
  return knot;
}

}  // namespace

JointCurve joint_curve(const std::string& file, const std::string& set)
{
  const store::MotionModel model = store::read_motion_model(file);
  store::require_grid(model, file, "a functional registration");
  const store::Motion motion(model, store::chosen_set(model, file, set));
  const double range_rad = motion.last_flexion_rad() - motion.first_flexion_rad();
  if (!(range_rad > 0.0))
    throw InputError(
        {file, "flexion", "one flexion", "a range of flexions, to compare with the leg's motion"});
  constexpr double step_rad = rad_from_deg(2.0);
  const int n_steps = std::max(1, static_cast<int>(std::lround(range_rad / step_rad)));
  JointCurve curve;
  curve.centre_mm = store::solver_frame(model, 0).rotation_centre_mm;
  curve.first_rad = motion.first_flexion_rad();
  curve.step_rad = range_rad / n_steps;
  for (int k = 0; k <= n_steps; ++k)
    curve.knots.push_back(knot_at(motion, curve.first_rad + k * curve.step_rad, file));
  return curve;
}

}  // namespace vrda::calibration
