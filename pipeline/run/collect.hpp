/// Collects the steps of one job from many journals and finds missing and duplicate ones.
#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "model/step_record.hpp"
#include "solve/sweep.hpp"

namespace vrda::run {

struct CollectedSteps {
  std::map<StepKey, StepRecord> steps;
  std::int32_t n_duplicates = 0;             ///< steps found more than once, with the same bytes
  std::set<std::int32_t> duplicate_rows;     ///< their flexion indices
  std::set<std::string> duplicate_journals;  ///< the journals that contain them
  std::vector<std::string> warnings;         ///< one message for each journal with a damaged end
};

/// Reads all journals. `key`: the job's (solve::fingerprint_of), which each journal must have. Throws
/// InputError with the file for a journal of another job, and with both files if a step has two different
/// results.
CollectedSteps collect_steps(const std::vector<std::string>& journals, const std::string& key);

/// The missing cells of a row that has some results, for example of an interrupted shard.
struct IncompleteRow {
  std::int32_t row = 0;
  std::vector<std::int32_t> columns;  ///< varus indices without a result
};

/// The steps without a result.
struct MissingSteps {
  bool is_spine_complete = false;
  std::vector<std::int32_t>
      rows;  ///< flexion indices of incomplete rows; all rows if the spine is incomplete
  std::vector<IncompleteRow> incomplete_rows;  ///< those of `rows` that have some results
  std::int32_t n_attitudes = 0;                ///< cells of the grid without a result

  bool is_empty() const { return is_spine_complete && rows.empty(); }
};

/// Follows the seeding graph of `plan` through `steps`, for the rows `plan.rows`; absent: all.
MissingSteps missing_steps(const solve::SweepPlan& plan, const std::map<StepKey, StepRecord>& steps);

/// The sweep result of a complete set of steps; solves none.
solve::SweepResult replay_sweep(const solve::SweepPlan& plan, const std::map<StepKey, StepRecord>& steps);

/// "0, 10 and 20 to 90": the angles with these indices, ascending, in degrees.
std::string angles_text(const std::vector<std::int32_t>& indices, const std::vector<double>& angles_deg);

/// "no result for 15 of 110 attitudes, at flexion 0 and 30, and at flexion 60 of varus -2 to 4"; empty if
/// every row is complete.
std::string missing_text(const MissingSteps& missing, const std::vector<double>& flexion_deg,
                         const std::vector<double>& varus_deg);

}  // namespace vrda::run
