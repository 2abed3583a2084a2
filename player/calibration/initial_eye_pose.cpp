// A first pose of the eyes in the head's frame, from bullseye marks: the start of the fit.
#include "calibration/eyes_fit.hpp"

#include <Eigen/LU>
#include <limits>
#include <vector>

#include "bench/body_pose.hpp"

namespace vrda::calibration {
namespace {

/// Line of sight of a mark, in the frame of the eyes.
struct Sight {
  Eigen::Vector3d from_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d along = Eigen::Vector3d::Zero();   ///< unit
  Eigen::Matrix3d across = Eigen::Matrix3d::Zero();  ///< projects onto the plane across the line
  Eigen::Vector3d p_carrier_mm = Eigen::Vector3d::Zero();
};

std::vector<Sight> sights_of(std::span<const BullseyeMark> marks, const view::EyePair& eyes)
{
  std::vector<Sight> sights;
  for (const BullseyeMark& mark : marks) {
    const view::Eye& eye = mark.is_right ? eyes.right : eyes.left;
    const Eigen::Vector2d off_px = view::shown_px(eye.distortion, mark.drawn_px) - eye.sight_px;
    Sight sight;
    sight.from_mm = eye.position_head_mm;
    sight.along = Eigen::Vector3d(off_px.x(), -eye.pixel_aspect * off_px.y(), -eye.distance_px).normalized();
    sight.across = Eigen::Matrix3d::Identity() - sight.along * sight.along.transpose();
    sight.p_carrier_mm = mark.p_carrier_mm;
    sights.push_back(sight);
  }
  return sights;
}

struct PoseCandidate {
  Pose X_eyes_carrier = Pose::Identity();
  double error_mm2 = std::numeric_limits<double>::infinity();
  bool is_in_front = false;
};

/// Sets the least-squares translation for the rotation of X_eyes_carrier.
void set_translation(const std::vector<Sight>& sights, const Eigen::Matrix3d& inverse, Pose& X_eyes_carrier)
{
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Sight& s : sights) sum += s.across * (s.from_mm - X_eyes_carrier.linear() * s.p_carrier_mm);
  X_eyes_carrier.translation() = inverse * sum;
}

PoseCandidate iterate_from(const std::vector<Sight>& sights, const Eigen::Matrix3d& turn, int n_iterations)
{
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  Eigen::Vector3d mean_mm = Eigen::Vector3d::Zero();
  for (const Sight& s : sights) {
    sum += s.across;
    mean_mm += s.p_carrier_mm / static_cast<double>(sights.size());
  }
  const Eigen::Matrix3d inverse = sum.inverse();
  PoseCandidate candidate;
  Pose& X = candidate.X_eyes_carrier;
  X.linear() = turn;
  set_translation(sights, inverse, X);
  for (int iteration = 0; iteration < n_iterations; ++iteration) {
    Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
    for (const Sight& s : sights) {
      const Eigen::Vector3d on_sight_mm = s.from_mm + s.along * s.along.dot(X * s.p_carrier_mm - s.from_mm);
      H += on_sight_mm * (s.p_carrier_mm - mean_mm).transpose();
    }
    X.linear() = bench::nearest_rotation(H);
    set_translation(sights, inverse, X);
  }
  candidate.error_mm2 = 0.0;
  candidate.is_in_front = true;
  for (const Sight& s : sights) {
    const Eigen::Vector3d ray = X * s.p_carrier_mm - s.from_mm;
    candidate.error_mm2 += (s.across * ray).squaredNorm();
    candidate.is_in_front = candidate.is_in_front && s.along.dot(ray) > 0.0;
  }
  return candidate;
}

/// The 24 rotations that map a cube onto itself.
std::vector<Eigen::Matrix3d> cube_rotations()
{
  std::vector<Eigen::Matrix3d> turns;
  for (const int x : {0, 1, 2}) {
    for (const int y : {0, 1, 2}) {
      for (int signs = 0; x != y && signs < 4; ++signs) {
        const Eigen::Vector3d first = (signs % 2 == 0 ? 1.0 : -1.0) * Eigen::Vector3d::Unit(x);
        const Eigen::Vector3d second = (signs / 2 == 0 ? 1.0 : -1.0) * Eigen::Vector3d::Unit(y);
        Eigen::Matrix3d turn;
        turn << first, second, first.cross(second);
        turns.push_back(turn);
      }
    }
  }
  return turns;
}

}  // namespace

Pose initial_eye_pose(std::span<const BullseyeMark> marks, const view::EyePair& eyes)
{
  constexpr std::size_t least_marks = 3;
  if (marks.size() < least_marks) return Pose::Identity();
  const std::vector<Sight> sights = sights_of(marks, eyes);
  // A few iterations from each rotation select the best one, which is then refined.
  constexpr int n_selecting = 20, n_refining = 200;
  PoseCandidate best;
  for (const Eigen::Matrix3d& turn : cube_rotations()) {
    const PoseCandidate candidate = iterate_from(sights, turn, n_selecting);
    const bool is_better = candidate.is_in_front == best.is_in_front ? candidate.error_mm2 < best.error_mm2
                                                                     : candidate.is_in_front;
    if (is_better) best = candidate;
  }
  return iterate_from(sights, best.X_eyes_carrier.linear(), n_refining).X_eyes_carrier.inverse();
}

}  // namespace vrda::calibration
