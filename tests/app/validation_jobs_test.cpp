// The jobs of thesis chapter 4, jobs/validation: each scene and its trace end as described in the thesis.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "app/scenes.hpp"
#include "app/shipped_warnings.hpp"
#include "core/units.hpp"
#include "model/step_record.hpp"
#include "store/motion_model.hpp"
#include "store/trace.hpp"
#include "support/real_knees.hpp"

namespace vrda::validation_jobs_test {

constexpr double resolution_mm = 0.1, resolution_deg = 0.1;  // of every job

/// A job of one attitude, run from the command line.
struct Scene {
  explicit Scene(const std::string& job)
  {
    const test::Scratch scratch;
    const std::string output = (scratch.path() / "scene.h5").string();
    const std::string file = (test::source_directory() / "jobs" / "validation" / job).string();
    ended = test::run_vrda({"run", file, "-o", output, "--trace", "--progress", "none"});
    test::expect_known_warnings("validation/" + std::filesystem::path(job).stem().string(), "run", ended);
    model = store::read_motion_model(output);
    trace = store::read_trace(store::trace_name(output));
    store::require_trace_matches_model(trace, store::trace_name(output), model, output);
  }
  StepStatus status() const { return static_cast<StepStatus>(model.status(0, 0)); }
  int count(MoveKind kind) const
  {
    return static_cast<int>(
        std::count(trace.moves.kind.begin(), trace.moves.kind.end(), static_cast<std::int8_t>(kind)));
  }
  /// Position of the moving object after a move.
  Eigen::Vector3d at(std::size_t move) const
  {
    return trace.moves.translation_mm.row(static_cast<Eigen::Index>(move)).cast<double>();
  }
  std::size_t last_move() const { return trace.moves.kind.size() - 1; }

