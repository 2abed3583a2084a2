#include <gmock/gmock.h>
#include <hdf5.h>
#include <unistd.h>

#include <functional>

#include "core/text.hpp"
#include "core/units.hpp"
#include "model/step_record.hpp"
#include "store/motion.hpp"
#include "store/motion_model.hpp"
#include "store/registry.hpp"
#include "store/sample_model.hpp"
#include "store/trace.hpp"
#include "support/damaged_models.hpp"
#include "support/models.hpp"
#include "support/real_knees.hpp"
#include "support/refusal.hpp"
#include "support/scratch.hpp"
#include "support/traces.hpp"

namespace vrda::trace_test {

using test::input_error;
using testing::ElementsAre;
using testing::HasSubstr;

// The sample: 4 x 3 cells, one of them not solved, and a probe.
constexpr std::size_t n_searches = 13, n_moves = 11 * test::n_moves_of_a_cell;

store::Trace sample_trace()
{
  return test::trace_beside(test::sample_model());
}

TEST(TraceFile, GivesBackWhatWasWritten)
{
  const test::Scratch scratch;
  const std::string path = scratch.path() / "knee.trace.h5";
  // Several compressed chunks, the smallest size, and no moves.
  store::MotionModel nothing = test::sample_model({1, 1, false, false, false});
  nothing.status(0, 0) = static_cast<std::int8_t>(StepStatus::no_contact);
  for (const store::Trace& trace : {test::trace_beside(test::sample_model({91, 21, true, true, true})),
                                    sample_trace(), test::trace_beside(nothing)}) {
    store::write_trace(path, trace);
    EXPECT_TRUE(store::validate_hdf5(path).empty());
    test::expect_equal(store::read_trace(path), trace);
  }
}

TEST(TraceFile, IsNamedAfterItsModel)
{
  EXPECT_EQ(store::trace_name("results/knee.h5"), "results/knee.trace.h5");
  EXPECT_EQ(store::trace_name("knee"), "knee.trace.h5");
  EXPECT_EQ(store::trace_name(".h5"), ".h5.trace.h5");
}

TEST(TraceFile, AMissingDatasetOrOneOfAnotherTypeIsNamed)
{
  const test::Scratch scratch;
  const std::string path = scratch.path() / "knee.trace.h5";
  for (const bool replaced : {false, true}) {
    store::write_trace(path, sample_trace());
    test::change(path, [&](hid_t file) {
      if (replaced) {
        test::replace(file, {"/moves/theta", {n_moves}});
      } else {
        test::remove(file, "/moves/theta");
      }
    });
    EXPECT_THAT(input_error([&] { store::read_trace(path); }),
                test::refuses({.field = "/moves/theta", .found = replaced ? "float64" : "nothing"}));
  }
}

struct Row {
  const char* where;
  const char* found;
  const char* wanted;
  std::function<void(store::Trace&)> damage;
};

TEST(TraceFile, ValuesThatBreakARuleAreNamed)
{
  const test::Scratch scratch;
  const std::string path = scratch.path() / "knee.trace.h5";
  for (const Row& row : {
           Row{"/@side", "\"\"", "right", [](store::Trace& t) { t.side = ""; }},
           Row{"/@approach_step_mm", "-1", "positive", [](store::Trace& t) { t.approach_step_mm = -1; }},
           Row{"/searches/node", "3 at entry 1", "spine_probe spine row",
               [](store::Trace& t) { t.searches.node[1] = 3; }},
           Row{"/searches/status", "9 at entry 2", "stable",
               [](store::Trace& t) { t.searches.status[2] = 9; }},
           Row{"/searches/move_start", "87 at entry 13", "number of entries",
               [](store::Trace& t) {
                 t.searches.move_start.back() = 87;
                 t.searches.move_start[12] = 88;
               }},
           Row{"/moves/iteration", "1 at entry 6", "non-decreasing",
               [](store::Trace& t) { t.moves.iteration[6] = 1; }},
           Row{"/moves/kind", "7 at entry 0", "translate iterate trial",
               [](store::Trace& t) { t.moves.kind[0] = 7; }},
           Row{"/moves/collides", "1 at entry 0", "bisection",
               [](store::Trace& t) { t.moves.collides[0] = 1; }},
           Row{"/moves/in_contact", "1 at entry 6", "approach",
               [](store::Trace& t) { t.moves.in_contact[6] = 1; }},
           Row{"/moves/is_cycle", "1 at entry 0", "in contact",
               [](store::Trace& t) { t.moves.is_cycle[0] = 1; }},
           Row{"/moves/contact_start", "not in contact", "in contact",
               [](store::Trace& t) { t.moves.in_contact[1] = 0; }},
       }) {
    SCOPED_TRACE(testing::Message() << row.where << " " << row.found);
    store::Trace trace = sample_trace();
    row.damage(trace);
    store::write_trace(path, trace);
    const std::vector<store::Finding> findings = store::validate_hdf5(path);
    ASSERT_EQ(findings.size(), 1u);
    test::expect_first(findings, row.where, row.found, row.wanted);
    EXPECT_EQ(input_error([&] { store::read_trace(path); }).field, row.where);
  }
}

TEST(TraceFile, MustMatchItsModel)
{
  const store::MotionModel model = test::sample_model();
  EXPECT_NO_THROW(store::require_trace_matches_model(sample_trace(), "a.trace.h5", model, "a.h5"));
  for (const Row& row : {
           Row{"/job", "another job", "a.h5", [](store::Trace& t) { t.job.resolved += "x"; }},
           Row{"/job", "cccccccccccccccccccccccccccccccccccccccccccccccccccccccccccccccc", "a.h5",
               [](store::Trace& t) { t.job.inputs[1].sha256[0] = 'f'; }},
           Row{"/job", "another job", "", [](store::Trace& t) { t.side = "left"; }},
           Row{"/searches/flexion", "at entry 5", "",
               [](store::Trace& t) { t.searches.flexion_deg[5] = 0.5; }},
           Row{"/searches/status", "3 at entry 0", "0", [](store::Trace& t) { t.searches.status[0] = 3; }},
           Row{"/searches/node", "a cell without a search", "",
               [](store::Trace& t) { t.searches.node[4] = static_cast<std::int8_t>(StepKind::spine_probe); }},
           Row{"/moves/translation", "final pose at entry 0", "",
               [](store::Trace& t) { t.moves.translation_mm(7, 1) += 1e-3F; }},
           Row{"/contacts/triangle_moving", "100000", "",
               [](store::Trace& t) { t.contacts.triangle_moving[0] = 100000; }},
       }) {
    SCOPED_TRACE(testing::Message() << row.where << " " << row.found);
    store::Trace trace = sample_trace();
    row.damage(trace);
    EXPECT_THAT(input_error([&] { store::require_trace_matches_model(trace, "a.trace.h5", model, "a.h5"); }),
                test::refuses({"a.trace.h5", row.where, row.found, {row.wanted, "a.h5"}}));
  }
}

TEST(Trace, MovesInContactAreSomeOfTheMovesInTheirOrder)
{
  const store::Trace trace = sample_trace();
  const store::MoveRange range = store::moves_of(trace, 1);
  EXPECT_EQ(range.end - range.first, static_cast<std::size_t>(test::n_moves_of_a_cell));
  EXPECT_THAT(store::moves_in_contact(trace, 1),
              ElementsAre(range.first + 1, range.first + 5, range.first + 7));
}

TEST(Trace, SearchesAreFoundByTheAttitudesOfTheGrid)
{
  const store::Trace trace = sample_trace();
  EXPECT_EQ(store::searches_at(trace, "t", {}).size(), n_searches);
  EXPECT_THAT(store::searches_at(trace, "t", {0.0, {}}), ElementsAre(0, 1, 2, 3));
  EXPECT_THAT(store::searches_at(trace, "t", {0.0, 1.0}), ElementsAre(2, 3));  // a probe and the row's
  EXPECT_THAT(store::searches_at(trace, "t", {{}, 1e-9}), ElementsAre(1, 5, 8, 11));
  EXPECT_THAT(input_error([&] {
                store::searches_at(trace, "t", {2.4, 7.0});
              }),
              test::refuses({"t", "attitude", {"2.4", "7"}, {"2", "1"}}));
}

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

}  // namespace vrda::trace_test
