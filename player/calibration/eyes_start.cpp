#include "calibration/eyes_fit.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <limits>
#include <vector>

namespace vrda {
namespace {

/// A mark as one eye sees it, in the eyes' frame.
struct Sight {
  Eigen::Vector3d from_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d along = Eigen::Vector3d::Zero();   ///< unit
  Eigen::Matrix3d across = Eigen::Matrix3d::Zero();  ///< takes the part along away
  Eigen::Vector3d p_carrier_mm = Eigen::Vector3d::Zero();
};

std::vector<Sight> sights_of(std::span<const BullseyeMark> marks, const EyePair& eyes)
{
  std::vector<Sight> sights;
  for (const BullseyeMark& mark : marks) {
    const Eye& eye = mark.is_right ? eyes.right : eyes.left;
    const Eigen::Vector2d off_px = shown_px(eye.distortion, mark.drawn_px) - eye.sight_px;
    Sight sight;
    sight.from_mm = eye.position_head_mm;
    sight.along = Eigen::Vector3d(off_px.x(), -eye.pixel_aspect * off_px.y(), -eye.distance_px).normalized();
    sight.across = Eigen::Matrix3d::Identity() - sight.along * sight.along.transpose();
    sight.p_carrier_mm = mark.p_carrier_mm;
    sights.push_back(sight);
  }
  return sights;
}

struct Placed {
  Pose X_eyes_carrier = Pose::Identity();
  double error_mm2 = std::numeric_limits<double>::infinity();
  bool is_in_front = false;
};

/// The shift that goes best with the turn.
void put_shift(const std::vector<Sight>& sights, const Eigen::Matrix3d& inverse, Pose& X_eyes_carrier)
{
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Sight& s : sights) sum += s.across * (s.from_mm - X_eyes_carrier.linear() * s.p_carrier_mm);
  X_eyes_carrier.translation() = inverse * sum;
}

Placed placed_from(const std::vector<Sight>& sights, const Eigen::Matrix3d& turn, int n_iterations)
{
  const auto n = static_cast<Eigen::Index>(sights.size());
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const Sight& s : sights) sum += s.across;
  const Eigen::Matrix3d inverse = sum.inverse();
  Eigen::Matrix3Xd carrier_mm(3, n), on_sights_mm(3, n);
  for (Eigen::Index k = 0; k < n; ++k) carrier_mm.col(k) = sights[static_cast<std::size_t>(k)].p_carrier_mm;
  Placed placed;
  Pose& X = placed.X_eyes_carrier;
  X.linear() = turn;
  put_shift(sights, inverse, X);
  for (int iteration = 0; iteration < n_iterations; ++iteration) {
    for (Eigen::Index k = 0; k < n; ++k) {
      const Sight& s = sights[static_cast<std::size_t>(k)];
      on_sights_mm.col(k) = s.from_mm + s.along * s.along.dot(X * s.p_carrier_mm - s.from_mm);
    }
    const Eigen::Matrix4d moved = Eigen::umeyama(carrier_mm, on_sights_mm, false);
    X.linear() = moved.topLeftCorner<3, 3>();
    put_shift(sights, inverse, X);
  }
  placed.error_mm2 = 0.0;
  placed.is_in_front = true;
  for (const Sight& s : sights) {
    const Eigen::Vector3d way = X * s.p_carrier_mm - s.from_mm;
    placed.error_mm2 += (s.across * way).squaredNorm();
    placed.is_in_front = placed.is_in_front && s.along.dot(way) > 0.0;
  }
  return placed;
}

/// Turns that take a cube onto itself.
std::vector<Eigen::Matrix3d> cube_turns()
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

Pose eyes_start(std::span<const BullseyeMark> marks, const EyePair& eyes)
{
  constexpr std::size_t least_marks = 3;
  if (marks.size() < least_marks) return Pose::Identity();
  const std::vector<Sight> sights = sights_of(marks, eyes);
  // Some iterations show which attitudes lead anywhere.
  constexpr int n_tried = 20, n_wanted = 200;
  Placed best;
  for (const Eigen::Matrix3d& turn : cube_turns()) {
    const Placed placed = placed_from(sights, turn, n_tried);
    const bool is_better =
        placed.is_in_front == best.is_in_front ? placed.error_mm2 < best.error_mm2 : placed.is_in_front;
    if (is_better) best = placed;
  }
  return placed_from(sights, best.X_eyes_carrier.linear(), n_wanted).X_eyes_carrier.inverse();
}

}  // namespace vrda
