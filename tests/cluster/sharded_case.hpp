/// A case in three shards, for tests of status and resume.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "cluster/jobs.hpp"
#include "cluster/status.hpp"
#include "cluster/submission_scenes.hpp"

namespace vrda::test {

inline const TaskId spine{TaskKind::spine, 0, 0};
inline const TaskId merge{TaskKind::merge, 0, 0};

inline TaskId shard(std::int32_t number)
{
  return {TaskKind::shard, 0, number};
}

/// One case in three shards.
class ShardedCase : public testing::Test {
 protected:
  ShardedCase() : submission_(one_case(3)), folder_(folder_with(scratch_, submission_)) {}

  TaskView view_of(const TaskId& task) const
  {
    const StatusView status = status_of(folder_, submission_, seen_);
    for (const TaskView& view : status.cases.front().tasks) {
      if (view.task == task) return view;
    }
    ADD_FAILURE() << "no such task";
    return {};
  }

  std::string output() const { return output_of(folder_, submission_.cases[0]); }

  void write_spine() const { write_journal(spine_journal_of(output()), {0, 1, 2, 3, 4, 5, 6}, 1, 0); }
  // Its row cells; the spine has column 0.
  void write_shard(std::int32_t number, std::size_t n_rows) const
  {
    std::vector<std::int32_t> rows = rows_of({number, 3}, 7);
    rows.resize(n_rows);
    write_journal(shard_journal_of(output(), {number, 3}), rows, 5);
  }

  void all_but_the_merge_is_done()
  {
    write_spine();
    seen_.states[spine] = state_of(TaskPhase::done, "");
    for (const std::int32_t k : {1, 2, 3}) {
      write_shard(k, rows_of({k, 3}, 7).size());
      seen_.states[shard(k)] = state_of(TaskPhase::done, "");
    }
  }

  Missing missing() const
  {
    return missing_of(folder_, submission_, status_of(folder_, submission_, seen_), seen_);
  }

  Scratch scratch_;
  Submission submission_;
  std::string folder_;
  SubmissionSnapshot seen_;
};

}  // namespace vrda::test
