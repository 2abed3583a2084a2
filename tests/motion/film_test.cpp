#include "motion/film.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/units.hpp"
#include "motion/poses.hpp"
#include "motion/support/models.hpp"
#include "support/input_error.hpp"
#include "support/traces.hpp"

namespace vrda::film_test {

using testing::HasSubstr;

/// Flexion 0 to 20, varus -1 to 1, spine at 0; all poses differ. The cell at 10, 1 is not solved.
MotionModel small_model(const std::string& side = "right")
{
  test::ModelPlan plan;
  plan.side = side;
  plan.flexion_deg = {0, 10, 20};
  plan.varus_deg = {-1, 0, 1};
  plan.motion = [](double flexion_deg, double varus_deg) {
    return PoseNumbers{0.125 * flexion_deg, -30.0, varus_deg, 0.25 * flexion_deg};
  };
  MotionModel model = test::model_of(plan);
  test::unsolve(model, 1, 2);
  return model;
}

TEST(Film, RunsFromTheSeedToTheStablePoseOfTheSpineAtTheFirstFlexion)
{
  const Film film = film_of(test::trace_beside(small_model()), "t", {});
  EXPECT_EQ(film.attitude.flexion_rad, 0.0);
  EXPECT_EQ(film.attitude.varus_rad, 0.0);
  ASSERT_EQ(film.frames.size(), 1U + test::n_moves_of_a_cell);
  // Exact: halves and quarters of mm are representable in single precision.
  EXPECT_EQ(film.frames.front(), (PoseNumbers{0.5, -33.0, 0.0, rad_from_deg(0.5)}));
  EXPECT_EQ(film.frames.back(), (PoseNumbers{0.0, -30.0, 0.0, 0.0}));
}

TEST(Film, OfAnyCellAskedFor)
{
  const Trace trace = test::trace_beside(small_model());
  FilmOptions options;
  options.cell.flexion_deg = 20.0;
  EXPECT_EQ(film_of(trace, "t", options).frames.back(), (PoseNumbers{2.5, -30.0, 0.0, rad_from_deg(5.0)}));
  options.cell.varus_deg = -1.0;
  EXPECT_EQ(film_of(trace, "t", options).frames.back(), (PoseNumbers{2.5, -30.0, -1.0, rad_from_deg(5.0)}));
  // The row's search counts, not an earlier probe.
  options.cell = {0.0, 1.0};
  EXPECT_EQ(film_of(trace, "t", options).frames.size(), 1U + test::n_moves_of_a_cell);
}

TEST(Film, InContactLeavesTheTouchesOnly)
{
  FilmOptions options;
  options.contact_only = true;
  const Film film = film_of(test::trace_beside(small_model()), "t", options);
  ASSERT_EQ(film.frames.size(), static_cast<std::size_t>(test::n_touches_of_a_cell));
  EXPECT_EQ(film.frames.front()[1], -30.25);
  EXPECT_EQ(film.frames.back(), (PoseNumbers{0.0, -30.0, 0.0, 0.0}));
}

TEST(Film, EverySoManyKeepsTheFirstAndTheLast)
{
  const Trace trace = test::trace_beside(small_model());
  const Film all = film_of(trace, "t", {});
  for (const int every : {2, 3, 8, 100}) {
    SCOPED_TRACE(every);
    FilmOptions options;
    options.every = every;
    const Film film = film_of(trace, "t", options);
    const std::size_t n_steps =
        (all.frames.size() - 1 + static_cast<std::size_t>(every) - 1) / static_cast<std::size_t>(every);
    EXPECT_EQ(film.frames.size(), n_steps + 1);
    EXPECT_EQ(film.frames.front(), all.frames.front());
    EXPECT_EQ(film.frames.back(), all.frames.back());
  }
}

TEST(Film, ASearchWithoutMovesIsItsSeed)
{
  FilmOptions options;
  options.cell = {10.0, 1.0};
  const Trace trace = test::trace_beside(small_model());
  EXPECT_EQ(film_of(trace, "t", options).frames.size(), 1U);
  options.contact_only = true;
  EXPECT_THAT(test::input_error([&] { film_of(trace, "t", options); }).found,
              HasSubstr("no move in contact"));
}

TEST(Film, WhatIsNotThereIsNamed)
{
  const Trace trace = test::trace_beside(small_model());
  FilmOptions options;
  options.cell.flexion_deg = 12.0;
  const InputError::Facts facts = test::input_error([&] { film_of(trace, "t", options); });
  EXPECT_EQ(facts.file, "t");
  EXPECT_THAT(facts.wanted, HasSubstr("flexion 10"));
}

TEST(Film, ItsLastPoseIsTheModelsOnBothSides)
{
  for (const std::string side : {"right", "left"}) {
    const MotionModel model = small_model(side);
    const Motion motion(model, "raw");
    FilmOptions options;
    options.cell = {20.0, -1.0};
    const Film film = film_of(test::trace_beside(model), "t", options);
    const JointPose shown = motion.placed(film.attitude, film.frames.back());
    const JointPose wanted = motion.at({rad_from_deg(20), rad_from_deg(-1)});
    EXPECT_EQ(shown.status, PoseStatus::solved);
    // The poses are exact in single precision; the difference is the interpolation's rounding at a node.
    EXPECT_TRUE(shown.X_reference_moving.isApprox(wanted.X_reference_moving, 1e-12));
    EXPECT_TRUE(shown.X_world_moving.isApprox(wanted.X_world_moving, 1e-12));
    EXPECT_EQ(shown.attitude.varus_rad, rad_from_deg(-1));
  }
}

}  // namespace vrda::film_test
