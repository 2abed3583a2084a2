#include "calibration/operator.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <limits>
#include <map>

#include "calibration/statistics.hpp"
#include "calibration/task.hpp"
#include "core/units.hpp"
#include "support/refusal.hpp"

namespace vrda::virtual_operator_test {

constexpr calibration::VirtualNoise no_noise{0, 0, 0, 0, 0, 0, 0};

bench::BenchFile bench_of(bench::HeadKind head, const std::string& lines = "")
{
  std::string text = calibration::virtual_bench_text(head);
  const std::string table = "[calibration]\n";
  text.insert(text.find(table) + table.size(), lines);
  return bench::parse_bench_file(text, "virtual bench");
}

calibration::CalibrationSessionOptions options_of(const bench::BenchFile& bench)
{
  calibration::CalibrationSessionOptions options;
  options.parts = calibration::parts_of_step("all", bench);
  options.date = "2026-11-22";
  options.path = "calibration.toml";
  return options;
}

bench::Calibration calibrated(const bench::BenchFile& bench, const calibration::VirtualTruth& truth,
                              const calibration::VirtualNoise& noise)
{
  calibration::CalibrationSession session(bench, bench::nominal_calibration(bench), options_of(bench));
  calibration::VirtualOperator hand(bench, truth, noise);
  while (session.task() != nullptr) hand.do_task(session);
  EXPECT_EQ(hand.n_refusals(), 0);
  return session.calibration();
}

/// Largest error of a part's parameters.
double largest_error(const bench::Calibration& found, bench::CalibrationPart part,
                     const calibration::VirtualTruth& truth)
{
  const std::optional<bench::Estimate>& estimate = found.records.at(part).estimate;
  return calibration::errors_of(estimate.value(), truth).lpNorm<Eigen::Infinity>();
}

TEST(VirtualOperator, WithoutNoiseEveryPartIsFoundToTheStepOfItsDials)
{
  for (const bench::HeadKind head : {bench::HeadKind::stage, bench::HeadKind::tracker}) {
    const bench::BenchFile bench = bench_of(head);
    for (const std::uint64_t seed : {1u, 2u, 3u}) {
      const calibration::VirtualTruth truth = calibration::virtual_truth(bench, seed);
      const bench::Calibration found = calibrated(bench, truth, no_noise);
      // Whole columns and rows.
      EXPECT_LT(largest_error(found, bench::CalibrationPart::viewport, truth), 0.5 + 1e-9);
      // Steps of a quarter of a pixel cause errors of up to an eighth, and a smaller median.
      std::vector<calibration::TargetError> errors =
          calibration::target_errors(found, bench, truth, no_noise);
      double sum_mm = 0.0;
      for (const calibration::TargetError& error : errors) sum_mm += error.mm;
      constexpr double eighth_mm = 0.125 * 800.0 / 880.0;
      EXPECT_LT(sum_mm / static_cast<double>(errors.size()), eighth_mm);
      // Quantities from the tracker alone have no step; their rows are stored to 1e-5 mm and 1e-8 of a
      // quaternion, which is 1e-6 mm at the tip. Scales have the step of the distances, 0.05 mm of 50.
      constexpr double rounding = 1e-5;
      EXPECT_LT(largest_error(found, bench::CalibrationPart::probe, truth), rounding);
      EXPECT_LT(largest_error(found, bench::CalibrationPart::subject, truth), 1e-3);
      if (head == bench::HeadKind::stage) {
        EXPECT_LT(largest_error(found, bench::CalibrationPart::rails, truth), rounding);
      }
    }
  }
}

TEST(VirtualOperator, OneThatGoesOnElsewhereEndsAsOneThatWasNotInterrupted)
{
  const bench::BenchFile bench =
      bench_of(bench::HeadKind::stage, "edge_repeats = 2\ngrid = [4, 3]\nrectangle_repeats = 1\n");
  const calibration::VirtualTruth truth = calibration::virtual_truth(bench, 7);
  const bench::Calibration whole = calibrated(bench, truth, calibration::VirtualNoise{});
  bench::Calibration begun = bench::nominal_calibration(bench);
  int n_sessions = 0;
  for (bool is_done = false; !is_done; ++n_sessions) {
    calibration::CalibrationSession session(bench, begun, options_of(bench));
    calibration::VirtualOperator hand(bench, truth, calibration::VirtualNoise{});
    for (int n = 0; n < 7 && session.task() != nullptr; ++n) hand.do_task(session);
    is_done = session.task() == nullptr;
    begun = session.calibration();
  }
  EXPECT_GT(n_sessions, 10);
  EXPECT_EQ(bench::calibration_text(begun, bench), bench::calibration_text(whole, bench));
}

TEST(VirtualOperator, AMuchTooNoisyOperatorEndsWithAMessage)
{
  const bench::BenchFile bench = bench_of(bench::HeadKind::stage);
  const calibration::VirtualTruth truth = calibration::virtual_truth(bench, 7);
  calibration::VirtualNoise noise;
  noise.tracker_mm = 50.0;
  calibration::CalibrationSession session(bench, bench::nominal_calibration(bench), options_of(bench));
  calibration::VirtualOperator hand(bench, truth, noise);
  EXPECT_THAT(test::input_error([&] {
                while (session.task() != nullptr) hand.do_task(session);
              }),
              test::refuses({"virtual bench", "rails/x rail", "refusals"}));
  EXPECT_GT(hand.n_refusals(), 10);
}

/// Least distance from the lines.
double distance_from(const std::vector<calibration::DrawnLine>& lines, const Eigen::Vector2d& p)
{
  double least = std::numeric_limits<double>::infinity();
  for (const calibration::DrawnLine& line : lines) {
    for (std::size_t k = 1; k < line.points_px.size(); ++k) {
      const Eigen::Vector2d from = line.points_px[k - 1], way = line.points_px[k] - from;
      const double s = std::clamp(way.dot(p - from) / way.squaredNorm(), 0.0, 1.0);
      least = std::min(least, (from + s * way - p).norm());
    }
  }
  return least;
}

Eigen::Vector2d middle_of(const calibration::DrawnLine& ring)
{
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (std::size_t k = 1; k < ring.points_px.size(); ++k) sum += ring.points_px[k];
  return sum / static_cast<double>(ring.points_px.size() - 1);
}

/// Distance between the drawn marks of a task and the real object.
double off_px(const calibration::Task& task, const std::vector<double>& row,
              const calibration::VirtualTruth& truth, const std::vector<calibration::DrawnLine>& real)
{
  const view::Eye& eye = task.is_right ? truth.calibration.eyes.right : truth.calibration.eyes.left;
  const Eigen::Vector2d seen = view::shown_px(eye.distortion, {row[0], row[1]});
  // A node's ring is the last item.
  if (task.kind != calibration::TaskKind::rectangle_sides) return (seen - middle_of(real.back())).norm();
  return std::max(distance_from(real, seen),
                  distance_from(real, view::shown_px(eye.distortion, {row[2], row[3]})));
}

TEST(RealThings, AreWhereWhatIsDrawnIsSeenOnceItIsAligned)
{
  const bench::BenchFile bench = bench_of(bench::HeadKind::stage);
  const calibration::VirtualTruth truth = calibration::virtual_truth(bench, 12);
  calibration::CalibrationSession session(bench, bench::nominal_calibration(bench), options_of(bench));
  calibration::VirtualOperator hand(bench, truth, no_noise);
  std::map<calibration::TaskKind, int> met;
  // Half a step of a quarter of a pixel either way, magnified by up to a half; the marker's ring is centred
  // up to a few hundredths of a pixel of perspective.
  constexpr double aligned_px = 0.125 * 1.5 * 1.4142136 + 0.02;
  while (session.task() != nullptr) {
    const calibration::Task task = *session.task();
    const bench::CalibrationPart part = session.progress().part;
    const std::vector<calibration::DrawnLine> real = calibration::physical_outlines(task, bench, truth);
    hand.do_task(session);
    ASSERT_EQ(hand.n_refusals(), 0);
    ++met[task.kind];
    if (task.kind != calibration::TaskKind::point && task.kind != calibration::TaskKind::rectangle_sides &&
        task.kind != calibration::TaskKind::bullseye) {
      continue;
    }
    const std::vector<double> row = session.calibration().records.at(part).marks.back().rows.front();
    EXPECT_LT(off_px(task, row, truth, real), aligned_px) << task.name;
  }
  EXPECT_EQ(met[calibration::TaskKind::point], 70);
  EXPECT_EQ(met[calibration::TaskKind::rectangle_sides], 24);
  EXPECT_EQ(met[calibration::TaskKind::bullseye], 18);
}

/// With the true calibration and pose, the model's points coincide with the leg's.
TEST(RealThings, TheLegIsWhereAModelIsSeenThatIsPlacedRightly)
{
  for (const bench::HeadKind head : {bench::HeadKind::stage, bench::HeadKind::tracker}) {
    const bench::BenchFile bench = bench_of(head, "model = \"adjust\"\n");
    const calibration::VirtualTruth truth = calibration::virtual_truth(bench, 5);
    const bench::PoseParameters& six =
        truth.calibration.X_body_model[static_cast<std::size_t>(bench::BodyRole::leg)];
    std::vector<double> values(six.shift_mm.begin(), six.shift_mm.end());
    for (const double turn_rad : six.turn_rad) values.push_back(turn_rad * deg_from_rad(1.0));
    const calibration::Task task =
        calibration::tasks_of(bench::CalibrationPart::leg, bench, truth.calibration).front();
    const std::vector<calibration::DrawnLine> real = calibration::physical_outlines(task, bench, truth);
    ASSERT_EQ(real.size(), 2u);
    constexpr double rounding_px = 1e-6;
    const auto furthest_px = [&](const std::vector<calibration::DrawnLine>& drawn) {
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
    EXPECT_LT(furthest_px(calibration::drawn_model_lines(
                  {bench::CalibrationPart::leg, values, truth.calibration}, bench, truth)),
              rounding_px);
    // An offset of 10 mm at 800 mm and 880 px is some 11 px.
    values[0] += 10.0;
    EXPECT_NEAR(furthest_px(calibration::drawn_model_lines(
                    {bench::CalibrationPart::leg, values, truth.calibration}, bench, truth)),
                11.0, 6.0);
  }
}

/// Seen from the eye, the scan line at the true reading lies on the edge over its whole length: both are
/// bent.
TEST(RealThings, AScanLineIsBentAsTheEdgeIs)
{
  const bench::BenchFile bench = bench_of(bench::HeadKind::stage);
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    const calibration::VirtualTruth truth = calibration::virtual_truth(bench, seed);
    const bench::Calibration nominal = bench::nominal_calibration(bench);
    int n_bent = 0;
    for (const calibration::Task& task :
         calibration::tasks_of(bench::CalibrationPart::viewport, bench, nominal)) {
      if (task.kind != calibration::TaskKind::scan_line) continue;
      SCOPED_TRACE(task.name);
      const auto seen_at = [&](double value) {
        return calibration::seen_lines(calibration::task_lines(task, std::vector{value}, nominal), truth);
      };
      EXPECT_EQ(seen_at(task.dials[0].value).size(), 1u) << "it starts where it can be seen";
      const calibration::VirtualTruth::Edges& e = truth.edges_px[task.is_right ? 1 : 0];
      const std::array borders{e.left, e.right, e.top, e.bottom};
      const bool is_last = task.index == 1 || task.index == 3;
      const std::vector<calibration::DrawnLine> seen =
          seen_at(calibration::scan_reading(borders.at(static_cast<std::size_t>(task.index)), is_last));
      ASSERT_EQ(seen.size(), 1u);
      EXPECT_TRUE(seen[0].is_smooth) << "whole pixels would straighten it";
      const std::vector<calibration::DrawnLine> edge = calibration::physical_outlines(task, bench, truth);
      double least = 1e9, most = -1e9;
      for (const Eigen::Vector2d& p : seen[0].points_px) {
        EXPECT_LT(distance_from(edge, p), 1.0 * 1.5) << "one pixel of the frame buffer, magnified";
        least = std::min(least, p[task.is_column ? 0 : 1]);
        most = std::max(most, p[task.is_column ? 0 : 1]);
      }
      n_bent += most - least > 4.0 ? 1 : 0;
    }
    EXPECT_GT(n_bent, 8) << "the lines are not straight";
  }
}

TEST(Deviation, IsTheDistanceOfTheDialsFromTheTruth)
{
  const bench::BenchFile bench = bench_of(bench::HeadKind::stage);
  const calibration::VirtualTruth truth = calibration::virtual_truth(bench, 12);
  calibration::CalibrationSession session(bench, bench::nominal_calibration(bench), options_of(bench));
  calibration::VirtualOperator hand(bench, truth, no_noise);
  std::map<calibration::TaskKind, int> met;
  while (session.task() != nullptr) {
    const calibration::Task task = *session.task();
    SCOPED_TRACE(task.name);
    if (task.dials.empty()) {
      EXPECT_FALSE(hand.deviation(session));
    } else {
      ++met[task.kind];
      const std::vector<double> aligned = hand.aligned_values(session);
      const double first_off = std::abs(session.values()[0] - aligned[0]);
      const bool is_alone = task.dials.size() == 1;
      // A reading is a whole column; the edge is anywhere on it.
      const double grain = task.kind == calibration::TaskKind::scan_line ? 0.5 : 1e-9;
      if (is_alone) {
        EXPECT_NEAR(hand.deviation(session)->value, first_off, grain);
      } else {
        EXPECT_GE(hand.deviation(session)->value, first_off - grain);
      }
      EXPECT_EQ(hand.deviation(session)->unit, task.dials[0].unit);
    }
    hand.do_task(session);
  }
  EXPECT_EQ(met.size(), 5u) << "lines, crosses, rectangles, numbers, bull's-eyes";
}

TEST(Deviation, OfAWholeGridAndOfAModelIsThatOfTheirPoints)
{
  const bench::BenchFile bench =
      bench_of(bench::HeadKind::stage, "distortion = \"adjust\"\nmodel = \"adjust\"\n");
  const calibration::VirtualTruth truth = calibration::virtual_truth(bench, 4);
  calibration::CalibrationSession session(bench, bench::nominal_calibration(bench), options_of(bench));
  calibration::VirtualOperator hand(bench, truth, no_noise);
  int n = 0;
  while (session.task() != nullptr) {
    const calibration::TaskKind kind = session.task()->kind;
    const bool is_many = session.values().size() > 2;
    const double before = is_many ? hand.deviation(session)->value : 0.0;
    if (is_many) {
      ++n;
      EXPECT_GT(before, kind == calibration::TaskKind::grid ? 1.0 : 0.1);
      EXPECT_EQ(hand.deviation(session)->unit, kind == calibration::TaskKind::grid ? "px" : "mm");
    }
    hand.do_task(session);
  }
  EXPECT_GT(n, 2);
}

}  // namespace vrda::virtual_operator_test
