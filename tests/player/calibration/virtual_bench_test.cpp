#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "bench/rigid_body.hpp"
#include "calibration/operator.hpp"
#include "calibration/parts.hpp"
#include "calibration/statistics.hpp"
#include "core/units.hpp"
#include "player/calibration/trial.hpp"
#include "support/refusal.hpp"

namespace vrda::calibration::virtual_bench_test {

constexpr VirtualNoise no_noise{0, 0, 0, 0, 0, 0, 0};

const std::string table = "[calibration]\n";

BenchFile bench_of(HeadKind head, const std::string& lines = "")
{
  return test::virtual_bench(head, table, table + lines);
}

Calibration calibrated(const BenchFile& bench, const VirtualTruth& truth, const VirtualNoise& noise)
{
  CalibrationSession session(bench, bench::nominal_calibration(bench), test::options_of(bench));
  VirtualOperator hand(bench, truth, noise);
  while (session.task() != nullptr) hand.do_task(session);
  EXPECT_EQ(hand.n_refusals(), 0);
  return session.calibration();
}

/// Largest error of a part's parameters.
double largest_error(const Calibration& found, CalibrationPart part, const VirtualTruth& truth)
{
  const std::optional<Estimate>& estimate = found.records.at(part).estimate;
  return calibration::errors_of(estimate.value(), truth).lpNorm<Eigen::Infinity>();
}

TEST(VirtualOperator, WithoutNoiseEveryPartIsFoundToTheStepOfItsDials)
{
  for (const HeadKind head : {HeadKind::stage, HeadKind::tracker}) {
    const BenchFile bench = bench_of(head);
    for (const std::uint64_t seed : {1u, 2u, 3u}) {
      const VirtualTruth truth = virtual_truth(bench, seed);
      const Calibration found = calibrated(bench, truth, no_noise);
      // Whole columns and rows.
      EXPECT_LT(largest_error(found, CalibrationPart::viewport, truth), 0.5 + 1e-9);
      // Steps of a quarter of a pixel cause errors of up to an eighth, and a smaller median.
      std::vector<TargetError> errors = calibration::target_errors(found, bench, truth, no_noise);
      double sum_mm = 0.0;
      for (const TargetError& error : errors) sum_mm += error.mm;
      constexpr double eighth_mm = 0.125 * 800.0 / 880.0;
      EXPECT_LT(sum_mm / static_cast<double>(errors.size()), eighth_mm);
      // Quantities from the tracker alone have no step; their rows are stored to 1e-5 mm and 1e-8 of a
      // quaternion, which is 1e-6 mm at the tip. Scales have the step of the distances, 0.05 mm of 50.
      constexpr double rounding = 1e-5;
      EXPECT_LT(largest_error(found, CalibrationPart::probe, truth), rounding);
      EXPECT_LT(largest_error(found, CalibrationPart::subject, truth), 1e-3);
      if (head == HeadKind::stage) {
        EXPECT_LT(largest_error(found, CalibrationPart::rails, truth), rounding);
      }
    }
  }
}

TEST(VirtualOperator, AMuchTooNoisyOperatorEndsWithAMessage)
{
  const BenchFile bench = bench_of(HeadKind::stage);
  const VirtualTruth truth = virtual_truth(bench, 7);
  VirtualNoise noise;
  noise.tracker_mm = 50.0;
  CalibrationSession session(bench, bench::nominal_calibration(bench), test::options_of(bench));
  VirtualOperator hand(bench, truth, noise);
  EXPECT_THAT(test::input_error([&] {
                while (session.task() != nullptr) hand.do_task(session);
              }),
              test::refuses({"bench.toml", "rails/x rail", "refusals"}));
  EXPECT_GT(hand.n_refusals(), 10);
}

/// Least distance from the lines.
double distance_from(const std::vector<DrawnLine>& lines, const Eigen::Vector2d& p)
{
  double least = std::numeric_limits<double>::infinity();
  for (const DrawnLine& line : lines) {
    for (std::size_t k = 1; k < line.points_px.size(); ++k) {
      const Eigen::Vector2d from = line.points_px[k - 1], way = line.points_px[k] - from;
      const double s = std::clamp(way.dot(p - from) / way.squaredNorm(), 0.0, 1.0);
      least = std::min(least, (from + s * way - p).norm());
    }
  }
  return least;
}

Eigen::Vector2d middle_of(const DrawnLine& ring)
{
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (std::size_t k = 1; k < ring.points_px.size(); ++k) sum += ring.points_px[k];
  return sum / static_cast<double>(ring.points_px.size() - 1);
}

/// Distance between the drawn marks of a task and the real object.
double off_px(const Task& task, const std::vector<double>& row, const VirtualTruth& truth,
              const std::vector<DrawnLine>& real)
{
  const view::Eye& eye = task.is_right ? truth.calibration.eyes.right : truth.calibration.eyes.left;
  const Eigen::Vector2d seen = view::shown_px(eye.distortion, {row[0], row[1]});
  // A node's ring is the last item.
  if (!task.kind->traits().has_two_lines) return (seen - middle_of(real.back())).norm();
  return std::max(distance_from(real, seen),
                  distance_from(real, view::shown_px(eye.distortion, {row[2], row[3]})));
}

TEST(RealThings, AreWhereWhatIsDrawnIsSeenOnceItIsAligned)
{
  const BenchFile bench = bench_of(HeadKind::stage);
  const VirtualTruth truth = virtual_truth(bench, 12);
  CalibrationSession session(bench, bench::nominal_calibration(bench), test::options_of(bench));
  VirtualOperator hand(bench, truth, no_noise);
  std::map<std::string, int> met;
  // Half a step of a quarter of a pixel either way, magnified by up to a half; the marker's ring is centred
  // up to a few hundredths of a pixel of perspective.
  constexpr double aligned_px = 0.125 * 1.5 * 1.4142136 + 0.02;
  while (session.task() != nullptr) {
    const Task task = *session.task();
    const CalibrationPart part = session.progress().part;
    const std::vector<DrawnLine> real = task.kind->outlines(task, bench, truth);
    hand.do_task(session);
    ASSERT_EQ(hand.n_refusals(), 0);
    ++met[test::kind_of(task)];
    if (task.dials.size() != 2) continue;
    const std::vector<double> row = session.calibration().records.at(part).marks.back().rows.front();
    EXPECT_LT(off_px(task, row, truth, real), aligned_px) << task.name;
  }
  EXPECT_EQ(met["node"], 70);
  EXPECT_EQ(met["rectangle"], 24);
  EXPECT_EQ(met["bull's-eye"], 18);
}

/// With the true calibration and pose, the model's points coincide with the leg's.
TEST(RealThings, TheLegIsWhereAModelIsSeenThatIsPlacedRightly)
{
  for (const HeadKind head : {HeadKind::stage, HeadKind::tracker}) {
    const BenchFile bench = bench_of(head, "model = \"adjust\"\n");
    const VirtualTruth truth = virtual_truth(bench, 5);
    const bench::PoseParameters& six =
        truth.calibration.X_body_model[static_cast<std::size_t>(BodyRole::leg)];
    std::vector<double> values(six.shift_mm.begin(), six.shift_mm.end());
    for (const double turn_rad : six.turn_rad) values.push_back(turn_rad * deg_from_rad(1.0));
    const Task task = calibration::tasks_of(CalibrationPart::leg, bench, truth.calibration).front();
    const std::vector<DrawnLine> real = task.kind->outlines(task, bench, truth);
    ASSERT_EQ(real.size(), 2u);
    constexpr double rounding_px = 1e-6;
    const auto furthest_px = [&](const std::vector<DrawnLine>& drawn) {
      double furthest = 0.0;
      for (std::size_t eye = 0; eye < 2; ++eye) {
        const view::Distortion& optics =
            eye == 1 ? truth.calibration.eyes.right.distortion : truth.calibration.eyes.left.distortion;
        EXPECT_EQ(drawn[eye].is_right, real[eye].is_right);
        for (std::size_t k = 0; k < real[eye].points_px.size(); ++k) {
          const Eigen::Vector2d seen = view::shown_px(optics, drawn[eye].points_px.at(k));
          furthest = std::max(furthest, (seen - real[eye].points_px[k]).norm());
        }
      }
      return furthest;
    };
    EXPECT_LT(furthest_px(task.kind->draw_simulated(task, values, truth.calibration, bench, truth)),
              rounding_px);
    // An offset of 10 mm at 800 mm and 880 px is some 11 px.
    values[0] += 10.0;
    EXPECT_NEAR(furthest_px(task.kind->draw_simulated(task, values, truth.calibration, bench, truth)), 11.0,
                6.0);
  }
}

/// Seen from the eye, the scan line at the true reading lies on the edge over its whole length: both are
/// bent.
TEST(RealThings, AScanLineIsBentAsTheEdgeIs)
{
  const BenchFile bench = bench_of(HeadKind::stage);
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    const VirtualTruth truth = virtual_truth(bench, seed);
    const Calibration nominal = bench::nominal_calibration(bench);
    int n_bent = 0;
    for (const Task& task : calibration::tasks_of(CalibrationPart::viewport, bench, nominal)) {
      if (test::kind_of(task) != "scan line") continue;
      SCOPED_TRACE(task.name);
      const auto seen_at = [&](double value) {
        return seen_lines(task.kind->draw(task, std::vector{value}, nominal), truth);
      };
      EXPECT_EQ(seen_at(task.dials[0].value).size(), 1u) << "it starts where it can be seen";
      const view::ShownBox& e = truth.edges_px[task.is_right ? 1 : 0];
      const std::array borders{e.low_px.x(), e.high_px.x(), e.low_px.y(), e.high_px.y()};
      const bool is_last = task.index == 1 || task.index == 3;
      const double border = borders.at(static_cast<std::size_t>(task.index));
      const std::vector<DrawnLine> seen =
          seen_at(is_last ? std::floor(border - 0.5) : std::ceil(border - 0.5));
      ASSERT_EQ(seen.size(), 1u);
      EXPECT_TRUE(seen[0].is_smooth) << "whole pixels would straighten it";
      const std::vector<DrawnLine> edge = task.kind->outlines(task, bench, truth);
      double least = 1e9, most = -1e9;
      for (const Eigen::Vector2d& p : seen[0].points_px) {
        EXPECT_LT(distance_from(edge, p), 1.0 * 1.5) << "one pixel of the frame buffer, magnified";
        least = std::min(least, p[task.is_row ? 1 : 0]);
        most = std::max(most, p[task.is_row ? 1 : 0]);
      }
      n_bent += most - least > 4.0 ? 1 : 0;
    }
    EXPECT_GT(n_bent, 8) << "the lines are not straight";
  }
}

