#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <sstream>

#include "bench/body_tracker.hpp"
#include "bench/protocols.hpp"
#include "player/bench/bench_samples.hpp"
#include "player/bench/bench_texts.hpp"
#include "support/refusal.hpp"
#include "support/scratch.hpp"

namespace vrda::body_tracker_test {

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

constexpr std::int64_t ms = 1'000'000;
constexpr double rounding_s = 1e-12;

TEST(ClockMap, TakesTheShortestWaySeenForTheWay)
{
  bench::ClockMap clock;
  const std::int64_t offset = 7'000'000 * ms;
  EXPECT_NEAR(clock.time_s(offset, 5 * ms), 0.005, rounding_s);
  EXPECT_NEAR(clock.time_s(offset + 10 * ms, 12 * ms), 0.012, rounding_s);
  // A delay of 6 ms instead of 2 ms; the offset is relaxed by 0.1 ms a second.
  EXPECT_NEAR(clock.time_s(offset + 20 * ms, 26 * ms), 0.022 + 14e-3 * 1e-4, rounding_s);
  EXPECT_NEAR(clock.time_s(offset + 30 * ms, 32 * ms), 0.032, rounding_s);
  EXPECT_EQ(clock.time_s(0, 1500 * ms), 1.5) << "no device clock: the arrival";
}

TEST(ClockMap, NeverGoesBackNorBeyondTheArrival)
{
  bench::ClockMap clock;
  std::mt19937_64 random(86);
  double before_s = 0.0;
  std::int64_t arrival = 0, device = 1000;
  int n_steps = 0;
  for (int k = 0; k < 2000; ++k) {
    arrival += 1 + static_cast<std::int64_t>(random() % (20 * ms));
    const bool is_step = random() % 50 == 0;
    n_steps += is_step ? 1 : 0;
    device =
        std::max<std::int64_t>(1, device + static_cast<std::int64_t>(random() % (20 * ms)) +
                                      (is_step ? static_cast<std::int64_t>(random() % 8000) - 4000 : 0) * ms);
    const double time_s = clock.time_s(device, arrival);
    EXPECT_GE(time_s, before_s);
    EXPECT_LE(time_s, static_cast<double>(arrival) * 1e-9);
    before_s = time_s;
  }
  EXPECT_GT(n_steps, 10);
}

TEST(ClockMap, AClockThatStepsIsSynchronisedAgain)
{
  bench::ClockMap clock;
  clock.time_s(5000 * ms, 10 * ms);
  EXPECT_NEAR(clock.time_s(100 * ms, 20 * ms), 0.020, rounding_s);
  EXPECT_NEAR(clock.time_s(110 * ms, 33 * ms), 0.030 + 13e-3 * 1e-4, rounding_s);
  EXPECT_NEAR(clock.time_s(9000 * ms, 40 * ms), 0.040, rounding_s);
  EXPECT_NEAR(clock.time_s(9010 * ms, 55 * ms), 0.050 + 15e-3 * 1e-4, rounding_s);
}

TEST(ClockMap, FollowsClocksThatDriftByFiftyMillionths)
{
  for (const int ppm : {-50, 50}) {
    bench::ClockMap clock;
    for (std::int64_t k = 1; k <= 60000; ++k) {
      const std::int64_t arrival = k * 10 * ms;
      const std::int64_t device = arrival + arrival / 1'000'000 * ppm;
      // All samples have the shortest delay.
      ASSERT_NEAR(clock.time_s(device, arrival), static_cast<double>(arrival) * 1e-9, 1e-9) << k;
    }
  }
}

TEST(TimeHistogram, PercentilesAreThoseOfTheSortedTimesToABin)
{
  std::mt19937_64 random(87);
  std::exponential_distribution<double> draw(1.0 / 20.0);
  std::vector<double> times;
  bench::TimeHistogram histogram;
  double sum = 0.0;
  for (int k = 0; k < 4999; ++k) {
    times.push_back(std::min(draw(random), 240.0));
    histogram.add(times.back());
    sum += times.back();
  }
  std::ranges::sort(times);
  const double n = static_cast<double>(times.size());
  for (const double share : {0.001, 0.25, 0.5, 0.95, 0.99, 1.0}) {
    const double at = times[static_cast<std::size_t>(std::ceil(share * n)) - 1];
    EXPECT_EQ(histogram.percentile_ms(share), (std::floor(at / 0.25) + 1.0) * 0.25) << share;
  }
  EXPECT_EQ(bench::TimeHistogram().percentile_ms(0.5), 0.0);
  EXPECT_EQ(histogram.n(), times.size());
  EXPECT_EQ(histogram.max_ms(), times.back());
  EXPECT_NEAR(histogram.mean_ms(), sum / n, 1e-9);
  double squares = 0.0;
  for (const double t : times) squares += (t - sum / n) * (t - sum / n);
  EXPECT_NEAR(histogram.spread_ms(), std::sqrt(squares / n), 1e-9);
  histogram.add(700.0);  // beyond the last bin
  EXPECT_EQ(histogram.percentile_ms(1.0), 700.0);
}

TEST(SampleWatch, CountsGapsAndLateArrivals)
{
  bench::StreamStatistics watch;
  for (std::int64_t k = 1; k <= 100; ++k) {
    const bool is_missed = k == 20 || k == 50 || k == 51;
    if (is_missed) continue;
    watch.add(k * 10 * ms, k * 10 * ms + (k == 70 ? 8 : 2) * ms);
  }
  EXPECT_EQ(watch.n(), 97u);
  EXPECT_EQ(watch.n_missed(), 3u);
  EXPECT_EQ(watch.n_late(), 1u);
  // One of 96 delays is 6 ms longer than the others, minus the relaxation of the shortest delay in 10 ms.
  EXPECT_NEAR(watch.jitter_ms(), 5.999 * std::sqrt(95.0) / 96.0, 1e-9);
}

/// 100 Hz for 5 s through the tracker's listener, one TDATA message at a time.
bench::StreamStatistics watched(std::int64_t set_back_ms, const std::function<bool(int)>& is_hidden)
{
  bench::TrackerSettings settings;
  settings.tools = {"tibia"};
  bench::TrackerProtocol protocol(settings, 0);
  bench::StreamStatistics watch;
  for (int k = 1; k <= 500; ++k) {
    bench::IgtlMessage message;
    message.kind = bench::IgtlKind::tdata;
    message.device = "Tracker";
    message.device_ns = (5000 + k * 10 - (k >= 100 ? set_back_ms : 0)) * ms;
    if (!is_hidden(k)) message.tools.push_back({"tibia", bench::ToolVisibility::seen, Pose::Identity()});
    for (const bench::Sample& sample : protocol.receive(message, k * 10 * ms)) watch.add(sample);
  }
  return watch;
}

TEST(SampleWatch, AClockThatIsSetBackByLessThanAnIntervalOrMoreMissesNothing)
{
  for (const std::int64_t set_back_ms : {4, 5, 8, 25, 33, 3000}) {
    const bench::StreamStatistics watch = watched(set_back_ms, [](int) { return false; });
    EXPECT_EQ(watch.n_missed(), 0U) << set_back_ms;
    EXPECT_EQ(watch.n_late(), 0U) << set_back_ms;
  }
}

TEST(SampleWatch, AStreamThatGrowsQuickerIsFollowed)
{
  bench::StreamStatistics watch;
  std::int64_t at = 0;
  const auto step = [&](std::int64_t step_ms) {
    at += step_ms * ms;
    watch.add(at, at);
  };
  for (int k = 0; k < 100; ++k) step(20);
  for (int k = 0; k < 100; ++k) step(10);
  EXPECT_EQ(watch.n_missed(), 0U);
  step(20);
  EXPECT_EQ(watch.n_missed(), 1U);
}

TEST(SampleWatch, AClockThatRunsSlowMakesNothingLate)
{
  bench::StreamStatistics watch;
  // Ten minutes with a drift of 50 ppm.
  for (std::int64_t k = 1; k <= 60'000; ++k) watch.add(k * (10 * ms - 500), k * 10 * ms);
  EXPECT_EQ(watch.n_late(), 0U);
  EXPECT_EQ(watch.n_missed(), 0U);
}

TEST(SampleWatch, AToolThatIsHiddenIsNotMissed)
{
  const bench::StreamStatistics watch = watched(0, [](int k) { return k >= 200 && k < 290; });
  EXPECT_EQ(watch.n(), 500U);
  EXPECT_EQ(watch.n_missed(), 0U);
}

}  // namespace vrda::body_tracker_test
