/// Residuals of a functional registration and their derivatives. Internal to functional_fit.cpp.
///
/// The model's joint moves by F(flexion), and the subject's by F D, with a deviation D smooth in flexion.
/// Tracked is X_thigh_shank = A F D B^-1, with the femur A in the thigh's body and the tibia B in the
/// shank's. All frames of bones have their origin at the joint's centre, so that mm and degrees of D are
/// those at the joint.
#pragma once

#include <array>

#include "calibration/functional_fit.hpp"
#include "calibration/least_squares.hpp"

namespace vrda::calibration {

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
inline constexpr Eigen::Index n_placement = 12, n_terms = 5, n_deviation = 6 * n_terms;
inline constexpr Eigen::Index n_functional = n_placement + n_deviation;

class FunctionalProblem {
 public:
  explicit FunctionalProblem(const FunctionalInput& input);

  const std::vector<FunctionalSample>& samples() const { return samples_; }
  int n_beyond() const { return n_beyond_; }
  /// Of the used samples' flexions by landmarks.
  double flexion_range_rad() const;

  /// Fit to the samples of all trials but `without`, with noise `factor` times the stated one.
  LeastSquares fit(const Eigen::VectorXd& start, double factor, std::size_t without) const;
  static constexpr std::size_t without_none = static_cast<std::size_t>(-1);

  /// Difference between the tracked pose of a sample and the fitted one at its best flexion: twist in the
  /// tibia's frame (shift mm, turn rad), and whitened.
  struct Difference {
    double flexion_rad = 0.0;
    Vector6 twist, whitened;
  };
  Difference difference(const FunctionalSample& sample, const Eigen::VectorXd& x) const;

  /// Coordinates of the deviation at a flexion: mm, rad.
  Vector6 deviation(const Eigen::VectorXd& x, double flexion_rad) const;
  /// Placements with the origin of the model.
  Pose X_thigh_femur(const Eigen::VectorXd& x) const;
  Pose X_shank_tibia(const Eigen::VectorXd& x) const;
  /// [12, 12] of the fit's placements, with the conventions of an bench::Estimate, mm and rad; at the joint's centre
  /// or at the model's origin.
  Eigen::MatrixXd centre_covariance(const LeastSquares& fit) const;
  Eigen::MatrixXd origin_covariance(const LeastSquares& fit) const;
  /// The landmarks' own at the joint's centre.
  Eigen::MatrixXd landmark_covariance() const;

 private:
  struct Moved {
    Pose X_femur_thigh, X_shank_tibia;  ///< femur and tibia at the joint's centre
  };
  struct Sides {
    Moved high, low;  ///< one unknown moved by a step of central differences
  };
  Moved moved(const Eigen::VectorXd& x) const;
  std::array<Sides, n_placement> moved_sides(const Eigen::VectorXd& x) const;
  Pose X_femur_tibia_of_model(double flexion_rad) const;
  double share_of(double flexion_rad) const;
  double deviation_sd(Eigen::Index coordinate) const;
  Vector6 twist_at(double flexion_rad, const Pose& X_femur_tibia, const Eigen::VectorXd& x) const;
  Vector6 flexion_derivative(const FunctionalSample& sample, double flexion_rad, const Pose& X_femur_tibia,
                             const Eigen::VectorXd& x) const;
  double best_flexion(const FunctionalSample& sample, const Pose& X_femur_tibia,
                      const Eigen::VectorXd& x) const;
  double scanned_flexion(const FunctionalSample& sample, const Pose& X_femur_tibia) const;
  void add_sample(const Pose& X_thigh_shank, std::size_t trial);
  Eigen::VectorXd residuals(const Eigen::VectorXd& x, double factor, std::size_t without) const;
  Eigen::Matrix<double, 6, n_functional> sample_derivatives(
      const FunctionalSample& sample, const Eigen::VectorXd& x,
      const std::array<Sides, n_placement>& sides) const;
  Eigen::MatrixXd derivatives(const Eigen::VectorXd& x, double factor, std::size_t without) const;
  Eigen::Index n_used(std::size_t without) const;

  JointCurve curve_;
  bench::FunctionalSettings settings_;
  std::array<Pose, 2> X_body_bone_;            ///< by landmarks, at the joint's centre
  std::array<Matrix6, 2> covariance_, prior_;  ///< prior: whitening of the landmarks
  std::vector<FunctionalSample> samples_;
  int n_beyond_ = 0;
};

}  // namespace vrda::calibration
