/// A case in three shards, for tests of status and resume.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "cluster/jobs.hpp"
#include "cluster/status.hpp"
#include "cluster/submission_scenes.hpp"

namespace vrda::test {

inline const cluster::TaskId spine{cluster::TaskKind::spine, 0, 0};
inline const cluster::TaskId merge{cluster::TaskKind::merge, 0, 0};

inline cluster::TaskId shard(std::int32_t number)
{
  return {cluster::TaskKind::shard, 0, number};
}

/// One case in three shards.
class ShardedCase : public testing::Test {
 protected:
  ShardedCase() : submission_(one_case(3)), folder_(folder_with(scratch_, submission_)) {}

  cluster::TaskView view_of(const cluster::TaskId& task) const
  {
    const cluster::StatusView status = cluster::status_of(folder_, submission_, seen_);
    for (const cluster::TaskView& view : status.cases.front().tasks) {
      if (view.task == task) return view;
    }
    ADD_FAILURE() << "no such task";
    return {};
  }

  std::string output() const { return cluster::output_of(folder_, submission_.cases[0]); }

  void write_spine() const
  {
    write_journal(journal::spine_journal_of(output()), {0, 1, 2, 3, 4, 5, 6}, 1, 0);
  }
  // Its row cells; the spine has column 0.
  void write_shard(std::int32_t number, std::size_t n_rows) const
  {
    std::vector<std::int32_t> rows = cluster::rows_of({number, 3}, 7);
    rows.resize(n_rows);
    write_journal(journal::shard_journal_of(output(), {number, 3}), rows, 5);
  }

  void set_all_done_except_merge()
  {
    write_spine();
    seen_.states[spine] = state_of(cluster::TaskPhase::done, "");
    for (const std::int32_t k : {1, 2, 3}) {
      write_shard(k, cluster::rows_of({k, 3}, 7).size());
      seen_.states[shard(k)] = state_of(cluster::TaskPhase::done, "");
    }
  }

  cluster::MissingWork missing() const
  {
    return cluster::find_missing_work(folder_, submission_, cluster::status_of(folder_, submission_, seen_),
                                      seen_);
  }

  Scratch scratch_;
  cluster::Submission submission_;
  std::string folder_;
  cluster::SubmissionSnapshot seen_;
};

}  // namespace vrda::test
