#include "store/trace.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <hdf5.h>
#include <unistd.h>

#include <filesystem>
#include <functional>
#include <limits>
#include <set>
#include <sstream>

#include "core/text.hpp"
#include "model/step_record.hpp"
#include "store/motion_model.hpp"
#include "store/registry.hpp"
#include "store/sample_model.hpp"
#include "support/damaged_models.hpp"
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

TEST(TraceFile, IsNoMotionModelNorTheOtherWayRound)
{
  const test::Scratch scratch;
  const std::string trace = scratch.path() / "knee.trace.h5", model = scratch.path() / "knee.h5";
  store::write_trace(trace, sample_trace());
  store::write_motion_model(model, test::sample_model());
  EXPECT_EQ(input_error([&] { store::read_trace(model); }).field, "/@format");
  EXPECT_EQ(input_error([&] { store::read_motion_model(trace); }).field, "/@format");
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

}  // namespace vrda::trace_test
