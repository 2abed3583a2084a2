#include "analysis/rigid_alignment.hpp"

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/error.hpp"

namespace vrda::analysis {
namespace {

using Cloud = Eigen::Matrix<double, 3, 6>;
using Normal = Eigen::Matrix<double, 12, 12>;
using Step = Eigen::Matrix<double, 12, 1>;  ///< turn (times the radius) and shift of each frame, mm

constexpr int n_alternations = 30;
constexpr int max_steps = 100;
// Of points of some 100 mm with rounding of 1e-14 mm each.
constexpr double converged_step_mm = 1e-10;
// Directions in which a unit step moves the points by less than this, of the largest, count as undetermined.
constexpr double undetermined_sq = 1e-12;
// Frames that differ by a large rotation leave far more than the noise from the start at the identity.
constexpr double clearly_better = 2.0;
constexpr double same_mm = 1e-6;  ///< of distances that are rounding

struct Problem {
  const std::vector<Pose>& found;
  const std::vector<Pose>& measured;
  Eigen::Vector3d centre_mm;
  Cloud points_mm;
  double noise_mm = 0.0;  ///< distance that no transform removes; 0: unknown
};

Cloud around(const Eigen::Vector3d& centre_mm)
{
  Cloud points;
  const Eigen::Matrix3d axes = alignment_radius_mm * Eigen::Matrix3d::Identity();
  points << axes, -axes;
  return points.colwise() + centre_mm;
}

double rms_mm(const Problem& problem, const RigidAlignment& at)
{
  double sum = 0.0;
  for (std::size_t k = 0; k < problem.found.size(); ++k) {
    const Pose image = at.X_reference * problem.found[k] * at.X_moving;
    const Cloud left = (image * problem.points_mm) - (problem.measured[k] * problem.points_mm);
    sum += left.squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(6 * problem.found.size()));
}

/// The rigid transform that brings `from` nearest to `to`, column by column.
Pose closed_form(const Eigen::Matrix3Xd& from, const Eigen::Matrix3Xd& to)
{
  return Pose(Eigen::umeyama(from, to, false));
}

void fit_moving(const Problem& problem, RigidAlignment& at)
{
  const auto n = static_cast<Eigen::Index>(problem.found.size());
  Eigen::Matrix3Xd to(3, 6 * n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const auto frame = static_cast<std::size_t>(k);
    const Pose image = (at.X_reference * problem.found[frame]).inverse() * problem.measured[frame];
    to.middleCols<6>(6 * k) = image * problem.points_mm;
  }
  at.X_moving = closed_form(problem.points_mm.replicate(1, n), to);
}

void fit_reference(const Problem& problem, RigidAlignment& at)
{
  const auto n = static_cast<Eigen::Index>(problem.found.size());
  Eigen::Matrix3Xd from(3, 6 * n), to(3, 6 * n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const auto frame = static_cast<std::size_t>(k);
    from.middleCols<6>(6 * k) = (problem.found[frame] * at.X_moving) * problem.points_mm;
    to.middleCols<6>(6 * k) = problem.measured[frame] * problem.points_mm;
  }
  at.X_reference = closed_form(from, to);
}

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v)
{
  Eigen::Matrix3d V;
  V << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return V;
}

/// A small motion that turns about the centre; no sine is needed, as only its first order matters.
Pose moved_by(const Eigen::Ref<const Eigen::Matrix<double, 6, 1>>& step, const Eigen::Vector3d& centre_mm)
{
  const Eigen::Vector3d half_turn = 0.5 * step.head<3>() / alignment_radius_mm;
  const Eigen::Quaterniond turn =
      Eigen::Quaterniond(1.0, half_turn.x(), half_turn.y(), half_turn.z()).normalized();
  Pose X = Pose::Identity();
  X.linear() = turn.toRotationMatrix();
  X.translation() = centre_mm - X.linear() * centre_mm + step.tail<3>();
  return X;
}

/// The Gauss-Newton step of least norm.
Step newton_step(const Problem& problem, RigidAlignment& at)
{
  Normal H = Normal::Zero();
  Step g = Step::Zero();
  for (std::size_t k = 0; k < problem.found.size(); ++k) {
    const Pose image = at.X_reference * problem.found[k] * at.X_moving;
    for (Eigen::Index p = 0; p < problem.points_mm.cols(); ++p) {
      const Eigen::Vector3d point = problem.points_mm.col(p), q = image * point;
      Eigen::Matrix<double, 3, 12> J;
      J << -cross_matrix(q - problem.centre_mm) / alignment_radius_mm, Eigen::Matrix3d::Identity(),
          -image.linear() * cross_matrix(point - problem.centre_mm) / alignment_radius_mm, image.linear();
      H += J.transpose() * J;
      g += J.transpose() * (problem.measured[k] * point - q);
    }
  }
  const Eigen::SelfAdjointEigenSolver<Normal> modes(H);
  // A short motion gives no information along a direction in which a radian, or the radius, changes less than
  // the noise: the transforms are not changed along it.
  const double relative_noise = problem.noise_mm / alignment_radius_mm;
  const double n_points = 6.0 * static_cast<double>(problem.found.size());
  const double smallest =
      std::max(undetermined_sq * modes.eigenvalues().maxCoeff(), n_points * relative_noise * relative_noise);
  Step step = Step::Zero();
  at.n_determined = 0;
  for (Eigen::Index m = 0; m < 12; ++m) {
    if (modes.eigenvalues()[m] <= smallest) continue;
    step += modes.eigenvectors().col(m) * (modes.eigenvectors().col(m).dot(g) / modes.eigenvalues()[m]);
    ++at.n_determined;
  }
  return step;
}

/// Steps until they are as small as rounding; a step that does not come nearer is halved.
void refine(const Problem& problem, RigidAlignment& at)
{
  at.rms_mm = rms_mm(problem, at);
  for (int k = 0; k < max_steps && !at.is_converged; ++k) {
    Step step = newton_step(problem, at);
    RigidAlignment next = at;
    const auto take = [&] {
      next.X_reference = moved_by(step.head<6>(), problem.centre_mm) * at.X_reference;
      next.X_moving = at.X_moving * moved_by(step.tail<6>(), problem.centre_mm);
      next.rms_mm = rms_mm(problem, next);
    };
    take();
    while (next.rms_mm > at.rms_mm && step.norm() > converged_step_mm) {
      step *= 0.5;
      take();
    }
    at.is_converged = step.norm() <= converged_step_mm;
    if (next.rms_mm <= at.rms_mm) {
      next.is_converged = at.is_converged;
      at = next;
    }
  }
}

RigidAlignment from_rotation(const Problem& problem, const Eigen::Matrix3d& R_start)
{
  RigidAlignment at;
  at.X_reference.linear() = R_start;
  at.X_reference.translation() = problem.centre_mm - R_start * problem.centre_mm;
  for (int k = 0; k < n_alternations; ++k) {
    fit_moving(problem, at);
    fit_reference(problem, at);
  }
  refine(problem, at);
  return at;
}

/// The 24 rotations of a cube, the identity first.
std::vector<Eigen::Matrix3d> cube_rotations()
{
  std::vector<Eigen::Matrix3d> rotations;
  std::array<int, 3> order{0, 1, 2};
  do {
    for (int signs = 0; signs < 8; ++signs) {
      Eigen::Matrix3d R = Eigen::Matrix3d::Zero();
      for (int row = 0; row < 3; ++row)
        R(row, order[static_cast<std::size_t>(row)]) = (signs >> row) % 2 == 0 ? 1.0 : -1.0;
      if (R.determinant() > 0.0) rotations.push_back(R);
    }
  } while (std::next_permutation(order.begin(), order.end()));
  return rotations;
}

}  // namespace

RigidAlignment rigid_alignment(const std::vector<Pose>& found, const std::vector<Pose>& measured,
                               const Eigen::Vector3d& rotation_centre_mm)
{
  check(found.size() == measured.size() && !found.empty(), "an alignment has pairs of poses");
  Problem problem{found, measured, rotation_centre_mm, around(rotation_centre_mm)};
  RigidAlignment best;
  best.rms_mm = std::numeric_limits<double>::infinity();
  for (const Eigen::Matrix3d& R_start : cube_rotations()) {
    const RigidAlignment here = from_rotation(problem, R_start);
    if (here.rms_mm < best.rms_mm - same_mm) best = here;
  }
  problem.noise_mm = best.rms_mm;
  RigidAlignment near;
  refine(problem, near);
  if (near.rms_mm <= clearly_better * best.rms_mm + same_mm) return near;
  newton_step(problem, best);  // counts the determined directions
  return best;
}

}  // namespace vrda::analysis
