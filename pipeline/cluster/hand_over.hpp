/// Hands a submission's tasks to Slurm.
#pragma once

#include <string>
#include <vector>

#include "cluster/submission.hpp"
#include "cluster/submitted.hpp"
#include "cluster/work.hpp"

namespace vrda {

/// Writes scripts/<kind>.sbatch of every kind among the jobs. Throws InputError naming the file.
void write_scripts(const std::string& folder, const Submission& submission,
                   const std::vector<PlannedJob>& jobs);

/// Submits the jobs, whose scripts stand, and notes each down at once. When Slurm refuses one, those
/// submitted before go on; its InputError names `vrda resume` then, which adds what is missing. A job that
/// cannot be noted down is cancelled.
std::vector<SubmittedJob> hand_over(const std::string& folder, const Submission& submission,
                                    const std::vector<PlannedJob>& jobs);

/// "spine 12, shards 13_[1-8%4], merge 14": a line a case, then one of cases without shards and the index.
std::vector<std::string> lines_of(const Submission& submission, const std::vector<SubmittedJob>& jobs);

}  // namespace vrda