TEST(Deviation, IsTheDistanceOfTheDialsFromTheTruth)
{
  const BenchFile bench = bench_of(HeadKind::stage);
  const VirtualTruth truth = virtual_truth(bench, 12);
  CalibrationSession session(bench, bench::nominal_calibration(bench), test::options_of(bench));
  VirtualOperator hand(bench, truth, no_noise);
  std::map<std::string, int> met;
  while (session.task() != nullptr) {
    const Task task = *session.task();
    SCOPED_TRACE(task.name);
    if (task.dials.empty()) {
      EXPECT_FALSE(hand.deviation(session));
    } else {
      ++met[test::kind_of(task)];
      const std::vector<double> aligned = hand.aligned_values(session);
      const double first_off = std::abs(session.values()[0] - aligned[0]);
      const bool is_alone = task.dials.size() == 1;
      // A reading is a whole column; the edge is anywhere on it.
      const double grain = test::kind_of(task) == "scan line" ? 0.5 : 1e-9;
      if (is_alone) {
        EXPECT_NEAR(hand.deviation(session)->value, first_off, grain);
      } else {
        EXPECT_GE(hand.deviation(session)->value, first_off - grain);
      }
      EXPECT_EQ(hand.deviation(session)->unit, task.dials[0].unit);
    }
    hand.do_task(session);
  }
  EXPECT_EQ(met.size(), 7u) << "lines, crosses, rectangles, three kinds of numbers, bull's-eyes";
}

