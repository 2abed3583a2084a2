/// Submissions for tests.
#pragma once

#include "run/status.hpp"
#include "run/submission.hpp"
#include "support/scratch.hpp"

namespace vrda::test {

/// The case "knee" of 7 x 5 attitudes, its model DIR/knee.h5.
run::Submission one_case(std::int32_t n_shards);
/// Cases "case-1" ... of 7 x 5 attitudes along one axis.
run::Submission campaign(std::int32_t n_cases, std::int32_t n_shards);

/// Its folder with submission.json, logs/, tasks/ and scripts/.
std::string folder_with(const Scratch& scratch, const run::Submission& submission);

/// A state of that phase; `slurm_job` may be empty.
run::TaskState state_of(run::TaskStatus phase, const std::string& slurm_job, const std::string& reason = "");

/// A journal with the cells of these rows in these columns, all of kind `row` except `spine_column`.
void write_journal(const std::string& path, const std::vector<std::int32_t>& rows, std::int32_t n_varus,
                   std::int32_t spine_column = -1);

/// The journal of a spine with free varus and `n_steps` steps.
void write_free_spine(const std::string& path, std::int32_t n_steps);

}  // namespace vrda::test
