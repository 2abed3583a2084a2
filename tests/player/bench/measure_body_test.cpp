#include "bench/body_tracker.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "bench_samples.hpp"
#include "core/units.hpp"
#include "player/bench/bench_samples.hpp"
#include "player/bench/bench_texts.hpp"
#include "support/refusal.hpp"
#include "support/scratch.hpp"

namespace vrda::measure_body_test {

using testing::HasSubstr;

std::string text_with(const std::string& femur)
{
  return test::bench_head() + test::display_table + "[tracker]\nport = 1\n" + femur +
         "[body.tibia]\ntool = \"tibia\"\n";
}

const std::string four_markers = "[body.femur]\nmarkers = [\"a\", \"b\", \"c\", \"d\"]\n";

bench::BenchFile unmeasured(const std::string& places = "")
{
  return bench::parse_bench_file(text_with(four_markers + places), "bench.toml",
                                 bench::MarkerPositions::optional);
}

using Places = std::vector<Eigen::Vector3d>;
const Places tetrahedron{{10, 20, 30}, {90, 20, 30}, {10, 80, 30}, {10, 20, 80}};

std::vector<bench::MarkerRow> frames_of(const Places& places)
{
  std::vector<bench::MarkerRow> frames;
  for (int k = 0; k < 40; ++k) {
    bench::MarkerRow row;
    for (const Eigen::Vector3d& p : places) row.emplace_back(test::some_pose(k % 9) * p);
    if (k % 5 == 0) row[static_cast<std::size_t>(k / 5 % 4)].reset();
    frames.push_back(row);
  }
  return frames;
}

TEST(MeasureBody, KeepsTheFrameOfMarkerPositionsInTheBenchFile)
{
  const bench::BenchFile bench =
      unmeasured("markers_mm = [10, 20, 30, 90, 20, 30, 10, 80, 30, 10, 20, 80]\n");
  const bench::BuiltBody built =
      bench::build_measured_body(frames_of(tetrahedron), bench, bench::BodyRole::femur);
  for (std::size_t k = 0; k < 4; ++k)
    EXPECT_LT((built.body.markers_mm.row(static_cast<Eigen::Index>(k)).transpose() - tetrahedron[k]).norm(),
              1e-6);
  // Its lines are those of a bench file.
  const std::string lines = bench::bench_file_lines(built, bench, bench::BodyRole::femur);
  EXPECT_THAT(lines, HasSubstr("# in the frame of the bench file's markers_mm, difference 0 mm"));
  EXPECT_EQ(test::bench_of(text_with(lines)).bodies[1]->markers_body_mm, tetrahedron);
}

TEST(MeasureBody, MarkersThatMakeNoBodyAreRefusedByName)
{
  const auto refusal = [](const std::vector<bench::MarkerRow>& frames) {
    const InputError::Facts facts =
        test::input_error([&] { bench::build_measured_body(frames, unmeasured(), bench::BodyRole::femur); });
    EXPECT_THAT(facts, test::refuses({"bench.toml", "body.femur.markers"}));
    return facts.found;
  };
  EXPECT_THAT(refusal(frames_of({{0, 0, 0}, {10, 0, 0}, {20, 0, 0}, {30, 0, 0}})), HasSubstr("collinear"));
  EXPECT_THAT(refusal(frames_of({{0, 0, 0}, {0, 0, 1}, {50, 0, 0}, {0, 50, 0}})),
              HasSubstr("'a' and 'b' 1 mm apart"));
  std::vector<bench::MarkerRow> unseen = frames_of(tetrahedron), never_together = unseen;
  for (bench::MarkerRow& row : unseen) row[2].reset();
  EXPECT_EQ(refusal(unseen), "'c' in none of 40 frames");
  for (std::size_t k = 0; k < never_together.size(); ++k) {
    if (k < 3) {
      never_together[k][0].reset();
    } else {
      never_together[k][3].reset();
    }
    if (k < 3) never_together[k][1].reset();
  }
  EXPECT_THAT(refusal(never_together), HasSubstr("'d' seen in 3 frames"));
}

TEST(MeasureBody, BodiesThatCannotBeMeasuredAreRefusedWithTheReason)
{
  const test::Scratch scratch;
  bench::MeasureBodyOptions options;
  options.bench = scratch.write("bench.toml", text_with(four_markers)).string();
  options.seconds = 0.1;
  const auto refusal = [&](const char* role) {
    options.role = role;
    std::ostringstream data, messages;
    const InputError::Facts facts = test::input_error([&] {
      bench::measure_body(options, {data, messages});
    });
    EXPECT_EQ(facts.file, options.bench);
    EXPECT_EQ(data.str(), "");
    return facts;
  };
  EXPECT_THAT(refusal("tibia"), test::refuses({.field = "body", .found = "'tibia'"}));
  EXPECT_EQ(refusal("tibia").wanted, "femur");
  EXPECT_THAT(refusal("femur"),
              test::refuses({.field = "body.femur.markers", .found = {"0.1", "127.0.0.1:1"}}));
  options.bench = scratch.write("tools.toml", test::bench_text()).string();
  EXPECT_THAT(refusal("femur"), test::refuses({.field = "body", .found = "markers"}));
}

// Bodies of markers: received frames and conditioning of the pose.

using test::ms_in_ns;

bench::Sample marker_sample(std::uint16_t tool, const Eigen::Vector3d& p_mm, std::int64_t arrival_ns)
{
  Pose marker = Pose::Identity();
  marker.translation() = p_mm;
  return test::place_sample(tool, marker, arrival_ns, arrival_ns);
}

TEST(MarkerFrames, AreTheMessagesAMarkerWasSeenIn)
{
  bench::MarkerFrames heard(2, 3);
  for (int k = 1; k <= 10; ++k) {
    const std::int64_t now_ns = k * 10 * ms_in_ns;
    heard.take(marker_sample(1, {9.0, 9.0, 9.0}, now_ns));  // marker of another body
    heard.take(marker_sample(2, {1.0 * k, 0.0, 0.0}, now_ns));
    heard.take(k == 4 ? test::hidden_sample(3, now_ns) : marker_sample(3, {0.0, 1.0 * k, 0.0}, now_ns));
    heard.take(test::hidden_sample(4, now_ns));
    heard.take(test::potentiometer_sample(k, now_ns));
  }
  const std::vector<bench::MarkerRow> frames = heard.frames(100);
  ASSERT_EQ(frames.size(), 10U);
  for (std::size_t k = 0; k < frames.size(); ++k) {
    ASSERT_EQ(frames[k].size(), 3U);
    EXPECT_EQ(frames[k][0], Eigen::Vector3d(static_cast<double>(k) + 1.0, 0.0, 0.0));
    EXPECT_EQ(frames[k][1].has_value(), k != 3);
    EXPECT_FALSE(frames[k][2].has_value());
  }
  const std::vector<bench::MarkerRow> some = heard.frames(5);
  ASSERT_EQ(some.size(), 5U);
  EXPECT_EQ(some[4][0], Eigen::Vector3d(9.0, 0.0, 0.0));
}

/// Markers at the corners of a square with sides of 2 `half_mm` about the origin.
bench::PoseFit square_fit(double half_mm, double residual_mm)
{
  bench::RigidBody body;
  body.markers_mm.resize(4, 3);
  body.markers_mm << half_mm, half_mm, 0, -half_mm, half_mm, 0, -half_mm, -half_mm, 0, half_mm, -half_mm, 0;
  bench::MarkerRow seen;
  for (Eigen::Index k = 0; k < 4; ++k) seen.emplace_back(body.markers_mm.row(k).transpose());
  bench::PoseFit fit = bench::fit_pose(body, seen);
  fit.residual_rms_mm = residual_mm;
  return fit;
}

TEST(FitWords, QualityIsWhatTheResidualsNoiseMakesOfThePose)
{
  // A residual of 0.3 mm at four markers with 12 - 6 degrees of freedom: noise 0.3 sqrt(4 / 6) a coordinate.
  // The rotation about an axis in the square's plane is determined by the spread along the other one, 2 half.
  const bench::FitQuality quality = bench::quality_of(square_fit(50.0, 0.3));
  const double noise = 0.3 * std::sqrt(4.0 / 6.0);
  EXPECT_EQ(quality.n_markers, 4);
  EXPECT_EQ(quality.residual_mm, 0.3);
  EXPECT_NEAR(quality.rotation_sd_rad, noise / 100.0, 1e-11);
  EXPECT_NEAR(quality.centroid_sd_mm, noise * std::sqrt(3.0 / 4.0), 1e-9);
}

}  // namespace vrda::measure_body_test