TEST(Deviation, OfAWholeGridAndOfAModelIsThatOfTheirPoints)
{
  const BenchFile bench = bench_of(HeadKind::stage, "distortion = \"adjust\"\nmodel = \"adjust\"\n");
  const VirtualTruth truth = virtual_truth(bench, 4);
  CalibrationSession session(bench, bench::nominal_calibration(bench), test::options_of(bench));
  VirtualOperator hand(bench, truth, no_noise);
  int n = 0;
  while (session.task() != nullptr) {
    const std::string kind = test::kind_of(*session.task());
    const bool is_many = session.values().size() > 2;
    const double before = is_many ? hand.deviation(session)->value : 0.0;
    if (is_many) {
      ++n;
      EXPECT_GT(before, kind == "grid" ? 1.0 : 0.1);
      EXPECT_EQ(hand.deviation(session)->unit, kind == "grid" ? "px" : "mm");
    }
    hand.do_task(session);
  }
  EXPECT_GT(n, 2);
}

// The truth of a virtual bench, and the errors of estimates and calibrations against it.

/// Mean square of many draws over their variance: one, within five standard deviations of chi-square.
void expect_variance(double sum_of_squares, int n, double sd)
{
  const double ratio = sum_of_squares / n / (sd * sd);
  EXPECT_NEAR(ratio, 1.0, 5.0 * std::sqrt(2.0 / n));
}

