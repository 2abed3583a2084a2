// Bench files with a webcam, and the examples in jobs/.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/units.hpp"
#include "player/bench/bench_texts.hpp"
#include "support/refusal.hpp"
#include "support/scratch.hpp"

namespace vrda::webcam_file_test {

using testing::ElementsAre, testing::HasSubstr;

std::string webcam_text(const std::string& camera = "")
{
  return test::bench_head() + "tracker = \"aruco\"\n" + test::display_table + test::two_bodies + camera;
}

TEST(WebcamFile, AWebcamIsReadByAProgramOfItsOwn)
{
  const bench::BenchFile bench = test::bench_of(webcam_text());
  ASSERT_TRUE(bench.camera);
  EXPECT_EQ(bench.camera->device, "/dev/video0");
  EXPECT_EQ(bench.camera->marker_mm, 40.0);
  EXPECT_THAT(bench.tracker->program, ElementsAre("vrda-webcam", "track", bench.path));
  EXPECT_THAT(bench.tracker->tools, ElementsAre("femur", "tibia"));
  EXPECT_EQ(bench.tracker->stale_after_ms, 200.0);
  const bench::BenchFile other =
      test::bench_of(webcam_text("[camera]\ndevice = \"a.mp4\"\nfold_deg = 100\nstale_after_ms = 500\n"));
  EXPECT_EQ(other.camera->device, "a.mp4");
  EXPECT_EQ(other.camera->fold_rad, rad_from_deg(100.0));
  EXPECT_EQ(other.tracker->stale_after_ms, 500.0);
  EXPECT_FALSE(test::bench_of(test::bench_text()).camera);
}

TEST(WebcamFile, WhatItCannotTrackIsRefused)
{
  const auto refusal = [](const std::string& text) {
    return test::input_error([&] { test::bench_of(text); });
  };
  const std::string head = test::bench_head() + "tracker = ", rest = test::display_table + test::two_bodies;
  EXPECT_THAT(refusal(head + "\"vicon\"\n" + rest),
              test::refuses({.field = "tracker", .found = "vicon", .wanted = "aruco"}));
  EXPECT_THAT(refusal(webcam_text("[camera]\nfold_deg = 180\n")),
              test::refuses({.field = "camera.fold_deg", .found = "180", .wanted = {"60", "150"}}));
  const std::string markers =
      "[body.femur]\nmarkers = [\"a\", \"b\", \"c\"]\nmarkers_mm = [0, 0, 0, 1, 0, 0, 0, 1, 0]\n"
      "[body.tibia]\ntool = \"tibia\"\n";
  EXPECT_THAT(refusal(test::bench_head() + "tracker = \"aruco\"\n" + test::display_table + markers),
              test::refuses({.field = "body.femur.markers", .wanted = "tool"}));
}

TEST(WebcamFile, TheExamplesNameTheToolsOfTheBench)
{
  EXPECT_TRUE(bench::read_bench_file(VRDA_JOBS "/bench-webcam.toml").camera);
  const bench::BenchFile plus = bench::read_bench_file(VRDA_JOBS "/plus/bench.toml");
  EXPECT_EQ(plus.tracker->tools,
            (std::vector<std::string>{"FemurToTracker", "TibiaToTracker", "ProbeToTracker"}));
  for (const char* tracker : {"polaris", "optitrack", "vicon", "aruco"}) {
    SCOPED_TRACE(tracker);
    const std::string text = test::read_bytes(VRDA_JOBS "/plus/" + std::string(tracker) + ".xml");
    for (const std::string tool : {"Femur", "Tibia", "Probe"}) {
      EXPECT_THAT(text, HasSubstr("<Transform Name=\"" + tool + "ToTracker\" />"));
      EXPECT_THAT(text, HasSubstr("<DataSource Type=\"Tool\" Id=\"" + tool + "\""));
    }
    EXPECT_THAT(text, HasSubstr("ListeningPort=\"18944\""));
    EXPECT_THAT(text, HasSubstr("SendValidTransformsOnly=\"TRUE\""));
  }
}

}  // namespace vrda::webcam_file_test