  test::Ended ended;
  store::MotionModel model;
  store::Trace trace;
};

void expect_run(const Scene& scene, StepStatus status)
{
  EXPECT_EQ(scene.ended.exit_code, 0) << scene.ended.err;
  ASSERT_EQ(scene.model.status.size(), 1);
  EXPECT_EQ(scene.status(), status);
  ASSERT_EQ(scene.trace.searches.node.size(), 1U);
}

// A stable search ends in contact, at the pose of the motion model within the precision of the trace.
void expect_last_touch_at_rest(const Scene& scene)
{
  ASSERT_FALSE(scene.trace.moves.in_contact.empty());
  EXPECT_EQ(scene.trace.moves.in_contact.back(), 1);
  EXPECT_EQ(store::moves_in_contact(scene.trace, 0).back(), scene.last_move());
  const Eigen::Vector3d rest(scene.model.tx_mm(0, 0), scene.model.ty_mm(0, 0), scene.model.tz_mm(0, 0));
  EXPECT_LT((scene.at(scene.last_move()) - rest).norm(), 1e-5);
  EXPECT_GT(scene.trace.moves.contact_start.back(), *(scene.trace.moves.contact_start.end() - 2));
}

// Generated on the axis and displaced by moving.initial: its translation is the error.
void expect_ball_in_the_middle(const std::string& job)
{
  const Scene scene(job);
  expect_run(scene, StepStatus::stable);
  expect_last_touch_at_rest(scene);
  const Eigen::Vector3d first = scene.at(store::moves_in_contact(scene.trace, 0).front());
  EXPECT_GT(std::hypot(first.x(), first.z()), 13.0);
  EXPECT_LT(std::hypot(scene.model.tx_mm(0, 0), scene.model.tz_mm(0, 0)), 2.0 * resolution_mm)
      << "halving from 1 mm can miss by 1.25 resolutions";
  EXPECT_GT(scene.count(MoveKind::translate), 10);
}

TEST(ValidationJobs, TheBallEndsInTheMiddleOfTheDish)
{
  expect_ball_in_the_middle("ball-in-dish.toml");
}

TEST(ValidationJobs, TheBallEndsInTheMiddleOfANonMonotoneSlope)
{
  expect_ball_in_the_middle("ball-on-non-monotone-slope.toml");
}

TEST(ValidationJobs, TheBallGoesThroughTheHole)
{
  const Scene scene("peg-in-hole.toml");
  expect_run(scene, StepStatus::no_contact);
  EXPECT_EQ(scene.trace.searches.status[0], static_cast<std::int8_t>(StepStatus::no_contact));
  // It ends when the ball of 5 mm clears the hole of 12 mm on all sides; the polyhedron is at most 0.1 mm
  // inside the ball. The last contact is one step of at most 1 mm along each axis before that.
  const double room_mm = 6.0 - 5.0 + 0.1;
  const Eigen::Vector3d first = scene.at(store::moves_in_contact(scene.trace, 0).front());
  const Eigen::Vector3d touch = scene.at(store::moves_in_contact(scene.trace, 0).back());
  const Eigen::Vector3d end = scene.at(scene.last_move());
  EXPECT_GT(std::hypot(first.x(), first.z()), 12.0);
  EXPECT_LT(std::max(std::abs(touch.x()), std::abs(touch.z())), room_mm + 1.0);
  EXPECT_LT(std::max(std::abs(end.x()), std::abs(end.z())), room_mm);
  EXPECT_EQ(scene.trace.moves.kind.back(), static_cast<std::int8_t>(MoveKind::translate));
}

TEST(ValidationJobs, ANarrowerHoleHoldsTheBall)
{
  // As described in the job's comment.
  const test::Scratch scratch;
  std::string text = test::text_of(test::source_directory() / "jobs" / "validation" / "peg-in-hole.toml");
  const std::string wide = "hole = 12";
  for (std::size_t at = text.find(wide, text.find("[reference]")); at != std::string::npos;
       at = text.find(wide, at))
    text.replace(at, wide.size(), "hole = 8");
  const std::string job = scratch.write("narrow.toml", text).string();
  const std::string output = (scratch.path() / "narrow.h5").string();
  EXPECT_EQ(test::run_vrda({"run", job, "-o", output, "--progress", "none"}).exit_code, 0);
  EXPECT_EQ(static_cast<StepStatus>(store::read_motion_model(output).status(0, 0)), StepStatus::stable);
}

TEST(ValidationJobs, TheBarTurnsUntilItFitsBetweenThePyramids)
{
  const Scene scene("bar-on-pyramids.toml");
  expect_run(scene, StepStatus::stable);
  expect_last_touch_at_rest(scene);
  // On the floor: generated 20 mm below it.
  EXPECT_NEAR(scene.model.ty_mm(0, 0), 20.0, resolution_mm);
  // Between bases 20 mm long and 10 mm apart a bar of 8 mm fits when 8 / cos + 20 tan is at most 10.
  const double theta_rad = std::abs(rad_from_deg(scene.model.theta_deg(0, 0)));
  EXPECT_LE(8.0 / std::cos(theta_rad) + 20.0 * std::tan(theta_rad), 10.0 + resolution_mm);
  EXPECT_GT(scene.count(MoveKind::rotate), 10) << "from 30 degrees";
}

TEST(ValidationJobs, TheCapSitsInTheSink)
{
  const Scene scene("cap-in-sink.toml");
  expect_run(scene, StepStatus::stable);
  expect_last_touch_at_rest(scene);
  // Tip in tip: generated 25 mm below it, with faces of equal slope.
  EXPECT_NEAR(scene.model.ty_mm(0, 0), 25.0, resolution_mm);
  EXPECT_LT(std::hypot(scene.model.tx_mm(0, 0), scene.model.tz_mm(0, 0)), resolution_mm);
  // Rotation tolerance: the rotation resolution, or the angle that moves its sides (at 14 mm) by the
  // translation resolution.
  EXPECT_LE(std::abs(scene.model.theta_deg(0, 0)), resolution_deg + deg_from_rad(resolution_mm / 14.0));
  EXPECT_GT(scene.count(MoveKind::rotate), 10) << "from 30 degrees";
  EXPECT_GT(scene.count(MoveKind::translate), 0) << "from a position off the centre";
}

}  // namespace vrda::validation_jobs_test