TEST(VirtualTruth, IsTheSameForTheSameSeedAndUsable)
{
  const BenchFile bench = test::virtual_bench(HeadKind::stage);
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const VirtualTruth truth = virtual_truth(bench, seed);
    EXPECT_EQ(bench::calibration_text(truth.calibration, bench),
              bench::calibration_text(virtual_truth(bench, seed).calibration, bench));
    EXPECT_NE(bench::calibration_text(truth.calibration, bench),
              bench::calibration_text(virtual_truth(bench, seed + 1).calibration, bench));
    EXPECT_NO_THROW(view::require_usable(truth.calibration.eyes, "truth"));
  }
}

TEST(VirtualTruth, WhatIsStatedAsKnownIsDrawnWithThoseDeviations)
{
  const BenchFile bench = test::virtual_bench(HeadKind::stage);
  constexpr int n = 500;
  double sights = 0.0, heights = 0.0, turns = 0.0;
  for (std::uint64_t seed = 1; seed <= n; ++seed) {
    const VirtualTruth truth = virtual_truth(bench, seed);
    const Calibration& c = truth.calibration;
    for (std::size_t k = 0; k < 2; ++k) {
      const view::ShownBox& e = truth.edges_px[k];
      const Eigen::Vector2d middle = 0.5 * (e.low_px + e.high_px);
      sights += ((k == 0 ? c.eyes.left : c.eyes.right).sight_px - middle).squaredNorm();
    }
    heights += std::pow(c.eyes.left.position_head_mm.y() - c.eyes.right.position_head_mm.y(), 2);
    turns += bench::turn_of(bench::pose_of(c.X_table_eyes).linear()).squaredNorm();
  }
  expect_variance(sights, 4 * n, bench.calibration.sight_sd_px);
  expect_variance(heights, n, bench.calibration.eye_height_sd_mm);
  expect_variance(turns, 3 * n, bench.calibration.alignment_sd_rad);
}

/// Tolerance of Newton's method and the secant method.
constexpr double solved_px = 1e-7;

