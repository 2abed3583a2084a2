#include "store/trace.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/units.hpp"
#include "store/motion.hpp"
#include "support/models.hpp"
#include "support/refusal.hpp"
#include "support/traces.hpp"

namespace vrda::film_test {

/// Flexion 0 to 20, varus -1 to 1, spine at 0; all poses differ. The cell at 10, 1 is not solved.
store::MotionModel small_model(const std::string& side = "right")
{
  test::ModelPlan plan;
  plan.side = side;
  plan.flexion_deg = {0, 10, 20};
  plan.varus_deg = {-1, 0, 1};
  plan.motion = [](double flexion_deg, double varus_deg) {
    return store::PoseCoordinates{0.125 * flexion_deg, -30.0, varus_deg, 0.25 * flexion_deg};
  };
  store::MotionModel model = test::model_of(plan);
  test::unsolve(model, 1, 2);
  return model;
}

TEST(Film, RunsFromTheSeedToTheStablePoseOfTheSpineAtTheFirstFlexion)
{
  const store::Film film = store::film_of(test::trace_beside(small_model()), "t", {});
  EXPECT_EQ(film.attitude.flexion_rad, 0.0);
  EXPECT_EQ(film.attitude.varus_rad, 0.0);
  ASSERT_EQ(film.frames.size(), 1U + test::n_moves_of_a_cell);
  // Exact: halves and quarters of mm are representable in single precision.
  EXPECT_EQ(film.frames.front(), (store::PoseCoordinates{0.5, -33.0, 0.0, rad_from_deg(0.5)}));
  EXPECT_EQ(film.frames.back(), (store::PoseCoordinates{0.0, -30.0, 0.0, 0.0}));
}

TEST(Film, ShowsAnyRequestedCell)
{
  const store::Trace trace = test::trace_beside(small_model());
  store::FilmOptions options;
  options.cell.flexion_deg = 20.0;
  EXPECT_EQ(store::film_of(trace, "t", options).frames.back(),
            (store::PoseCoordinates{2.5, -30.0, 0.0, rad_from_deg(5.0)}));
  options.cell.varus_deg = -1.0;
  EXPECT_EQ(store::film_of(trace, "t", options).frames.back(),
            (store::PoseCoordinates{2.5, -30.0, -1.0, rad_from_deg(5.0)}));
  // The row's search counts, not an earlier probe.
  options.cell = {0.0, 1.0};
  EXPECT_EQ(store::film_of(trace, "t", options).frames.size(), 1U + test::n_moves_of_a_cell);
}

TEST(Film, InContactLeavesTheTouchesOnly)
{
  store::FilmOptions options;
  options.contact_only = true;
  const store::Film film = store::film_of(test::trace_beside(small_model()), "t", options);
  ASSERT_EQ(film.frames.size(), static_cast<std::size_t>(test::n_touches_of_a_cell));
  EXPECT_EQ(film.frames.front()[1], -30.25);
  EXPECT_EQ(film.frames.back(), (store::PoseCoordinates{0.0, -30.0, 0.0, 0.0}));
}

TEST(Film, EverySoManyKeepsTheFirstAndTheLast)
{
  const store::Trace trace = test::trace_beside(small_model());
  const store::Film all = store::film_of(trace, "t", {});
  for (const int every : {2, 3, 8, 100}) {
    SCOPED_TRACE(every);
    store::FilmOptions options;
    options.every = every;
    const store::Film film = store::film_of(trace, "t", options);
    const std::size_t n_steps =
        (all.frames.size() - 1 + static_cast<std::size_t>(every) - 1) / static_cast<std::size_t>(every);
    EXPECT_EQ(film.frames.size(), n_steps + 1);
    EXPECT_EQ(film.frames.front(), all.frames.front());
    EXPECT_EQ(film.frames.back(), all.frames.back());
  }
}

TEST(Film, ASearchWithoutMovesIsItsSeed)
{
  store::FilmOptions options;
  options.cell = {10.0, 1.0};
  const store::Trace trace = test::trace_beside(small_model());
  EXPECT_EQ(store::film_of(trace, "t", options).frames.size(), 1U);
  options.contact_only = true;
  EXPECT_THAT(test::input_error([&] { store::film_of(trace, "t", options); }),
              test::refuses({.field = "/moves/in_contact", .found = "contact"}));
}

TEST(Film, WhatIsNotThereIsNamed)
{
  const store::Trace trace = test::trace_beside(small_model());
  store::FilmOptions options;
  options.cell.flexion_deg = 12.0;
  EXPECT_THAT(test::input_error([&] { store::film_of(trace, "t", options); }),
              test::refuses({"t", "attitude", "", "10"}));
}

TEST(Film, ItsLastPoseIsTheModelsOnBothSides)
{
  for (const std::string side : {"right", "left"}) {
    const store::MotionModel model = small_model(side);
    const store::Motion motion(model, "raw");
    store::FilmOptions options;
    options.cell = {20.0, -1.0};
    const store::Film film = store::film_of(test::trace_beside(model), "t", options);
    const store::JointPose shown = motion.joint_pose(film.attitude, film.frames.back());
    const store::JointPose wanted = motion.at({rad_from_deg(20), rad_from_deg(-1)});
    EXPECT_EQ(shown.status, store::PoseStatus::solved);
    // The poses are exact in single precision; the difference is the interpolation's rounding at a node.
    EXPECT_TRUE(shown.X_reference_moving.isApprox(wanted.X_reference_moving, 1e-12));
    EXPECT_TRUE(shown.X_world_moving.isApprox(wanted.X_world_moving, 1e-12));
    EXPECT_EQ(shown.attitude.varus_rad, rad_from_deg(-1));
  }
}

}  // namespace vrda::film_test
