/// `vrda run`: solves a job and writes its motion model.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "cluster/jobs.hpp"
#include "run/step_log.hpp"
#include "talk/talk.hpp"

namespace vrda {

struct RunOptions {
  std::string job_file;
  std::string output;  ///< empty: results/<job name>/<job name>.h5
  std::string data_directory;
  std::vector<std::string> overrides;
  int n_threads = 0;          ///< 0: as many as there are processors
  bool is_fresh = false;      ///< drop a journal found, and solve a finished job again
  bool may_replace = false;   ///< the result of another job
  bool writes_trace = false;  ///< every move of every search, beside the output
  std::string progress = "auto";
  bool only_spine = false;      ///< solve the spine into a journal of its own, for shards
  std::optional<Shard> shard;   ///< solve these rows only, into a journal of their own
  std::function<void()> begun;  ///< told before the first step of the spine, and of the rows
  /// Absent: a shard waits a minute, a whole run not at all.
  std::optional<Patience> patience;
};

/// The whole job, or with `only_spine` or `shard` a part of it for `vrda merge`.
ExitCode run_command(const RunOptions& options);

}  // namespace vrda