TEST(SeenLines, AreCurvedByTheOpticsAndEndWithWhatIsSeen)
{
  const VirtualTruth truth = virtual_truth(test::bench(), 2);
  const view::Eye& eye = truth.calibration.eyes.left;
  DrawnLine line;
  const double row = eye.sight_px.y() - 100.0;
  line.points_px = {{eye.window.x + 0.0, row}, {eye.window.x + eye.window.width + 0.0, row}};
  const std::vector<DrawnLine> seen = seen_lines(std::span(&line, 1), truth);
  ASSERT_EQ(seen.size(), 1u);
  const std::vector<Eigen::Vector2d>& points = seen.front().points_px;
  const double left = truth.edges_px[0].low_px.x(), right = truth.edges_px[0].high_px.x();
  EXPECT_NEAR((points.front() - view::shown_px(eye.distortion, {left, row})).norm(), 0.0, solved_px);
  EXPECT_NEAR((points.back() - view::shown_px(eye.distortion, {right, row})).norm(), 0.0, solved_px);
  EXPECT_GT(points.size(), 60u);
  // Pincushion distortion: the ends of a line above the centre are seen higher than its middle.
  EXPECT_LT(points.front().y(), points[points.size() / 2].y() - 1.0);
}

TEST(SeenLines, OneThatLeavesAndComesBackIsTwo)
{
  const VirtualTruth truth = virtual_truth(test::bench(), 2);
  const view::ShownBox& e = truth.edges_px[1];
  DrawnLine line;
  line.is_right = true;
  const double middle = 0.5 * (e.low_px.y() + e.high_px.y()), right = e.high_px.x();
  line.points_px = {
      {right - 50, middle}, {right + 20, middle}, {right + 20, middle + 40}, {right - 50, middle + 40}};
  EXPECT_EQ(seen_lines(std::span(&line, 1), truth).size(), 2u);
  line.points_px = {{right + 5, middle}, {right + 20, middle}};
  EXPECT_TRUE(seen_lines(std::span(&line, 1), truth).empty());
}

TEST(TargetErrors, AreZeroForTheTruthAndTheLengthOfAShift)
{
  VirtualNoise none{0, 0, 0, 0, 0, 0, 0};
  for (const HeadKind head : {HeadKind::stage, HeadKind::tracker}) {
    const BenchFile file = test::virtual_bench(head);
    const VirtualTruth truth = virtual_truth(file, 11);
    // The encoder counts 5 um.
    const double counted_mm = head == HeadKind::stage ? file.stage_mm_per_count : 1e-9;
    const std::vector<TargetError> errors = calibration::target_errors(truth.calibration, file, truth, none);
    ASSERT_EQ(errors.size(), 40u);
    for (const TargetError& error : errors) EXPECT_LT(error.mm, counted_mm);
    // The display's image is 2 px higher: 2 px of about 880 at about 800 mm.
    Calibration off = truth.calibration;
    off.eyes.left.sight_px.y() -= 2.0;
    const std::vector<TargetError> shifted = calibration::target_errors(off, file, truth, none);
    constexpr double expected_mm = 2.0 * 800.0 / 880.0;
    for (std::size_t k = 0; k < shifted.size(); k += 2) {
      // Distances, depths and distortion vary by a fifth.
      EXPECT_NEAR(shifted[k].mm, expected_mm, 0.2 * expected_mm);
      EXPECT_LT(shifted[k + 1].mm, counted_mm);
      EXPECT_NEAR(shifted[k].arc_min, shifted[k].mm / 800.0 * 3437.7, 0.15 * shifted[k].arc_min);
    }
  }
}

constexpr std::uint64_t seed = 3;

/// The numbers of "name: dial 12.25 px, dial -3 px".
std::vector<double> numbers_in(const std::string& words, const Task& task)
{
  std::vector<double> values;
  std::size_t from = 0;
  for (const Dial& dial : task.dials) {
    const std::size_t at = words.find(dial.name + " ", from);
    if (at == std::string::npos) return {};
    values.push_back(std::stod(words.substr(at + dial.name.size())));
    from = at + dial.name.size();
  }
  return values;
}

