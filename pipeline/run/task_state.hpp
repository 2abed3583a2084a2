/// State file of each task of a submission, tasks/<case>.<kind>.json: phase, host, UTC times, reason of a
/// failure. It is replaced atomically, so that `vrda status` reads it at any time.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "run/submission.hpp"

namespace vrda::run {

enum class TaskPhase { running, done, failed, interrupted };

const char* name_of(TaskPhase phase);

struct TaskState {
  TaskPhase phase = TaskPhase::running;
  std::string host;                  ///< node name for Slurm tasks
  std::string started;               ///< UTC, of the last start
  std::string ended;                 ///< UTC; empty while running
  std::int64_t n_done_at_start = 0;  ///< attitudes (spine: steps) in the journals when solving started
  std::string slurm_job;             ///< "13_3", or empty
  std::int32_t n_restarts = 0;       ///< by Slurm
  std::int32_t exit_code = 0;        ///< of the command; meaningful once ended
  std::string reason;                ///< one line: reason of failure or waiting
};

/// "2026-03-01T10:00:00Z".
std::string utc_text(std::chrono::system_clock::time_point when);
std::string utc_now();
std::string host_name();

/// The state of a task that starts now in this process; Slurm's numbers are from the environment.
TaskState started_now(std::int64_t n_done);

/// Whether both belong to the same start; restarts of a Slurm job differ in n_restarts. Local tasks are
/// excluded by the lock of their state file (core/open_file.hpp), which each holds while it runs.
bool is_same_start(const TaskState& a, const TaskState& b);

std::string task_file_of(const std::string& folder, const Submission& submission, const TaskId& task);

/// Writes atomically (temporary name, rename). Throws InputError naming the file.
void write_task_state(const std::string& folder, const Submission& submission, const TaskId& task,
                      const TaskState& state);
/// Empty if the task never started, or if the file is damaged; the next start writes it again.
std::optional<TaskState> read_task_state(const std::string& folder, const Submission& submission,
                                         const TaskId& task);

/// The states of all tasks that have started; lists the folder once.
std::map<TaskId, TaskState> read_task_states(const std::string& folder, const Submission& submission);

}  // namespace vrda::run
