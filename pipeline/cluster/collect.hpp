/// Steps of one job out of many journals: which are there, which are missing or doubled.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/step_record.hpp"
#include "sweep/sweep.hpp"

namespace vrda {

struct CollectedSteps {
  std::map<StepKey, StepRecord> steps;
  std::int32_t n_doubled = 0;        ///< steps that stand more than once, with the same bytes
  std::vector<std::string> remarks;  ///< one sentence for each journal with a damaged end
};

/// Reads them all. Throws InputError naming the file of another job, and both files where a step has two
/// results: one of them is not this program's.
CollectedSteps collect(const std::vector<std::string>& journals, const std::string& key);

/// What is still to be solved.
struct MissingSteps {
  bool is_spine_complete = false;
  std::vector<std::int32_t> rows;  ///< flexions with anything missing; all of them without a whole spine
  std::int32_t n_attitudes = 0;    ///< cells of the grid without a result

  bool is_nothing() const { return is_spine_complete && rows.empty(); }
};

/// Follows the seeding graph of `plan` through `steps`; `plan.rows` says of which rows, absent: of all.
MissingSteps missing_steps(const SweepPlan& plan, const std::map<StepKey, StepRecord>& steps);

/// The sweep of steps that are all there, without solving any.
SweepResult replayed(const SweepPlan& plan, const std::map<StepKey, StepRecord>& steps);

/// "0, 10 and 20 to 90": flexions of these rows, in degrees.
std::string flexions_text(const std::vector<std::int32_t>& rows, const std::vector<double>& flexion_deg);

}  // namespace vrda
