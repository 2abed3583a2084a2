/// A case in three shards, for tests of status and resume.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "run/status.hpp"
#include "run/submission.hpp"
#include "run/submission_scenes.hpp"

namespace vrda::test {

inline const run::TaskId spine{run::TaskKind::spine, 0, 0};
inline const run::TaskId merge{run::TaskKind::merge, 0, 0};

inline run::TaskId shard(std::int32_t number)
{
  return {run::TaskKind::shard, 0, number};
}

/// One case in three shards.
class ShardedCase : public testing::Test {
 protected:
  ShardedCase() : submission_(one_case(3)), folder_(folder_with(scratch_, submission_)) {}

  run::TaskView view_of(const run::TaskId& task) const
  {
    const run::StatusView status = run::status_of(folder_, submission_, seen_);
    for (const run::TaskView& view : status.cases.front().tasks) {
      if (view.task == task) return view;
    }
    ADD_FAILURE() << "no such task";
    return {};
  }

  std::string output() const { return run::output_of(folder_, submission_.cases[0]); }

  void write_spine() const { write_journal(store::spine_journal_of(output()), {0, 1, 2, 3, 4, 5, 6}, 1, 0); }
  // Its row cells; the spine has column 0.
  void write_shard(std::int32_t number, std::size_t n_rows) const
  {
    std::vector<std::int32_t> rows = run::rows_of({number, 3}, 7);
    rows.resize(n_rows);
    write_journal(store::shard_journal_of(output(), {number, 3}), rows, 5);
  }

  void set_all_done_except_merge()
  {
    write_spine();
    seen_.states[spine] = state_of(run::TaskStatus::done, "");
    for (const std::int32_t k : {1, 2, 3}) {
      write_shard(k, run::rows_of({k, 3}, 7).size());
      seen_.states[shard(k)] = state_of(run::TaskStatus::done, "");
    }
  }

  run::MissingWork missing() const
  {
    return run::find_missing_work(folder_, submission_, run::status_of(folder_, submission_, seen_), seen_);
  }

  Scratch scratch_;
  run::Submission submission_;
  std::string folder_;
  run::SubmissionSnapshot seen_;
};

}  // namespace vrda::test
