/// Symmetric positive definite matrices with few diagonals: Cholesky factor, solution, diagonal of the
/// inverse. Own loops in a fixed order: the same bits on every processor.
#pragma once

#include <Eigen/Core>

#include <array>
#include <vector>

#include "model/frames.hpp"
#include "model/linear_algebra.hpp"

namespace vrda::analysis {

/// Lower triangle of an n x n matrix with `width` diagonals below the main one.
class BandMatrix {
 public:
  BandMatrix(Eigen::Index n, Eigen::Index width);

  Eigen::Index size() const { return n_; }
  /// Element of row i and column j, i - width <= j <= i.
  double& at(Eigen::Index i, Eigen::Index j) { return values_[index(i, j)]; }
  double at(Eigen::Index i, Eigen::Index j) const { return values_[index(i, j)]; }

  /// Replaces the matrix by its factor L, L L^T = matrix.
  void factorise();
  /// The solution of matrix * x = b, after factorise().
  std::vector<double> solve(std::vector<double> b) const;
  /// Diagonal of the inverse, after factorise(). Source: Takahashi, Fagan and Chen (1973); Hutchinson and de
  /// Hoog (1985) Numer Math 47:99-106.
  std::vector<double> inverse_diagonal() const;

 private:
  std::size_t index(Eigen::Index i, Eigen::Index j) const
  {
    return static_cast<std::size_t>(i * (width_ + 1) + i - j);
  }
  Eigen::Index n_, width_;
  std::vector<double> values_;
};

// Rotation vectors, and a sequence of poses as the measurement plus a twist a frame in units of the
// measurement's noise.

using Vector6d = Eigen::Matrix<double, 6, 1>;  ///< rotations, then translations
using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// The rotation by |v| (rad) about v.
Eigen::Matrix3d rotation_of(const Eigen::Vector3d& v);
/// Inverse of rotation_of for rotations below pi - 1e-6.
Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& R);

/// Standard deviations of the errors of a measured pose: a small rotation about the canonical axes of the
/// reference, and the displacement along them of the moving object's point that lies at the rotation centre
/// in the zero pose. Errors of different frames and axes are independent. 0: exact, the coordinate is kept.
struct MeasurementNoise {
  Eigen::Vector3d rotation_rad = Eigen::Vector3d::Zero();
  Eigen::Vector3d translation_mm = Eigen::Vector3d::Zero();
};

/// Maps between twists in S and in units of the noise, whose norm is the Mahalanobis distance.
struct NoiseScale {
  Eigen::Matrix3d rotation, translation;                  ///< S from units of the noise
  Eigen::Matrix3d inverse_rotation, inverse_translation;  ///< zero rows for exact coordinates
};
NoiseScale noise_scale(const SolverFrame& frame, const MeasurementNoise& noise);

/// X (moving to reference, S at zero attitude) displaced by `twist`, in units of the noise: the rotation is
/// multiplied from the left, the translation of the origin added.
Pose displaced(const Pose& X_measured, const Vector6d& twist, const NoiseScale& scale);

/// d(left rotation of the displaced pose) / d(rotation part of the twist), S from units of the noise.
/// Expansion of the left Jacobian of SO(3); the error is the third power of the angle / 24.
Eigen::Matrix3d turn_per_twist(const Vector6d& twist, const NoiseScale& scale);

// Convex quadratic programme over a sequence of frames: neighbours coupled up to two frames apart, linear
// bounds within a frame.

/// normal . x >= offset for the six unknowns of one frame.
struct FrameBound {
  Vector6d normal;
  double offset = 0.0;
};

/// Minimise x^T H x / 2 - b^T x subject to the bounds. H is I plus a positive semidefinite matrix.
struct SequenceProgram {
  /// [n_frames] blocks of H: row k, columns k, k - 1 and k - 2.
  std::vector<std::array<Matrix6d, 3>> H;
  std::vector<Vector6d> b;                      ///< [n_frames]
  std::vector<std::vector<FrameBound>> bounds;  ///< [n_frames]
};

/// The minimum; where bounds contradict each other, a point between them. The excess over bounds that can be
/// met is below 1e-6 of the unknowns' unit. Augmented Lagrangian with a semismooth Newton method: every
/// linear system has the band of H. Source: Hintermueller, Ito and Kunisch (2002) SIAM J Optim 13:865-888.
std::vector<Vector6d> minimise(const SequenceProgram& program);

// Second differences of a sequence of poses, and the weight of their squares that follows from the noise.

/// Second difference about frame `frame`, in units of the noise per squared mean spacing of the key, and its
/// derivatives over the twists of the frame before, of the frame and of the one after it.
struct SecondDifference {
  std::size_t frame = 0;
  Vector6d value = Vector6d::Zero();
  std::array<Matrix6d, 3> jacobian{};
};

/// Of the first differences of the poses: rotation vectors from one frame to the next, in S, and
/// displacements of the origin. Empty below three frames. `twist` are those of displaced() that gave `X`.
std::vector<SecondDifference> second_differences(const std::vector<double>& key, const std::vector<Pose>& X,
                                                 const std::vector<Vector6d>& twist, const NoiseScale& scale);

/// Weight of the squared second differences of each coordinate that minimises the expected squared error of
/// the smoothed measurement, estimated without knowing the truth: residual + 2 trace (Mallows' C_p; Craven
/// and Wahba (1979) Numer Math 31:377-403, eq. 1.9). Powers of 2; 0 for an exact coordinate and below three
/// frames.
Vector6d weights_from_noise(const std::vector<double>& key, const std::vector<Pose>& X_measured,
                            const NoiseScale& scale);

/// The weight at which an oscillation of this period (in mean spacings of the key, above 2) keeps half its
/// amplitude, and the inverse: 2 for weights that do so at no period, infinite where none passes.
double weight_of_period(double period_frames);
double period_of_weight(double weight);

}  // namespace vrda::analysis
