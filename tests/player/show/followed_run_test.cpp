// Compares the cells filled in by a watch with the model that the pipeline makes from the same steps.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>
#include <thread>

#include "app/scenes.hpp"
#include "show/run_watch.hpp"
#include "solve/case_solver.hpp"
#include "store/journal.hpp"
#include "store/motion_model.hpp"
#include "store/sample_model.hpp"
#include "store/solved_cells.hpp"

namespace vrda::show::followed_run_test {

namespace fs = std::filesystem;

/// Every step of a sweep in solving order.
std::vector<StepRecord> steps_of(const job::Case& job_case)
{
  std::vector<StepRecord> steps;
  solve::CaseSolver solver(job_case, 1);
  solve::SweepHooks hooks;
  hooks.keep = [&](const StepRecord& record) { steps.push_back(record); };
  solve::sweep(
      solve::plan_of(job_case), [&](const solve::StepTask& task) { return solver(task); }, hooks, 1);
  return steps;
}

solve::SweepResult nothing_solved(const store::MotionModel& pending)
{
  solve::SweepResult result;
  result.spine_column.assign(pending.flexion_deg.size(), -1);
  for (std::int32_t i = 0; i < pending.status.rows(); ++i) {
    for (std::int32_t j = 0; j < pending.status.cols(); ++j) {
      result.cells.emplace_back();
      result.cells.back().key = {StepKind::row, i, j};
    }
  }
  return result;
}

void add(solve::SweepResult& result, const StepRecord& r, Eigen::Index n_varus)
{
  if (r.key.kind != StepKind::spine && r.key.kind != StepKind::row) return;
  result.cells[static_cast<std::size_t>(r.key.flexion * n_varus + r.key.varus)] = r;
  if (r.key.kind == StepKind::spine)
    result.spine_column[static_cast<std::size_t>(r.key.flexion)] = r.key.varus;
}

/// The cells of a watch, completed from `whole` with the data that only a full model has.
store::MotionModel cells_of(const RunWatch& watch, const store::MotionModel& whole)
{
  store::MotionModel model = watch.model();
  model.contacts = store::contact_rows(model, watch.cells());
  model.contact_paths = whole.contact_paths;
  model.equilibrium = whole.equilibrium;
  model.ligaments = whole.ligaments;
  return model;
}

void expect_followed_to_the_bit(const job::Case& job_case, const test::Scratch& scratch)
{
  const std::string output = (scratch.path() / "out.h5").string();
  store::write_motion_model(store::start_file_of(output), solve::pending_model_of(job_case));
  RunWatch watch(store::start_file_of(output));
  solve::SweepResult so_far = nothing_solved(watch.model());
  store::JournalWriter writer =
      store::JournalWriter::create(store::journal_of(output), solve::fingerprint_of(job_case));
  int n_cells = 0, n_probes = 0;
  for (const StepRecord& r : steps_of(job_case)) {
    writer.append(r);
    const RunUpdate news = watch.poll();
    ASSERT_EQ(news.steps.size(), 1u);
    (news.steps[0].kind == RunStepKind::cell ? n_cells : n_probes) += 1;
    add(so_far, r, watch.model().status.cols());
    const store::MotionModel whole = solve::motion_model_of(job_case, so_far);
    test::expect_equal(cells_of(watch, whole), whole);
    ASSERT_FALSE(testing::Test::HasFailure()) << n_cells << " cells, " << n_probes << " probes";
  }
  EXPECT_EQ(n_cells, watch.n_cells());
  EXPECT_GT(n_probes, 0);
}

// Cells are the pipelines to the bit after every step.
TEST(FollowedRun, EveryStep)
{
  const test::Scratch scratch;
  for (const char* side : {"right", "left"}) {
    SCOPED_TRACE(side);
    expect_followed_to_the_bit(job::load_case(test::small_knee_job(scratch, side).string()), scratch);
  }
}

TEST(FollowedRun, ScaledJob)
{
  const test::Scratch scratch;
  const job::Case job_case =
      job::load_case(test::small_knee_job(scratch, "left").string(), {"", {"scaling.factor=1.25"}});
  ASSERT_EQ(job_case.steps_scale, 1.25);
  expect_followed_to_the_bit(job_case, scratch);
}

/// Polls until the run has finished.
void follow_to_the_end(RunWatch& watch, int& n_moves, int& n_looks_with_part)
{
  for (int patience = 0; watch.phase() != RunPhase::finished; ++patience) {
    ASSERT_LT(patience, 30000) << "the run does not finish";
    for (const RunStep& step : watch.poll().steps) n_moves += step.kind == RunStepKind::move ? 1 : 0;
    n_looks_with_part += watch.n_done() > 0 && watch.n_done() < watch.n_cells() ? 1 : 0;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
}

// A run that is killed and goes on is followed to its result.
TEST(FollowedRun, KilledAndResumed)
{
  const test::Scratch scratch;
  const fs::path job = test::longer_knee_job(scratch);
  const std::string output = (scratch.path() / "out.h5").string();
  const std::vector<std::string> words{"run", job.string(), "-o", output, "--trace", "--threads", "1"};
  int n_moves = 0, n_looks_with_part = 0;
  test::Process killed(test::vrda(words));
  test::wait_for_bytes(killed, store::journal_of(output), 4000);
  RunWatch watch(store::start_file_of(output), true);
  killed.send(SIGKILL);
  killed.wait();
  test::Process going_on(test::vrda(words));
  follow_to_the_end(watch, n_moves, n_looks_with_part);
  EXPECT_EQ(going_on.wait().exit_code, 0);
  EXPECT_GT(n_looks_with_part, 0);
  EXPECT_GT(n_moves, 0);
  test::expect_equal(watch.model(), store::read_motion_model(output));
}

// Shards that are merged are followed to their result.
TEST(FollowedRun, Shards)
{
  const test::Scratch scratch;
  const std::string job = test::small_knee_job(scratch, "right").string();
  const std::string output = (scratch.path() / "out.h5").string();
  ASSERT_EQ(test::run_vrda({"run", job, "-o", output, "--spine"}).exit_code, 0);
  RunWatch watch(store::start_file_of(output));
  watch.poll();
  EXPECT_EQ(watch.n_done(), 7);
  for (const char* shard : {"2/2", "1/2"}) {
    ASSERT_EQ(test::run_vrda({"run", job, "-o", output, "--shard", shard}).exit_code, 0);
    const int before = watch.n_done();
    watch.poll();
    EXPECT_GT(watch.n_done(), before);
  }
  EXPECT_EQ(watch.n_done(), 35);
  EXPECT_EQ(watch.phase(), RunPhase::running);
  ASSERT_EQ(test::run_vrda({"merge", "-o", output}).exit_code, 0);
  watch.poll();
  EXPECT_EQ(watch.phase(), RunPhase::finished);
}

}  // namespace vrda::show::followed_run_test
