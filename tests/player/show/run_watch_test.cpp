// The files of a run at every stage that a poll may find, written by the test.
#include "show/run_watch.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "core/text.hpp"
#include "core/units.hpp"
#include "store/journal.hpp"
#include "store/motion_model.hpp"
#include "support/models.hpp"
#include "support/scratch.hpp"

namespace vrda::show::run_watch_test {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

const std::string key(64, 'a');
const std::string other_key(64, 'b');

StepRecord step(StepKind kind, int flexion, int varus, StepStatus status = StepStatus::stable)
{
  StepRecord r;
  r.key = {kind, flexion, varus};
  r.status = status;
  r.pose = {{1.0 * flexion, -20.0 / 3.0, 0.1 * varus}, 0.01 * flexion};
  r.varus_rad = rad_from_deg(varus - 1.0);
  r.iterations = 10 + varus;
  r.contacts.push_back({{1, 2, 3}, {0, -1, 0}, 0.01, 4, 5, 1});
  return r;
}

SearchTrace search(StepKind kind, int flexion, int varus, int n_moves)
{
  SearchTrace trace;
  trace.key = {kind, flexion, varus};
  trace.status = StepStatus::stable;
  for (int m = 0; m < n_moves; ++m) {
    SearchMove move;
    move.iteration = m;
    move.pose.translation_mm.y() = -m;
    move.in_contact = m % 2 == 1;
    trace.moves.push_back(move);
  }
  return trace;
}

/// Flexion 0, 10, 20 by varus -1, 0, 1.
store::MotionModel plan(double last_flexion_deg = 20)
{
  test::ModelPlan requested;
  requested.flexion_deg = {0, 10, last_flexion_deg};
  requested.varus_deg = {-1, 0, 1};
  store::MotionModel model = test::model_of(requested);
  test::add_bodies(model);
  model.job.resolved = "flexion to " + std::to_string(last_flexion_deg);
  return model;
}

class Watch : public testing::Test {
 protected:
  Watch() { write_start(plan()); }

  void write_start(const store::MotionModel& model)
  {
    store::write_motion_model(start_, store::with_pending_cells(model));
  }
  store::JournalWriter journal(const std::string& its_key = key)
  {
    return store::JournalWriter::create(store::journal_of(output_), its_key);
  }