/// A person who turns the dials by keys to what the rehearsal prints.
void set_dials(CalibrationSession& session, const std::vector<double>& wanted)
{
  for (std::size_t k = 0; k < wanted.size(); ++k) {
    const Dial dial = session.task()->dials[k];
    // A number that is right as it is must be touched.
    session.take(view::KeyPress{k == 0 ? view::Key::right : view::Key::up});
    session.take(view::KeyPress{k == 0 ? view::Key::left : view::Key::down});
    const bool is_cross = session.task()->kind->traits().is_cross;
    for (long n = std::lround((wanted[k] - session.values()[k]) / dial.step); n != 0;) {
      const long size = std::abs(n) >= 100 ? 100 : std::abs(n) >= 10 ? 10 : 1;
      const bool is_more = n > 0;
      const view::Key key = k == 0                ? (is_more ? view::Key::right : view::Key::left)
                            : is_more != is_cross ? view::Key::up
                                                  : view::Key::down;
      session.take(view::KeyPress{key, size == 10, size == 100});
      n -= is_more ? size : -size;
    }
  }
}

/// The whole procedure with the messages that `simulate --rehearse` sends, as devices would receive them.
TEST(Rehearsal, EveryTaskCanBeDoneWithWhatItSendsAndPrints)
{
  for (const HeadKind head : {HeadKind::stage, HeadKind::tracker}) {
    const BenchFile bench = bench::parse_bench_file(virtual_bench_text(head), "bench.toml");
    const std::vector<CalibrationPart> parts = parts_of_step("all", bench);
    Rehearsal rehearsal(bench, parts, seed);
    CalibrationSession session(bench, bench::nominal_calibration(bench), {parts, false, "", "c.toml"});
    double now_s = 0.0;
    std::uint64_t tick = 0;
    bool is_zeroed = false;
    const auto send = [&] {
      now_s += 0.01;
      bench::Sample sample;
      sample.arrival_ns = sample.device_ns = static_cast<std::int64_t>(1e9 * now_s);
      if (has_stage(bench)) {
        sample.kind = bench::SampleKind::stage;
        sample.count = rehearsal.stage_count(now_s);
        sample.state = is_zeroed ? bench::stage_zeroed : 0;
        session.take(sample);
      }
      const bench::IgtlMessage message = rehearsal.message(tick++, now_s);
      sample.kind = bench::SampleKind::tool_pose;
      for (std::size_t k = 0; k < bench.tracker->tools.size(); ++k) {
        const auto tool = std::ranges::find(message.tools, bench.tracker->tools[k], &bench::IgtlTool::name);
        sample.source = static_cast<std::uint16_t>(k);
        sample.state = static_cast<std::uint8_t>(tool == message.tools.end() ? bench::ToolVisibility::missing
                                                                             : bench::ToolVisibility::seen);
        if (tool != message.tools.end()) sample.tool_pose = bench::place_of(tool->X_tracker_tool);
        session.take(sample);
      }
    };
    int n_tasks = 0;
    while (session.task() != nullptr) {
      ASSERT_LT(++n_tasks, 1000);
      const Task task = *session.task();
      SCOPED_TRACE(task.name);
      const std::string said = rehearsal.follow(session.calibration(), now_s);
      if (n_tasks > 1) {
        EXPECT_NE(said.find(task.name), std::string::npos) << said;
        set_dials(session, numbers_in(said, task));
      } else {
        set_dials(session,
                  {static_cast<double>(std::lround(virtual_truth(bench, seed).edges_px[0].low_px.x()))});
      }
      if (task.name.ends_with("rail"))
        while (rehearsal.prompt(now_s).empty()) send();
      for (int k = 0; k < 3; ++k) send();
      session.take(view::KeyPress{view::Key::enter});
      for (int k = 0; k < 2000 && session.progress().is_sampling; ++k) send();
      ASSERT_FALSE(session.progress().has_error) << session.progress().messages.front();
      if (session.take_zero_request()) is_zeroed = true;
    }
    EXPECT_EQ(rehearsal.follow(session.calibration(), now_s), "all parts are done");
    // The display's errors are those of the aligned lines: the eyes are found as by the simulated operator.
    const VirtualTruth truth = virtual_truth(bench, seed);
    EXPECT_NEAR(session.calibration().eyes.left.distance_px, truth.calibration.eyes.left.distance_px, 15.0);
    EXPECT_NEAR(session.calibration().subject_scale, truth.calibration.subject_scale, 0.03);
  }
}

}  // namespace vrda::calibration::virtual_bench_test
