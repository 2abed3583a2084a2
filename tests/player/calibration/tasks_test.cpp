#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>

#include "calibration/task.hpp"
#include "player/bench/bench_texts.hpp"
#include "player/calibration/trial.hpp"
#include "support/refusal.hpp"

namespace vrda::calibration::tasks_test {

std::vector<BenchFile> benches()
{
  const std::string head = "[calibration]\n";
  return {test::virtual_bench(HeadKind::stage), test::virtual_bench(HeadKind::tracker),
          test::virtual_bench(HeadKind::stage, head,
                              head + "distortion = \"adjust\"\nmodel = \"adjust\"\npupillometer = false\n"
                                     "bullseyes = 27\ngrid = [4, 6]\n")};
}

std::size_t lines_in(const std::string& text)
{
  return 1 + static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

TEST(CalibrationTasks, AreNamedOnceAndSayWhatIsWanted)
{
  std::set<const TaskKind*> kinds;
  for (const BenchFile& bench : benches()) {
    const Calibration nominal = bench::nominal_calibration(bench);
    for (const CalibrationPart part : parts_of(bench)) {
      SCOPED_TRACE(bench::name_of(part));
      const std::vector<Task> tasks = tasks_of(part, bench, nominal);
      ASSERT_FALSE(tasks.empty());
      std::set<std::string> names;
      for (const Task& task : tasks) {
        SCOPED_TRACE(task.name);
        kinds.insert(task.kind);
        EXPECT_TRUE(names.insert(task.name).second);
        EXPECT_FALSE(task.instruction.empty());
        EXPECT_LE(lines_in(task.instruction), 3u);
        for (const Dial& dial : task.dials) {
          EXPECT_LE(dial.minimum, dial.value);
          EXPECT_LE(dial.value, dial.maximum);
          EXPECT_GT(dial.step, 0.0);
        }
        EXPECT_EQ(task.n_samples > 0, !task.tool.empty());
      }
    }
  }
  EXPECT_EQ(kinds.size(), 14u);
}

TEST(CalibrationParts, AreOnceABenchOrOnceAPerson)
{
  for (const BenchFile& file : benches()) {
    std::vector<CalibrationPart> both = parts_of_step("bench", file);
    EXPECT_EQ(both.back() < CalibrationPart::eyepoints, true);
    const std::vector<CalibrationPart> person = parts_of_step("person", file);
    EXPECT_EQ(person.front(), CalibrationPart::eyepoints);
    both.insert(both.end(), person.begin(), person.end());
    EXPECT_EQ(both, parts_of_step("all", file));
  }
}

TEST(CalibrationTasks, MarkersSpreadInEveryDirectionWithinTheFirstSix)
{
  std::set<std::array<int, 3>> all;
  for (int k = 0; k < 27; ++k) {
    const Eigen::Vector3i place = requested_marker_position(k);
    all.insert({place.x(), place.y(), place.z()});
  }
  EXPECT_EQ(all.size(), 27u);
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (int k = 0; k < 6; ++k) {
    const Eigen::Vector3d place = requested_marker_position(k).cast<double>();
    spread += place * place.transpose();
  }
  // Six positions with five corners have a nearly isotropic scatter.
  EXPECT_GT(Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread).eigenvalues()[0], 2.0);
}

using Parts = std::vector<CalibrationPart>;

TEST(CalibrationParts, AreThoseThatMakeSenseOnTheBench)
{
  using enum CalibrationPart;
  const std::vector<BenchFile> files = benches();
  EXPECT_EQ(parts_of(files[0]),
            (Parts{viewport, distortion, rails, stop, probe, eyepoints, ipd, subject, bullseye, leg}));
  EXPECT_EQ(parts_of(files[1]), (Parts{viewport, distortion, probe, eyepoints, ipd, subject, head, leg}));
  EXPECT_EQ(parts_of(files[2]),
            (Parts{viewport, distortion, rails, stop, eyepoints, ipd, subject, bullseye, leg}));
  EXPECT_EQ(parts_of_step("tracking", files[0]), (Parts{rails, stop, probe, bullseye, leg}));
  EXPECT_EQ(parts_of_step("tracking", files[1]), (Parts{probe, leg}));
  EXPECT_EQ(parts_of_step("head", files[1]), Parts{head});
  EXPECT_EQ(parts_of_step("all", files[0]), parts_of(files[0]));
  BenchFile two = files[0];
  two.leg = LegKind::two_bodies;
  two.board.reset();
  EXPECT_EQ(parts_of_step("tracking", two), (Parts{rails, probe, bullseye, femur, tibia}));
  EXPECT_EQ(dependencies_of(bullseye, two), (Parts{rails, eyepoints, ipd}));
  EXPECT_EQ(dependencies_of(leg, files[2]), (Parts{subject, bullseye}));
  EXPECT_EQ(dependencies_of(leg, files[0]), (Parts{probe, subject}));
}

TEST(CalibrationParts, AnUnknownStepIsRefusedByName)
{
  const std::vector<BenchFile> files = benches();
  const auto refused = [](const std::string& step, const BenchFile& bench) {
    return test::input_error([&] { parts_of_step(step, bench); });
  };
  EXPECT_EQ(refused("viewprot", files[0]).found, "'viewprot'");
  EXPECT_THAT(refused("viewprot", files[0]),
              test::refuses({.field = "STEP", .found = "'viewprot'", .wanted = "bullseye"}));
  EXPECT_EQ(refused("head", files[0]).field, "STEP");
  EXPECT_EQ(refused("rails", files[1]).field, "STEP");
  BenchFile without = files[0];
  without.calibration.landmarks.clear();
  EXPECT_EQ(refused("subject", without).field, "calibration.landmarks");
}

/// Rounding to 10 nm.
constexpr double kept_mm = 1e-5;

/// Leg with three markers, then probe and marker: tools 0 to 4.
BenchFile marked_bench()
{
  return test::bench_of(test::bench_head("rigid") + test::display_table + test::tracker_table +
                        "[body.leg]\nmarkers = [\"a\", \"b\", \"c\"]\n"
                        "markers_mm = [0, 0, 0, 100, 0, 0, 0, 100, 0]\n" +
                        test::board_table + "[calibration]\n");
}

bench::Sample seen(std::uint16_t tool, const Eigen::Vector3d& p, std::int64_t at_ms)
{
  bench::Sample sample;
  sample.kind = bench::SampleKind::tool_pose;
  sample.state = static_cast<std::uint8_t>(bench::ToolVisibility::seen);
  sample.source = tool;
  sample.arrival_ns = sample.device_ns = 1'000'000'000 + at_ms * 1'000'000;
  for (int k = 0; k < 3; ++k) sample.tool_pose.position_mm[k] = p[k];
  return sample;
}

using Samples = TaskKind::Samples;
const test::PlainKind sweep({.name = "sweep", .samples = Samples::sweep}),
    hold({.name = "hold", .samples = Samples::hold}), position({.name = "at", .samples = Samples::position}),
    leg({.name = "leg", .samples = Samples::leg});

Task task_with(const TaskKind& kind, const std::string& tool, const std::optional<BodyRole>& body = {})
{
  Task task;
  task.kind = &kind;
  task.tool = tool;
  task.body = body;
  task.n_samples = 10;
  return task;
}

constexpr std::uint16_t probe = 3, marker = 4;

void send_leg(SampleCollector& taker, const Eigen::Vector3d& at, std::int64_t at_ms)
{
  const std::array<Eigen::Vector3d, 3> markers{Eigen::Vector3d(0, 0, 0), {100, 0, 0}, {0, 100, 0}};
  for (std::uint16_t k = 0; k < 3; ++k) taker.take(seen(k, at + markers[k], at_ms));
}

TEST(SampleTaker, CollectsRowsOfItsToolOnlyDuringItsTask)
{
  SampleCollector taker(marked_bench());
  EXPECT_FALSE(taker.take(seen(marker, {1, 2, 3}, 0)));
  taker.begin(task_with(sweep, "marker"));
  EXPECT_FALSE(taker.take(seen(probe, {1, 2, 3}, 10)));
  EXPECT_TRUE(taker.take(seen(marker, {1.0000049, 2.25, -3}, 20)));
  bench::Sample hidden = seen(marker, {1, 2, 3}, 30);
  hidden.state = static_cast<std::uint8_t>(bench::ToolVisibility::missing);
  EXPECT_FALSE(taker.take(hidden));
  EXPECT_FALSE(taker.take(seen(marker, {1, std::nan(""), 3}, 35)));
  taker.end();
  EXPECT_FALSE(taker.take(seen(marker, {1, 2, 3}, 40)));
  EXPECT_EQ(taker.rows(), (std::vector<std::vector<double>>{{1.0, 2.25, -3.0, 1.0, 0.0, 0.0, 0.0}}));
}

TEST(SampleTaker, ASweepHasTheStagePositionIfTheBoardSendsIt)
{
  SampleCollector taker(marked_bench());
  EXPECT_FALSE(taker.stage_mm().has_value());
  bench::Sample stage;
  stage.kind = bench::SampleKind::stage;
  stage.count = 2469;
  taker.begin(task_with(sweep, "marker"));
  taker.take(seen(marker, {0, 0, 0}, 0));
  taker.take(stage);
  taker.take(seen(marker, {0, 0, 0}, 10));
  bench::Sample gone;
  gone.kind = bench::SampleKind::link;
  gone.source = static_cast<std::uint16_t>(bench::DeviceId::board);
  gone.state = static_cast<std::uint8_t>(bench::LinkState::closed);
  taker.take(gone);
  taker.take(seen(marker, {0, 0, 0}, 20));
  ASSERT_EQ(taker.rows().size(), 3u);
  EXPECT_EQ(taker.rows()[0].size(), 7u);
  ASSERT_EQ(taker.rows()[1].size(), 8u);
  EXPECT_EQ(taker.rows()[1][7], 12.345);
  EXPECT_EQ(taker.rows()[2].size(), 7u);
}

TEST(SampleTaker, WhatIsHeldHasTheBodyOfMarkersBesideIt)
{
  SampleCollector taker(marked_bench());
  taker.begin(task_with(hold, "probe", BodyRole::leg));
  // The leg has not been seen.
  EXPECT_FALSE(taker.take(seen(probe, {1, 2, 3}, 0)));
  send_leg(taker, {10, 20, 30}, 10);
  ASSERT_TRUE(taker.take(seen(probe, {1, 2, 3}, 10)));
  send_leg(taker, {11, 20, 30}, 20);
  ASSERT_TRUE(taker.take(seen(probe, {1, 2, 3}, 20)));
  // The last pose is older than stale_after_ms (100).
  EXPECT_FALSE(taker.take(seen(probe, {1, 2, 3}, 200)));
  const std::vector<std::vector<double>>& rows = taker.rows();
  ASSERT_EQ(rows.size(), 2u);
  ASSERT_EQ(rows[1].size(), 14u);
  EXPECT_NEAR(rows[0][7], 10.0, kept_mm);
  EXPECT_NEAR(rows[1][7], 11.0, kept_mm);
  EXPECT_NEAR(rows[1][9], 30.0, kept_mm);
}

TEST(SampleTaker, ABullseyeHasTheMarkersPositionAndTheHeadsPlaceWhereItIsTracked)
{
  SampleCollector taker(marked_bench());
  taker.begin(task_with(position, "marker"));
  taker.take(seen(marker, {1, 2, 3}, 0));
  EXPECT_EQ(taker.rows(), (std::vector<std::vector<double>>{{1.0, 2.0, 3.0}}));
  taker.begin(task_with(position, "marker", BodyRole::leg));
  EXPECT_TRUE(taker.rows().empty());
  send_leg(taker, {10, 20, 30}, 10);
  taker.take(seen(marker, {1, 2, 3}, 10));
  ASSERT_EQ(taker.rows().size(), 1u);
  EXPECT_EQ(taker.rows()[0].size(), 10u);
}

/// Thigh and shank in messages of their own: the thigh is interpolated to the time of the shank.
TEST(SampleTaker, ABendHasBothBodiesAtTheSameTime)
{
  const BenchFile bench = bench::read_bench_file(VRDA_JOBS "/bench-desk.toml");
  SampleCollector taker(bench);
  constexpr std::uint16_t femur = 0, tibia = 1;
  taker.begin(task_with(leg, "tibia"));
  // The thigh moves by 1 mm in 10 ms, the shank by 10.
  for (int k = 0; k < 5; ++k) {
    taker.take(seen(femur, {1.0 * k, 0, 0}, 10 * k));
    taker.take(seen(tibia, {10.0 * k, 0, 0}, 10 * k + 4));
  }
  const std::vector<std::vector<double>>& rows = taker.rows();
  ASSERT_EQ(rows.size(), 3u);
  for (std::size_t k = 0; k < rows.size(); ++k) {
    ASSERT_EQ(rows[k].size(), 14u);
    EXPECT_NEAR(rows[k][0], static_cast<double>(k) + 0.4, kept_mm);
    EXPECT_NEAR(rows[k][7], 10.0 * static_cast<double>(k), kept_mm);
  }
  // A hidden thigh gives no row, however long the shank is seen.
  for (int k = 5; k < 40; ++k) taker.take(seen(tibia, {10.0 * k, 0, 0}, 10 * k));
  taker.take(seen(femur, {40, 0, 0}, 400));
  taker.take(seen(femur, {41, 0, 0}, 410));
  taker.take(seen(tibia, {410, 0, 0}, 410));
  EXPECT_LE(taker.rows().size(), 4u);
}

}  // namespace vrda::calibration::tasks_test
