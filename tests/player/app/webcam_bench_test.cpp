// A bench with tracker = "aruco": the player starts vrda-webcam, which reads rendered pictures as its camera.
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/units.hpp"
#include "player/app/player_programs.hpp"
#include "player/bench/rendered_pictures.hpp"

namespace vrda::webcam_bench_test {

using nlohmann::json;
using testing::HasSubstr;

constexpr double flexion_deg = 40.0;

/// Both bodies 110 mm from a knee at 0.8 m.
std::vector<Pose> leg()
{
  Eigen::Matrix3d facing;
  facing << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  Pose X_thigh = Pose::Identity(), X_shank = Pose::Identity();
  X_thigh.linear() = facing;
  X_shank.linear() =
      facing * Eigen::AngleAxisd(-rad_from_deg(flexion_deg), Eigen::Vector3d::UnitZ()).toRotationMatrix();
  const Eigen::Vector3d knee_mm(0.0, 0.0, 800.0);
  X_thigh.translation() = knee_mm + X_thigh.linear() * Eigen::Vector3d(0, 110, 0);
  X_shank.translation() = knee_mm + X_shank.linear() * Eigen::Vector3d(0, -110, 0);
  return {X_thigh, X_shank};
}

class WebcamBench : public test::PlayerPrograms {
 protected:
  void SetUp() override { scratch_.write("camera.toml", bench::camera_text(test::webcam_camera())); }

  /// `n` pictures that differ by their noise; those from `n_seen` on show no shank.
  void take_pictures(int n, int n_seen)
  {
    for (int k = 0; k < n; ++k) {
      test::RenderedPicture picture;
      picture.X_camera_body = leg();
      picture.seed = static_cast<std::uint64_t>(k + 1);
      if (k >= n_seen) picture.occluders = {{0, 250, 640, 230}};
      const bench::GreyPicture grey = test::rendered(test::webcam_camera(), picture);
      std::ofstream file(scratch_.path() / ("picture_" + std::to_string(k) + ".pgm"), std::ios::binary);
      file << "P5\n" << grey.width << " " << grey.height << "\n255\n";
      file.write(reinterpret_cast<const char*>(grey.pixels.data()),
                 static_cast<std::streamsize>(grey.pixels.size()));
    }
  }

  std::string bench(const std::string& camera)
  {
    std::string text = test::bench_text({.keys = "tracker = \"aruco\"\n",
                                         .tracker = "",
                                         .tables = "[filter]\non = false\n[camera]\ndevice = \"" + camera});
    for (const auto& [body, sheet] :
         {std::pair("= \"femur\"", "= \"thigh\""), std::pair("= \"tibia\"", "= \"shank\"")})
      text.replace(text.find(body), std::string(body).size(), sheet);
    return scratch_.write("bench.toml", text).string();
  }

  std::string pictures() const { return path("picture_%d.pgm"); }
  /// Runs the bench without a window; returns its frames.
  std::vector<bench::BenchFrame> frames_of(const std::string& bench_file, const std::string& name,
                                           double seconds)
  {
    const std::string log = path(name + ".log");
    timing_ = path(name + ".json");
    const test::Ended ended = run({"bench", model_, "--bench", bench_file, "--headless", "--seconds",
                                   std::to_string(seconds), "--record", log, "--timing", timing_});
    EXPECT_EQ(ended.exit_code, 0) << ended.err;
    return test::frames_of(log, model_);
  }

  /// What `devices` says of a tracker that does not answer; repeated while the program starts.
  std::string error_message_of(const std::string& bench_file) const
  {
    for (int seconds = 1; seconds < 20; seconds *= 2) {
      const json tracker = json::parse(
          run({"devices", bench_file, "--json", "--seconds", std::to_string(seconds)}).out)["tracker"];
      EXPECT_EQ(tracker["answers"], false);
      if (tracker["trouble"] != "") return tracker["trouble"];
    }
    return "";
  }

