/// What was handed to Slurm: DIR/submitted.jsonl, one line a job, in order.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "cluster/jobs.hpp"
#include "cluster/slurm.hpp"
#include "cluster/submission.hpp"

namespace vrda {

struct SubmittedJob {
  std::string id;
  std::string at;  ///< UTC
  PlannedJob job;  ///< without what it waits for
};

/// One line at the end, on the disk when it returns: a job that is in Slurm's queue must not be forgotten.
/// Throws InputError naming the file.
[[nodiscard]] std::optional<InputError::Facts> append_submitted(const std::string& folder,
                                                                const SubmittedJob& submitted);
/// Lines that are damaged or cut short are left out.
std::vector<SubmittedJob> read_submitted(const std::string& folder);

/// One task as Slurm has it.
struct SlurmTask {
  std::string job;            ///< "13_3" or "12", of the last job that had this task
  SlurmRow row;               ///< its state is empty when Slurm has forgotten the job
  std::string log{};          ///< name of its log; of cases that share a task the same
  std::int32_t per_task = 1;  ///< cases that share it
};

/// Of each task that was ever submitted, the last time it was.
std::map<TaskId, SlurmTask> tasks_in_slurm(const Submission& submission,
                                           const std::vector<SubmittedJob>& jobs,
                                           const std::vector<SlurmRow>& rows);

/// Throws InputError whose file is "--cases-per-task" unless runs queued or under way have `asked` cases a
/// task: a task is a span of case numbers, and spans of two lengths would share cases.
void require_same_span(const std::map<TaskId, SlurmTask>& tasks, std::int32_t asked);

}  // namespace vrda
