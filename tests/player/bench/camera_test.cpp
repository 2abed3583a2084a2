// The camera's file, and its calibration from rendered pictures of the board.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/aruco/charuco.hpp>

#include "bench/body_sheet.hpp"
#include "bench/webcam.hpp"
#include "core/units.hpp"
#include "player/bench/rendered_pictures.hpp"
#include "support/refusal.hpp"
#include "support/scratch.hpp"

namespace vrda::camera_test {

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

}  // namespace vrda::camera_test
