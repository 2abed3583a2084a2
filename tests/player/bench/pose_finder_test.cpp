// Poses of the printed bodies in rendered pictures of known truth: 640 x 480, blur, noise.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "bench/webcam.hpp"
#include "core/units.hpp"
#include "player/bench/rendered_pictures.hpp"
#include "support/refusal.hpp"

namespace vrda::pose_finder_test {

using bench::BodyState;
using bench::FoundBody;

/// A leg seen from its lateral side: bodies 130 mm above and below the knee.
std::vector<Pose> leg(double distance_mm, double flexion_rad, double yaw_rad = 0.0)
{
  Eigen::Matrix3d facing;
  facing << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  const Eigen::Vector3d knee_mm(-60.0, -20.0, distance_mm);
  Pose X_thigh = Pose::Identity(), X_shank = Pose::Identity();
  X_thigh.linear() = facing * Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitY()).toRotationMatrix();
  X_shank.linear() =
      X_thigh.linear() * Eigen::AngleAxisd(-flexion_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  X_thigh.translation() = knee_mm + X_thigh.linear() * Eigen::Vector3d(0, 130, 0);
  X_shank.translation() = knee_mm + X_shank.linear() * Eigen::Vector3d(0, -130, 0);
  return {X_thigh, X_shank};
}

double flexion_rad(const Pose& X_thigh, const Pose& X_shank)
{
  const Eigen::Matrix3d R = X_thigh.linear().transpose() * X_shank.linear();
  return std::atan2(R(0, 1), R(1, 1));
}

struct Error {
  double flexion_rms_deg = 0.0, turn_rms_deg = 0.0;  ///< turn: whole rotation of the shank in the thigh
  double worst_place_share = 0.0;                    ///< of a body's position, of its distance
  int n_lost = 0;
};

/// A leg that bends by 90 degrees in `n` pictures.
Error bending_error(double distance_mm, double yaw_rad, int n)
{
  const bench::Camera camera = test::webcam_camera();
  bench::PoseFinder finder(camera, {});
  double flexion_sum = 0.0, turn_sum = 0.0;
  Error error;
  for (int k = 0; k < n; ++k) {
    test::RenderedPicture picture;
    picture.X_camera_body = leg(distance_mm, rad_from_deg(90.0 * k / (n - 1)), yaw_rad);
    picture.seed = static_cast<std::uint64_t>(k + 1);
    const std::vector<FoundBody> found = finder.find(test::rendered(camera, picture), k / 30.0);
    if (found[0].state != BodyState::seen || found[1].state != BodyState::seen) {
      ++error.n_lost;
      continue;
    }
    const Pose &X_thigh = found[0].X_camera_body, &X_shank = found[1].X_camera_body;
    for (std::size_t body = 0; body < 2; ++body) {
      const Eigen::Vector3d wanted_mm = picture.X_camera_body[body].translation();
      error.worst_place_share =
          std::max(error.worst_place_share,
                   (found[body].X_camera_body.translation() - wanted_mm).norm() / wanted_mm.z());
    }
    const double off = deg_from_rad(flexion_rad(X_thigh, X_shank) -
                                    flexion_rad(picture.X_camera_body[0], picture.X_camera_body[1]));
    flexion_sum += off * off;
    const Eigen::Matrix3d truth =
        picture.X_camera_body[0].linear().transpose() * picture.X_camera_body[1].linear();
    const double turn =
        deg_from_rad(Eigen::AngleAxisd(
                         Eigen::Matrix3d(truth.transpose() * X_thigh.linear().transpose() * X_shank.linear()))
                         .angle());
    turn_sum += turn * turn;
  }
  const int n_seen = n - error.n_lost;
  error.flexion_rms_deg = std::sqrt(flexion_sum / n_seen);
  error.turn_rms_deg = std::sqrt(turn_sum / n_seen);
  return error;
}

TEST(PoseFinder, FlexionIsWithinADegree)
{
  struct Row {
    double distance_mm, yaw_deg;
  };
  for (const Row row : {Row{600, 0}, Row{800, 0}, Row{800, 20}, Row{1000, 0}, Row{1000, -15}}) {
    SCOPED_TRACE(std::to_string(row.distance_mm) + " mm, " + std::to_string(row.yaw_deg) + " degrees");
    const Error error = bending_error(row.distance_mm, rad_from_deg(row.yaw_deg), 7);
    EXPECT_EQ(error.n_lost, 0);
    EXPECT_LE(error.flexion_rms_deg, 1.0);
    EXPECT_LE(error.turn_rms_deg, 3.0);
    // Corners 0.3 px inwards on both sides of a marker of 30 px are 2 % of the distance; sideways a fifth of
    // it, and 0.4 mm of the corners.
    EXPECT_LE(error.worst_place_share, 0.0205);
    std::printf("%.0f mm, %.0f deg: flexion %.2f, rotation %.2f deg RMS\n", row.distance_mm, row.yaw_deg,
                error.flexion_rms_deg, error.turn_rms_deg);
  }
}

TEST(PoseFinder, ACoveredBodyIsHiddenAndAHalfCoveredOneIsSeenOrMarked)
{
  const bench::Camera camera = test::webcam_camera();
  bench::PoseFinder finder(camera, {});
  test::RenderedPicture picture;
  picture.X_camera_body = leg(800.0, 0.0);
  // Projection of the shank's body.
  const Eigen::Vector3d p = picture.X_camera_body[1].translation();
  const int x = static_cast<int>(camera.centre_px.x() + camera.focal_px.x() * p.x() / p.z());
  const int y = static_cast<int>(camera.centre_px.y() + camera.focal_px.y() * p.y() / p.z());
  picture.occluders = {{x - 60, y - 60, 120, 120}};
  std::vector<FoundBody> found = finder.find(test::rendered(camera, picture), 0.0);
  EXPECT_EQ(found[0].state, BodyState::seen);
  EXPECT_EQ(found[1].state, BodyState::hidden);
  // The lower half covered: the markers of both faces above it are enough.
  picture.occluders = {{x - 60, y, 120, 60}};
  found = finder.find(test::rendered(camera, picture), 0.03);
  EXPECT_EQ(found[1].state, BodyState::seen);
  EXPECT_EQ(found[1].n_markers, 2);
  const Eigen::Matrix3d off = found[1].X_camera_body.linear().transpose() * picture.X_camera_body[1].linear();
  EXPECT_LT(deg_from_rad(Eigen::AngleAxisd(off).angle()), 4.0);
  // One marker: its tilt is not known.
  picture.occluders = {{x - 60, y, 120, 60}, {x, y - 60, 60, 120}};
  found = finder.find(test::rendered(camera, picture), 0.06);
  EXPECT_EQ(found[1].state, BodyState::ambiguous);
}

TEST(PoseFinder, AWrongFoldIsAMisfitAndAWrongSizeIsRefused)
{
  bench::Camera camera = test::webcam_camera();
  test::RenderedPicture picture;
  picture.X_camera_body = leg(700.0, 0.3);
  picture.fold_deg = 120.0;
  const bench::GreyPicture grey = test::rendered(camera, picture);
  bench::PoseFinder finder(camera, {});
  for (const FoundBody& body : finder.find(grey, 0.0))
    EXPECT_EQ(body.state, BodyState::misfit) << body.rms_px;
  camera.width = 1280;
  bench::PoseFinder large(camera, {});
  EXPECT_THAT(test::input_error([&] { large.find(grey, 0.0); }),
              test::refuses({"camera", "", "640 x 480", "1280 x 480"}));
}

}  // namespace vrda::pose_finder_test