  test::Scratch scratch_;
  std::string output_ = (scratch_.path() / "knee.h5").string();
  std::string start_ = store::start_file_of(output_);
};

int n_stable(const RunWatch& watch)
{
  return static_cast<int>((watch.model().status == 0).count());
}

TEST_F(Watch, CellsFillIn)
{
  RunWatch watch(start_);
  EXPECT_EQ(watch.phase(), RunPhase::waiting);
  EXPECT_THAT(watch.poll().steps, IsEmpty());
  EXPECT_EQ(watch.n_cells(), 9);
  store::JournalWriter writer = journal();
  writer.append(step(StepKind::spine_probe, 0, 1));
  writer.append(step(StepKind::spine, 0, 1));
  RunUpdate news = watch.poll();
  ASSERT_EQ(news.steps.size(), 2u);
  EXPECT_EQ(news.steps[0].kind, RunStepKind::probe);
  EXPECT_EQ(news.steps[1].kind, RunStepKind::cell);
  EXPECT_EQ(watch.phase(), RunPhase::running);
  EXPECT_EQ(watch.n_done(), 1);
  EXPECT_EQ(watch.n_steps(), 2);
  EXPECT_EQ(watch.model().is_spine(0, 1), 1);

  writer.append(step(StepKind::row, 2, 0, StepStatus::no_contact));
  news = watch.poll();
  ASSERT_EQ(news.steps.size(), 1u);
  EXPECT_EQ(news.steps[0].status, StepStatus::no_contact);
  EXPECT_EQ(watch.model().status(2, 0), static_cast<std::int8_t>(StepStatus::no_contact));
  EXPECT_EQ(watch.model().iterations(2, 0), 10);
  EXPECT_TRUE(std::isnan(watch.model().tx_mm(2, 0)));
  EXPECT_EQ(n_stable(watch), 1);
  EXPECT_EQ(watch.model().ty_mm(0, 1), -20.0 / 3.0);
  EXPECT_THAT(watch.poll().steps, IsEmpty());
}

TEST_F(Watch, ShardsAndSpine)
{
  RunWatch watch(start_);
  store::JournalWriter spine = store::JournalWriter::create(store::spine_journal_of(output_), key);
  spine.append(step(StepKind::spine, 0, 1));
  EXPECT_EQ(watch.poll().steps.size(), 1u);
  // A shard journal that appears late, and a step contained in two of them.
  store::JournalWriter first = store::JournalWriter::create(store::shard_journal_of(output_, {1, 2}), key);
  first.append(step(StepKind::row, 0, 0));
  store::JournalWriter second = store::JournalWriter::create(store::shard_journal_of(output_, {2, 2}), key);
  second.append(step(StepKind::row, 1, 0));
  second.append(step(StepKind::row, 0, 0));
  const RunUpdate news = watch.poll();
  EXPECT_FALSE(news.is_restarted);
  EXPECT_EQ(news.steps.size(), 2u);
  EXPECT_EQ(watch.n_done(), 3);
}

TEST_F(Watch, Restart)
{
  RunWatch watch(start_);
  {
    store::JournalWriter writer = journal();
    for (int j = 0; j < 3; ++j) writer.append(step(StepKind::row, 1, j));
  }
  watch.poll();
  EXPECT_EQ(watch.n_done(), 3);
  journal().append(step(StepKind::row, 0, 0));
  RunUpdate news = watch.poll();
  EXPECT_TRUE(news.is_restarted);
  EXPECT_EQ(news.steps.size(), 1u);
  EXPECT_EQ(watch.n_done(), 1);
  EXPECT_EQ(watch.model().status(1, 0), -1);
  EXPECT_TRUE(std::isnan(watch.model().tx_mm(1, 0)));

  // Another job with the same output: its journal exists before its start file.
  store::JournalWriter writer = journal(other_key);
  writer.append(step(StepKind::row, 0, 2));
  EXPECT_TRUE(watch.poll().is_restarted);
  write_start(plan(40));
  news = watch.poll();
  EXPECT_TRUE(news.is_restarted);
  EXPECT_EQ(watch.model().flexion_deg.back(), 40);
  EXPECT_EQ(news.steps.size(), 1u);
  EXPECT_EQ(watch.n_done(), 1);
}

TEST_F(Watch, LatestJournal)
{
  store::JournalWriter::create(store::shard_journal_of(output_, {1, 2}), other_key)
      .append(step(StepKind::row, 0, 0));
  fs::last_write_time(store::shard_journal_of(output_, {1, 2}),
                      fs::file_time_type::clock::now() - std::chrono::hours(1));
  RunWatch watch(start_);
  EXPECT_EQ(watch.poll().steps.size(), 1u);
  journal().append(step(StepKind::row, 1, 1));
  const RunUpdate news = watch.poll();
  EXPECT_TRUE(news.is_restarted);
  ASSERT_EQ(news.steps.size(), 1u);
  EXPECT_EQ(news.steps[0].key.flexion, 1);
  ASSERT_EQ(news.remarks.size(), 1u);
  EXPECT_THAT(news.remarks[0], HasSubstr("shard-1-of-2.journal: "));
}

TEST_F(Watch, TornEnd)
{
  RunWatch watch(start_);
  {
    store::JournalWriter writer = journal();
    writer.append(step(StepKind::row, 0, 0));
    writer.append(step(StepKind::row, 0, 1));
  }
  const std::string whole = test::read_bytes(store::journal_of(output_));
  scratch_.write("knee.h5.journal", whole.substr(0, whole.size() - 5));
  EXPECT_EQ(watch.poll().steps.size(), 1u);
  EXPECT_EQ(watch.poll().steps.size(), 0u);
  scratch_.write("knee.h5.journal", whole);
  EXPECT_EQ(watch.poll().steps.size(), 1u);
  EXPECT_EQ(watch.n_done(), 2);
}

TEST_F(Watch, ForeignRecords)
{
  store::JournalWriter writer = journal();
  writer.append(step(StepKind::row, 3, 0));
  writer.append(step(StepKind::row, 0, 3));
  writer.append(step(StepKind::spine_probe, 0, -1));
  writer.append(step(StepKind::free_spine, 0, 7));
  writer.append(step(StepKind::row, 0, 0));
  RunWatch watch(start_);
  const RunUpdate news = watch.poll();
  EXPECT_EQ(news.steps.size(), 2u);
  EXPECT_EQ(watch.n_done(), 1);
  EXPECT_THAT(news.remarks, ElementsAre(HasSubstr("knee.h5.journal: record: ")));
}

// Moves precede their step whichever file is read first.
TEST_F(Watch, Moves)
{
  RunWatch watch(start_, true);
  store::JournalWriter steps = journal();
  core::FrameWriter moves = store::create_trace_journal(store::trace_journal_of(output_), key);
  moves.append(core::bytes_of_value(search(StepKind::spine_probe, 0, 1, 4)));
  EXPECT_THAT(watch.poll().steps, IsEmpty());
  steps.append(step(StepKind::spine_probe, 0, 1));
  steps.append(step(StepKind::spine, 0, 1));
  RunUpdate news = watch.poll();
  ASSERT_EQ(news.steps.size(), 6u);
  for (int m = 0; m < 4; ++m) {
    EXPECT_EQ(news.steps[static_cast<std::size_t>(m)].kind, RunStepKind::move);
    EXPECT_EQ(news.steps[static_cast<std::size_t>(m)].in_contact, m % 2 == 1);
    EXPECT_EQ(news.steps[static_cast<std::size_t>(m)].pose.translation_mm.y(), -m);
  }
  EXPECT_EQ(news.steps[4].kind, RunStepKind::probe);
  EXPECT_EQ(news.steps[5].kind, RunStepKind::cell);
  steps.append(step(StepKind::row, 0, 2));
  EXPECT_EQ(watch.poll().steps.size(), 1u);
  moves.append(core::bytes_of_value(search(StepKind::row, 0, 2, 3)));
  EXPECT_EQ(watch.poll().steps.size(), 3u);
}

TEST_F(Watch, NoMoves)
{
  RunWatch watch(start_, true);
  EXPECT_THAT(watch.poll().remarks, IsEmpty());
  store::JournalWriter steps = journal();
  steps.append(step(StepKind::row, 0, 0));
  watch.poll();
  EXPECT_THAT(watch.poll().remarks, ElementsAre(HasSubstr("--trace")));
  EXPECT_THAT(watch.poll().remarks, IsEmpty());
}

TEST_F(Watch, LengthsAreTheSubjects)
{
  store::MotionModel model = plan();
  model.job.scaling.emplace();
  model.job.scaling->factor = {2, 2, 2};
  model.job.scaling->keeps_steps = true;
  write_start(model);
  journal().append(step(StepKind::row, 0, 1));
  RunWatch watch(start_);
  const RunUpdate news = watch.poll();
  ASSERT_EQ(news.steps.size(), 1u);
  EXPECT_EQ(news.steps[0].pose.translation_mm.y(), 2.0 * (-20.0 / 3.0));
  EXPECT_EQ(news.steps[0].contacts[0].point_solver_mm.x(), 2.0);
  EXPECT_EQ(watch.model().ty_mm(0, 1), 2.0 * (-20.0 / 3.0));
}

TEST_F(Watch, OwnResult)
{
  // The result of an earlier run of the job is older than the start file.
  store::write_motion_model(output_, plan());
  fs::last_write_time(output_, fs::last_write_time(start_) - std::chrono::seconds(1));
  RunWatch watch(start_);
  watch.poll();
  EXPECT_EQ(watch.phase(), RunPhase::waiting);
  journal().append(step(StepKind::row, 0, 1));
  watch.poll();
  EXPECT_EQ(watch.phase(), RunPhase::running);
  store::write_motion_model(output_, plan(40));
  EXPECT_THAT(watch.poll().remarks, ElementsAre(HasSubstr("knee.h5: ")));
  EXPECT_EQ(watch.phase(), RunPhase::running);
  store::write_motion_model(output_, plan());
  fs::remove(store::journal_of(output_));
  fs::remove(start_);
  watch.poll();
  EXPECT_EQ(watch.phase(), RunPhase::finished);
  EXPECT_EQ(watch.n_done(), 9);
  EXPECT_EQ(n_stable(watch), 9);
  EXPECT_THAT(watch.poll().steps, IsEmpty());
}

// Another job that began and ended between two looks is the one followed.
TEST_F(Watch, NextJob)
{
  RunWatch watch(start_);
  journal().append(step(StepKind::row, 0, 1));
  watch.poll();
  fs::remove(store::journal_of(output_));
  fs::remove(start_);
  const store::MotionModel other = plan(40);
  store::write_motion_model(output_, other);
  // Older than the start file: the result of an earlier run.
  const fs::file_time_type written = fs::last_write_time(output_);
  fs::last_write_time(output_, written - std::chrono::hours(1));
  EXPECT_THAT(watch.poll().remarks, ElementsAre(HasSubstr("knee.h5: ")));
  EXPECT_EQ(watch.phase(), RunPhase::running);
  fs::last_write_time(output_, written);
  const RunUpdate news = watch.poll();
  EXPECT_TRUE(news.is_restarted);
  EXPECT_THAT(news.steps, IsEmpty());
  EXPECT_THAT(news.remarks, IsEmpty());
  EXPECT_EQ(watch.phase(), RunPhase::finished);
  EXPECT_EQ(watch.model().job.resolved, other.job.resolved);
  EXPECT_EQ(watch.n_done(), 9);
}

constexpr std::chrono::milliseconds pause{1};

class ThreadedWatch : public Watch {
 protected:
  /// Collects arrivals until `is_enough`, for at most ten seconds.
  template <typename IsEnough>
  static RunUpdate taken_until(WatchThread& thread, const IsEnough& is_enough)
  {
    RunUpdate all;
    for (int patience = 0; patience < 10000; ++patience) {
      RunUpdate more = thread.take();
      all.is_restarted = all.is_restarted || more.is_restarted;
      if (more.model) all.model = more.model;
      all.steps.insert(all.steps.end(), more.steps.begin(), more.steps.end());
      all.phase = more.phase;
      all.n_done = more.n_done;
      if (is_enough(all)) return all;
      std::this_thread::sleep_for(pause);
    }
    ADD_FAILURE() << "timeout";
    return all;
  }
};

// Every step arrives once and the result with its end.
TEST_F(ThreadedWatch, Arrivals)
{
  store::JournalWriter writer = journal();
  WatchThread thread(RunWatch(start_), pause);
  for (int j = 0; j < 3; ++j) writer.append(step(StepKind::row, 1, j));
  const RunUpdate steps = taken_until(thread, [](const RunUpdate& a) { return a.steps.size() >= 3; });
  EXPECT_EQ(steps.steps.size(), 3u);
  EXPECT_EQ(steps.n_done, 3);
  EXPECT_EQ(steps.phase, RunPhase::running);
  EXPECT_FALSE(steps.model);
  store::write_motion_model(output_, plan());
  const RunUpdate end = taken_until(thread, [](const RunUpdate& a) { return a.model != nullptr; });
  EXPECT_EQ(end.phase, RunPhase::finished);
  EXPECT_TRUE((end.model->status == 0).all());
  EXPECT_TRUE(end.steps.empty());
}

TEST_F(ThreadedWatch, Failure)
{
  WatchThread thread(RunWatch(start_), pause);
  scratch_.write("knee.h5.start.h5", "no start file any more");
  EXPECT_THROW(taken_until(thread, [](const RunUpdate&) { return false; }), InputError);
}

}  // namespace vrda::show::run_watch_test
