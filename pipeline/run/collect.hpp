/// Steps of one job out of many journals: which are there, which are missing or doubled.
#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "core/step_record.hpp"
#include "sweep/sweep.hpp"

namespace vrda {

struct CollectedSteps {
  std::map<StepKey, StepRecord> steps;
  std::int32_t n_doubled = 0;           ///< steps that stand more than once, with the same bytes
  std::set<std::int32_t> doubled_rows;  ///< their flexions, as indices
  std::set<std::string> doubled_in;     ///< the journals where they stand
  std::vector<std::string> remarks;     ///< one sentence for each journal with a damaged end
};

/// Reads them all. Throws InputError naming the file of another job, and both files where a step has two
/// results: one of them is not this program's.
CollectedSteps collect(const std::vector<std::string>& journals, const std::string& key);

/// What a row lacks that was begun, as by a shard that was stopped in its middle.
struct PartOfRow {
  std::int32_t row = 0;
  std::vector<std::int32_t> columns;  ///< varus angles without a result, as indices
};

/// What is still to be solved.
struct MissingSteps {
  bool is_spine_complete = false;
  std::vector<std::int32_t> rows;  ///< flexions with anything missing; all of them without a whole spine
  std::vector<PartOfRow> parts;    ///< of those among `rows` that were begun
  std::int32_t n_attitudes = 0;    ///< cells of the grid without a result

  bool is_nothing() const { return is_spine_complete && rows.empty(); }
};

/// Follows the seeding graph of `plan` through `steps`; `plan.rows` says of which rows, absent: of all.
MissingSteps missing_steps(const SweepPlan& plan, const std::map<StepKey, StepRecord>& steps);

/// The sweep of steps that are all there, without solving any.
SweepResult replayed(const SweepPlan& plan, const std::map<StepKey, StepRecord>& steps);

/// "0, 10 and 20 to 90": the angles with these indices, ascending, in degrees.
std::string angles_text(const std::vector<std::int32_t>& indices, const std::vector<double>& angles_deg);

/// "no result of 15 of 110 attitudes, at flexion 0 and 30, and at flexion 60 of varus -2 to 4"; empty where
/// every row is whole.
std::string missing_text(const MissingSteps& missing, const std::vector<double>& flexion_deg,
                         const std::vector<double>& varus_deg);

}  // namespace vrda
