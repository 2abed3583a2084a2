#include "calibration/operator.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <limits>
#include <map>

#include "calibration/parts.hpp"
#include "calibration/statistics.hpp"
#include "core/units.hpp"
#include "player/calibration/trial.hpp"
#include "support/refusal.hpp"

namespace vrda::calibration::virtual_operator_test {

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
      const VirtualTruth::Edges& e = truth.edges_px[task.is_right ? 1 : 0];
      const std::array borders{e.left, e.right, e.top, e.bottom};
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

}  // namespace vrda::calibration::virtual_operator_test
