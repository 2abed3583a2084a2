// Poses of the printed bodies in rendered pictures of known truth: 640 x 480, blur, noise.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/aruco/charuco.hpp>

#include <cmath>
#include <numbers>

#include "core/units.hpp"
#include "player/bench/rendered_pictures.hpp"
#include "support/refusal.hpp"
#include "support/scratch.hpp"

namespace vrda::webcam_test {

using bench::BodyState, bench::FoundBody;

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

// The camera's file, and its calibration from rendered pictures of the board.

TEST(CameraFile, ReadsBackWhatItWrites)
{
  const test::Scratch scratch;
  bench::Camera camera = test::webcam_camera();
  camera.rms_px = 0.21;
  camera.n_views = 20;
  const std::string file = scratch.write("camera.toml", bench::camera_text(camera)).string();
  const bench::Camera read = bench::read_camera(file);
  EXPECT_EQ(read.focal_px, camera.focal_px);
  EXPECT_EQ(read.centre_px, camera.centre_px);
  EXPECT_EQ(read.distortion, camera.distortion);
  EXPECT_EQ(bench::camera_text(read), bench::camera_text(camera));
  const std::string wrong = scratch
                                .write("wrong.toml",
                                       "width = 640\nheight = 480\nfocal_px = [600]\ncentre_px = [1, "
                                       "2]\ndistortion = [0, 0, 0, 0, 0]\n")
                                .string();
  EXPECT_THAT(test::input_error([&] { bench::read_camera(wrong); }),
              test::refuses({wrong, "focal_px", "600", "two"}));
  EXPECT_THAT(test::input_error([] { bench::read_camera("none.toml"); }),
              test::refuses({"none.toml", "", "", "vrda-webcam calibrate"}));
}

/// The board as printed: a millimetre a pixel.
test::PlanePattern board_pattern()
{
  const auto board = cv::aruco::CharucoBoard::create(
      7, 5, 38.0F, 28.0F, cv::aruco::getPredefinedDictionary(cv::aruco::DICT_5X5_50));
  cv::Mat picture;
  board->draw(cv::Size(266, 190), picture, 0, 1);
  return [picture](double x_mm, double y_mm) {
    const int column = static_cast<int>(std::floor(x_mm)), row = static_cast<int>(std::floor(y_mm));
    if (column < -10 || row < -10 || column >= 276 || row >= 200) return 120.0;
    if (column < 0 || row < 0 || column >= 266 || row >= 190) return 215.0;
    return picture.at<std::uint8_t>(row, column) == 0 ? 35.0 : 215.0;
  };
}

TEST(CameraFit, FindsTheCameraFromTheBoard)
{
  const bench::Camera truth = test::webcam_camera();
  const test::PlanePattern pattern = board_pattern();
  bench::CameraFit fit({10});
  std::string said;
  for (int k = 0; !fit.is_complete() && k < 14; ++k) {
    const double about_x = rad_from_deg(35.0 * std::cos(1.9 * k)),
                 about_y = rad_from_deg(35.0 * std::sin(1.9 * k));
    Pose X = Pose::Identity();
    X.linear() = (Eigen::AngleAxisd(about_x, Eigen::Vector3d::UnitX()) *
                  Eigen::AngleAxisd(about_y, Eigen::Vector3d::UnitY()))
                     .toRotationMatrix();
    X.translation() = Eigen::Vector3d(30.0 * std::sin(k), 20.0 * std::cos(2.0 * k), 330.0 + 15.0 * (k % 4)) -
                      X.linear() * Eigen::Vector3d(133, 95, 0);
    test::RenderedPicture appearance;
    appearance.seed = static_cast<std::uint64_t>(k + 1);
    const bench::GreyPicture picture = test::rendered_plane(truth, X, pattern, appearance);
    said = fit.take(picture);
    if (k == 0) {
      EXPECT_THAT(fit.take(picture), testing::HasSubstr("as before"));
    }
  }
  ASSERT_TRUE(fit.is_complete()) << said;
  const bench::Camera camera = fit.camera("camera.toml");
  std::printf("focal %.1f %.1f px, centre %.1f %.1f, rms %.2f px\n", camera.focal_px.x(), camera.focal_px.y(),
              camera.centre_px.x(), camera.centre_px.y(), camera.rms_px);
  EXPECT_NEAR(camera.focal_px.x() / truth.focal_px.x(), 1.0, 0.01);
  EXPECT_NEAR(camera.focal_px.y() / truth.focal_px.y(), 1.0, 0.01);
  EXPECT_LT((camera.centre_px - truth.centre_px).norm(), 6.0);
  EXPECT_LT(camera.rms_px, 0.5);
  EXPECT_EQ(camera.n_views, 10);
}

TEST(CameraFit, TooFewViewsAreRefused)
{
  EXPECT_THAT(test::input_error([] { bench::CameraFit().camera("camera.toml"); }),
              test::refuses({"camera.toml", "", "0 views", "5"}));
  bench::CameraFit fit;
  EXPECT_EQ(fit.take({64, 48, std::vector<std::uint8_t>(64 * 48, 100)}), "no board");
}

using testing::HasSubstr;

TEST(BodySheet, MarkersAreSquaresBesideTheEdge)
{
  const auto markers = bench::marker_corners_mm({});
  for (const bench::MarkerCorners& marker : markers) {
    for (std::size_t k = 0; k < 4; ++k) EXPECT_NEAR((marker[(k + 1) % 4] - marker[k]).norm(), 40.0, 1e-12);
    EXPECT_NEAR((marker[2] - marker[0]).norm(), 40.0 * std::sqrt(2.0), 1e-12);
    // Seen from outside, clockwise from the upper left.
    const Eigen::Vector3d outward = (marker[0] - marker[1]).cross(marker[2] - marker[1]);
    EXPECT_GT(outward.z(), 0.0);
    EXPECT_GT(marker[0].y(), marker[3].y());
  }
  // A right angle at the edge: the inner sides are 8 mm from it on either face.
  EXPECT_NEAR((markers[1][0] - markers[0][1]).norm(), 8.0 * std::sqrt(2.0), 1e-12);
  EXPECT_NEAR(markers[1][0].x(), 8.0 * std::sqrt(0.5), 1e-12);
  EXPECT_NEAR(markers[1][0].y(), 44.0, 1e-12);
  EXPECT_NEAR(markers[2][3].y(), -44.0, 1e-12);
  // A print of another size.
  EXPECT_NEAR((bench::marker_corners_mm({20.0})[3][2] - 0.5 * markers[3][2]).norm(), 0.0, 1e-12);
}

TEST(BodySheet, ThePrintHasItsSizesInMillimetres)
{
  const std::string pdf = bench::sheets_pdf({"femur", "tibia", "probe"});
  EXPECT_THAT(pdf, testing::StartsWith("%PDF-1.4\n"));
  EXPECT_THAT(pdf, HasSubstr("/Count 3 "));
  EXPECT_THAT(pdf, HasSubstr("/PrintScaling /None"));
  // A millimetre is 72 / 25.4 points; a marker is 40 of them.
  EXPECT_THAT(pdf, HasSubstr("2.8346 0 0 2.8346 0 0 cm\n"));
  EXPECT_THAT(pdf, HasSubstr("q 40.0000 0.0000 0.0000 40.0000 113.0000 "));
  EXPECT_THAT(pdf, HasSubstr("(femur: markers 0 to 3, 40 mm each; this side up \\(proximal\\)) Tj"));
  EXPECT_THAT(pdf, HasSubstr("(probe: markers 8 to 11,"));
  // The board: 7 x 5 squares of 38 mm, its long side along the page.
  EXPECT_THAT(pdf, HasSubstr("q 190.0000 0.0000 0.0000 266.0000 10.0000 22.0000 cm"));
  EXPECT_THAT(pdf, HasSubstr("100 mm: print without scaling"));
  // The table at the end points at each object.
  const std::size_t table = pdf.find("xref\n");
  ASSERT_NE(table, std::string::npos);
  EXPECT_THAT(pdf, HasSubstr("startxref\n" + std::to_string(table) + "\n%%EOF\n"));
  EXPECT_EQ(pdf.substr(std::stoul(pdf.substr(pdf.find("65535 f \n", table) + 9, 10)), 8), "1 0 obj\n");
}

}  // namespace vrda::webcam_test