  std::string timing_;
};

TEST_F(WebcamBench, FlexionIsShownOcclusionMarkedAndLatencyWritten)
{
  take_pictures(12, 8);
  const std::vector<bench::BenchFrame> frames =
      frames_of(bench(pictures() + "\"\nrate_hz = 10\n"), "run", 5.0);
  int n_live = 0, n_hidden = 0;
  double sum_sq = 0.0;
  for (const bench::BenchFrame& frame : frames) {
    if (bench::is_live(frame)) {
      ++n_live;
      const double off = deg_from_rad(frame.pose.attitude.flexion_rad) - flexion_deg;
      sum_sq += off * off;
    } else if (bench::input_status_text("tibia", frame.bodies[2]).starts_with("tibia hidden for")) {
      ++n_hidden;
      EXPECT_TRUE(frame.bodies[1].is_live) << "the femur's body is not covered";
    }
  }
  ASSERT_GT(n_live, 20);
  EXPECT_GT(n_hidden, 10);
  EXPECT_LE(std::sqrt(sum_sq / n_live), 1.0);
  const json timing = json::parse(test::read_bytes(timing_));
  EXPECT_GT(timing["camera_latency_ms"]["n"], 10);
  EXPECT_GT(timing["camera_latency_ms"]["median"], 0.0);
  std::printf("flexion %.2f deg RMS, camera to picture %.1f ms median\n", std::sqrt(sum_sq / n_live),
              timing["camera_latency_ms"]["median"].get<double>());
}

TEST_F(WebcamBench, AnAbsentAFrozenASlowAndALyingCameraAreMarkedWhileThePictureGoesOn)
{
  const auto marks = [](const std::vector<bench::BenchFrame>& frames) {
    return bench::input_status_text("femur", frames.back().bodies[1]);
  };
  // Absent: the device's report says why.
  const std::string absent = bench("/dev/video_none\"\n");
  std::vector<bench::BenchFrame> frames = frames_of(absent, "absent", 1.0);
  EXPECT_GT(frames.size(), 10U);
  EXPECT_EQ(marks(frames), "femur not seen yet");
  EXPECT_THAT(error_message_of(absent), HasSubstr("/dev/video_none: found no camera"));

  // Frozen: the same picture again and again.
  take_pictures(1, 1);
  frames = frames_of(bench(pictures() + "\"\n"), "frozen", 4.0);
  EXPECT_THAT(marks(frames), testing::StartsWith("femur silent for"));
  EXPECT_TRUE(frames.back().bodies[1].was_seen);

  // Slow: two pictures a second are live for a part of the time only.
  take_pictures(3, 3);
  frames = frames_of(bench(pictures() + "\"\nrate_hz = 2\n"), "slow", 4.0);
  const auto n_live =
      std::ranges::count_if(frames, [](const bench::BenchFrame& frame) { return bench::is_live(frame); });
  EXPECT_GT(n_live, 0);
  EXPECT_GT(std::ssize(frames) - n_live, std::ssize(frames) / 4);

  // Lying: sheets that are not folded as stated.
  frames = frames_of(bench(pictures() + "\"\nfold_deg = 130\n"), "lying", 3.0);
  EXPECT_EQ(marks(frames), "femur not seen yet");
  EXPECT_EQ(frames.back().bodies[1].state, bench::ToolVisibility::invalid_pose);

  // A calibration of another picture size, and none.
  bench::Camera other = test::webcam_camera();
  other.width = 1280;
  scratch_.write("camera.toml", bench::camera_text(other));
  EXPECT_THAT(error_message_of(bench(pictures() + "\"\n")), HasSubstr("wanted 1280 x 480"));
  std::filesystem::remove(scratch_.path() / "camera.toml");
  EXPECT_THAT(error_message_of(bench(pictures() + "\"\n")), HasSubstr("vrda-webcam calibrate"));
}

TEST_F(WebcamBench, SheetsArePrintedForTheBenchsBodies)
{
  const std::string file = path("sheets.pdf");
  const test::Ended ended =
      test::run({VRDA_WEBCAM_PROGRAM, {"sheet", bench("0\"\n"), "-o", file}, {}, scratch_.path()});
  ASSERT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_THAT(test::read_bytes(file), HasSubstr("(shank: markers 4 to 7"));
}

}  // namespace vrda::webcam_bench_test
