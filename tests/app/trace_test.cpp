// `vrda run --trace` and `vrda trace`.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "app/scenes.hpp"
#include "model/step_record.hpp"
#include "store/journal.hpp"
#include "store/motion_model.hpp"
#include "store/trace.hpp"
#include "support/messages.hpp"

namespace vrda::trace_test {

namespace fs = std::filesystem;
using testing::IsEmpty;

/// A traced run of a small joint.
struct Traced {
  explicit Traced(const std::string& job, const std::vector<std::string>& more = {})
      : file(scratch.path() / "out.h5")
  {
    const fs::path job_file =
        job == "knee" ? test::small_knee_job(scratch, "right") : test::small_job(scratch);
    std::vector<std::string> words{"run", job_file.string(), "-o", file.string(), "--trace"};
    words.insert(words.end(), more.begin(), more.end());
    ended = test::run_vrda(words);
  }
  std::string trace_file() const { return store::trace_name(file.string()); }

  test::Scratch scratch;
  fs::path file;
  test::Ended ended;
};

TEST(Trace, IsWrittenNextToTheModelAndNoOtherFileRemains)
{
  const Traced run("knee");
  ASSERT_EQ(run.ended.exit_code, 0) << run.ended.err;
  EXPECT_THAT(run.ended.err, test::reports("", run.trace_file()));
  EXPECT_FALSE(fs::exists(run.file.string() + ".trace.journal"));
  EXPECT_THAT(store::validate_hdf5(run.trace_file()), IsEmpty());
  EXPECT_EQ(test::run_vrda({"validate", run.trace_file()}).exit_code, 0);
  EXPECT_NO_THROW(store::require_trace_matches_model(store::read_trace(run.trace_file()), run.trace_file(),
                                                     store::read_motion_model(run.file.string()), ""));
}

TEST(Trace, TracingChangesNoByteOfTheModel)
{
  const Traced run("knee");
  const std::string plain = (run.scratch.path() / "plain.h5").string();
  ASSERT_EQ(
      test::run_vrda({"run", test::small_knee_job(run.scratch, "right").string(), "-o", plain}).exit_code, 0);
  EXPECT_EQ(test::sha256_of_file(plain), test::sha256_of_file(run.file));
  EXPECT_FALSE(fs::exists(store::trace_name(plain)));
}

TEST(Trace, EachIterationTouchesOnceAndTouchesAreSomeOfTheMoves)
{
  const Traced run("knee");
  const store::Trace trace = store::read_trace(run.trace_file());
  const store::MotionModel model = store::read_motion_model(run.file.string());
  std::int64_t n_iterations = 0;
  std::set<int> nodes;
  for (std::size_t s = 0; s < trace.searches.node.size(); ++s) {
    nodes.insert(trace.searches.node[s]);
    const store::MoveRange range = store::moves_of(trace, s);
    const std::vector<std::size_t> touches = store::moves_in_contact(trace, s);
    ASSERT_EQ(trace.searches.status[s], 0);
    EXPECT_LT(touches.size(), range.end - range.first);
    EXPECT_EQ(touches.back(), range.end - 1);
    for (std::size_t k = 0; k < touches.size(); ++k) {
      EXPECT_EQ(trace.moves.iteration[touches[k]], static_cast<int>(k) + 1);
      EXPECT_GT(trace.moves.contact_start[touches[k] + 1], trace.moves.contact_start[touches[k]]);
    }
    const bool is_probe = trace.searches.node[s] == static_cast<std::int8_t>(StepKind::spine_probe);
    n_iterations += is_probe ? 0 : static_cast<std::int64_t>(touches.size());
  }
  EXPECT_EQ(nodes, (std::set<int>{0, 1, 2})) << "rejected probes are included and marked";
  EXPECT_EQ(n_iterations, model.iterations.cast<std::int64_t>().sum());
}

TEST(Trace, ALeftJointMirrorsTheRightOne)
{
  const Traced right("knee");
  const std::string left = (right.scratch.path() / "left.h5").string();
  ASSERT_EQ(
      test::run_vrda({"run", test::small_knee_job(right.scratch, "left").string(), "-o", left, "--trace"})
          .exit_code,
      0);
  const store::Trace r = store::read_trace(right.trace_file()),
                     l = store::read_trace(store::trace_name(left));
  EXPECT_EQ(l.side, "left");
  EXPECT_EQ(r.moves.kind, l.moves.kind);
  EXPECT_EQ(r.moves.theta_deg, l.moves.theta_deg);
  EXPECT_EQ(r.moves.translation_mm.col(1), l.moves.translation_mm.col(1));
  EXPECT_EQ(r.moves.translation_mm.col(2), -l.moves.translation_mm.col(2));
  EXPECT_EQ(r.contacts.normal.col(2), -l.contacts.normal.col(2));
}

TEST(Trace, StepsSolvedWithoutTraceAreOneMessageAndFreshIsTheWay)
{
  const test::Scratch scratch;
  const std::string job = test::longer_knee_job(scratch).string(),
                    output = (scratch.path() / "knee.h5").string();
  {
    test::Process process(test::vrda({"run", job, "-o", output}));
    test::wait_for_bytes(process, output + ".journal", 6000);
    process.send(SIGINT);
    ASSERT_EQ(process.wait().exit_code, 4);
  }
  const std::size_t n_known = store::read_journal(output + ".journal").records.size();
  const test::Ended refused = test::run_vrda({"run", job, "-o", output, "--trace", "--quiet"});
  EXPECT_EQ(test::n_lines(refused.err), 1) << refused.err;
  EXPECT_THAT(refused, test::refuses({output + ".trace.journal", "", "trace", "--fresh"}));
  EXPECT_EQ(store::read_journal(output + ".journal").records.size(), n_known) << "nothing of the run is lost";
  EXPECT_EQ(test::run_vrda({"run", job, "-o", output, "--trace", "--fresh"}).exit_code, 0);
  EXPECT_THAT(store::validate_hdf5(store::trace_name(output)), IsEmpty());
}

TEST(Trace, ADamagedJournalOfTracesIsSaidAndTheRunCanGoOnWithoutIt)
{
  const test::Scratch scratch;
  const std::string job = test::longer_knee_job(scratch).string(),
                    output = (scratch.path() / "knee.h5").string();
  {
    test::Process process(test::vrda({"run", job, "-o", output, "--trace"}));
    test::wait_for_bytes(process, output + ".journal", 6000);
    process.send(SIGKILL);
    process.wait();
  }
  std::string bytes = test::read_bytes(output + ".trace.journal");
  ASSERT_GT(bytes.size(), 4000U);
  bytes[2000] = static_cast<char>(bytes[2000] ^ 0x10);
  scratch.write("knee.h5.trace.journal", bytes);
  const test::Ended refused = test::run_vrda({"run", job, "-o", output, "--trace"});
  EXPECT_THAT(refused, test::refuses({output + ".trace.journal", "", "trace", "--fresh"}));
  EXPECT_EQ(test::run_vrda({"run", job, "-o", output}).exit_code, 0);
  EXPECT_FALSE(fs::exists(output + ".trace.journal"));
}

TEST(Trace, ReplacesNoFileThatIsNotATrace)
{
  const test::Scratch scratch;
  const std::string job = test::small_job(scratch).string(), output = (scratch.path() / "small.h5").string();
  scratch.write("small.trace.h5", "mine");
  const test::Ended refused = test::run_vrda({"run", job, "-o", output, "--trace"});
  EXPECT_THAT(refused, test::refuses({"small.trace.h5", "output", "HDF5"}));
  EXPECT_EQ(test::read_bytes(scratch.path() / "small.trace.h5"), "mine");
}

TEST(TraceCommand, CountsTheMovesOfEachSearch)
{
  const Traced run("knee");
  const store::Trace trace = store::read_trace(run.trace_file());
  const auto json = test::json_of({"trace", run.trace_file()});
  EXPECT_EQ(json.at("searches").size(), trace.searches.node.size());
  EXPECT_EQ(json.at("all").at("moves"), trace.moves.kind.size());
  EXPECT_EQ(json.at("job_key"), trace.job_key);
  int n = 0;
  for (const auto& entry : json.at("all").at("by_kind").items()) n += entry.value().get<int>();
  EXPECT_EQ(n, json.at("all").at("moves"));
  const auto& first = json.at("searches").at(0);
  EXPECT_EQ(first.at("flexion_deg"), 0);
  EXPECT_EQ(first.at("varus_deg"), -2);
  EXPECT_EQ(first.at("status"), "stable");
  EXPECT_EQ(first.at("iterations"), first.at("in_contact"));
  const test::Ended text = test::run_vrda({"trace", run.trace_file()});
  EXPECT_EQ(text.exit_code, 0);
  EXPECT_THAT(text.out, test::reports("", {std::to_string(trace.searches.node.size()),
                                           std::to_string(trace.moves.kind.size())}));
  EXPECT_THAT(text.out, test::reports("", "spine_probe"));
}

std::vector<std::string> lines_of(const std::string& text)
{
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

TEST(TraceCommand, CsvHasALineAMoveAndContactOnlyLeavesSomeOfThem)
{
  const Traced run("knee");
  const store::Trace trace = store::read_trace(run.trace_file());
  const std::vector<std::string> all = lines_of(test::run_vrda({"trace", run.trace_file(), "--csv"}).out);
  ASSERT_EQ(all.size(), 1 + trace.moves.kind.size());
  EXPECT_THAT(all[0], testing::StartsWith("flexion_deg,varus_deg,node,iteration,kind,x_mm"));
  const std::vector<std::string> cell = {"trace", run.trace_file(), "--csv", "--flexion",
                                         "4",     "--varus",        "-2"};
  std::vector<std::string> cell_touches = cell;
  cell_touches.emplace_back("--contact-only");
  const std::vector<std::string> moves = lines_of(test::run_vrda(cell).out),
                                 touches = lines_of(test::run_vrda(cell_touches).out);
  EXPECT_THAT(moves[1], testing::StartsWith("4,-2,"));
  EXPECT_GT(moves.size(), touches.size());
  EXPECT_GT(touches.size(), 1U);
  EXPECT_TRUE(std::includes(moves.begin(), moves.end(), touches.begin(), touches.end(),
                            [&](const std::string& a, const std::string& b) {
                              const auto at = [&](const std::string& line) {
                                return std::find(moves.begin(), moves.end(), line);
                              };
                              return at(a) < at(b);
                            }));
}

TEST(TraceCommand, UnsolvedSearchesAreThereToo)
{
  const Traced run("small", {"--set", "solver.search.max_steps=2", "--set", "limits.unsolved_fraction=1"});
  ASSERT_EQ(run.ended.exit_code, 0) << run.ended.err;
  const auto json = test::json_of({"trace", run.trace_file()});
  const auto n_limits =
      std::count_if(json.at("searches").begin(), json.at("searches").end(), [](const auto& s) {
        return s.at("status") == "iteration_limit" && s.at("iterations") == 2 && s.at("in_contact") == 2;
      });
  EXPECT_GT(n_limits, 0);
}

}  // namespace vrda::trace_test
