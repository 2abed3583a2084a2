/// How many attitudes the journals of a submission hold.
#pragma once

#include <cstdint>
#include <set>
#include <string>
#include <utility>

#include "cluster/submission.hpp"

namespace vrda {

struct SolvedCount {
  std::int64_t n_done = 0;
  std::int64_t n_total = 0;  ///< 0: not known beforehand
};

/// Reads journals, that of a case's spine once for all of its shards.
class SolvedCounter {
 public:
  SolvedCounter(const std::string& folder, const Submission& submission)
      : folder_(folder), submission_(submission)
  {
  }

  /// Attitudes of the task's own rows that are solved; of a spine with varus left free its steps, which have
  /// no known total. Merge and index have none. A journal that is not there or damaged counts nothing.
  SolvedCount count(const TaskId& task);

  /// Attitudes that the task has to solve; 0 for spine, merge and index.
  std::int64_t total_of(const TaskId& task) const;

 private:
  using Cell = std::pair<std::int32_t, std::int32_t>;  // flexion, varus
  struct Content {
    std::set<Cell> cells;
    std::int64_t n_free_steps = 0;
  };

  static Content content_of(const std::string& journal);
  const Content& spine_of(std::int32_t case_number);

  const std::string& folder_;
  const Submission& submission_;
  std::int32_t spine_case_ = -1;  // whose spine stands in spine_
  Content spine_;
};

/// The journals that a task appends to.
std::vector<std::string> journals_of(const std::string& folder, const Submission& submission,
                                     const TaskId& task);

}  // namespace vrda
