#include "follow/run_watch.hpp"

#include <gtest/gtest.h>

#include <filesystem>

#include "core/error.hpp"
#include "journal/journal.hpp"
#include "journal/run_files.hpp"
#include "motion/support/models.hpp"
#include "store/motion_model_file.hpp"
#include "support/scratch.hpp"

namespace vrda::watch_thread_test {

constexpr std::chrono::milliseconds pause{1};

class ThreadedWatch : public testing::Test {
 protected:
  ThreadedWatch()
  {
    test::ModelPlan plan;
    plan.flexion_deg = {0, 10};
    plan.varus_deg = {-1, 0, 1};
    model_ = test::model_of(plan);
    test::add_bodies(model_);
    write_motion_model(start_, with_pending_cells(model_));
  }

  /// Asks until `is_enough`, for ten seconds at most.
  template <typename IsEnough>
  static WatchArrivals taken_until(WatchThread& thread, const IsEnough& is_enough)
  {
    WatchArrivals all;
    for (int patience = 0; patience < 10000; ++patience) {
      WatchArrivals more = thread.take();
      all.is_anew = all.is_anew || more.is_anew;
      if (more.model) all.model = more.model;
      all.steps.insert(all.steps.end(), more.steps.begin(), more.steps.end());
      all.phase = more.phase;
      all.n_done = more.n_done;
      if (is_enough(all)) return all;
      std::this_thread::sleep_for(pause);
    }
    ADD_FAILURE() << "nothing came";
    return all;
  }

  test::Scratch scratch_;
  MotionModel model_;
  std::string output_ = (scratch_.path() / "knee.h5").string();
  std::string start_ = start_file_of(output_);
};

TEST_F(ThreadedWatch, EveryStepArrivesOnceAndTheResultWithItsEnd)
{
  JournalWriter writer = JournalWriter::create(journal_of(output_), std::string(64, 'a'));
  WatchThread thread(RunWatch(start_), pause);
  for (int j = 0; j < 3; ++j) {
    StepRecord r;
    r.key = {StepKind::row, 1, j};
    r.status = StepStatus::stable;
    writer.append(r);
  }
  const WatchArrivals steps = taken_until(thread, [](const WatchArrivals& a) { return a.steps.size() >= 3; });
  EXPECT_EQ(steps.steps.size(), 3u);
  EXPECT_EQ(steps.n_done, 3);
  EXPECT_EQ(steps.phase, RunPhase::running);
  EXPECT_FALSE(steps.model);
  write_motion_model(output_, model_);
  const WatchArrivals end = taken_until(thread, [](const WatchArrivals& a) { return a.model != nullptr; });
  EXPECT_EQ(end.phase, RunPhase::finished);
  EXPECT_TRUE((end.model->status == 0).all());
  EXPECT_TRUE(end.steps.empty());
}

TEST_F(ThreadedWatch, ARunBegunAnewComesWithItsPlan)
{
  WatchThread thread(RunWatch(start_), pause);
  test::ModelPlan plan;
  plan.flexion_deg = {0, 10, 20};
  MotionModel other = test::model_of(plan);
  test::add_bodies(other);
  write_motion_model(start_, with_pending_cells(other));
  const WatchArrivals anew = taken_until(thread, [](const WatchArrivals& a) { return a.is_anew; });
  ASSERT_TRUE(anew.model);
  EXPECT_EQ(anew.model->flexion_deg.size(), 3u);
}

TEST_F(ThreadedWatch, WhatEndsTheThreadIsThrownToWhomAsks)
{
  WatchThread thread(RunWatch(start_), pause);
  scratch_.write("knee.h5.start.h5", "no start file any more");
  EXPECT_THROW(taken_until(thread, [](const WatchArrivals&) { return false; }), InputError);
}

}  // namespace vrda::watch_thread_test
