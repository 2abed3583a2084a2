/// What each task of a submission leaves about itself: tasks/<case>.<kind>.json.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "cluster/submission.hpp"

namespace vrda {

enum class TaskPhase { running, done, failed, interrupted };

const char* name_of(TaskPhase phase);

struct TaskState {
  TaskPhase phase = TaskPhase::running;
  std::string host;                  ///< of Slurm's tasks the node's name
  std::string begun;                 ///< UTC, of the last start
  std::string ended;                 ///< UTC; empty while running
  std::int64_t n_done_at_begin = 0;  ///< attitudes (of a spine: steps) in the journals when it began to solve
  std::string slurm_job;             ///< "13_3", or empty
  std::int32_t n_restarts = 0;       ///< by Slurm
  std::int32_t exit_code = 0;        ///< of the command; meaningful once ended
  std::string reason;                ///< one line: why it failed, or what it waits for
};

/// "2026-03-01T10:00:00Z".
std::string utc_text(std::chrono::system_clock::time_point when);
std::string utc_now();
std::string host_name();

/// The state of a task that begins now, in this process; Slurm's numbers from the environment.
TaskState begun_now(std::int64_t n_done);

/// Whether both are of one start: of a Slurm job begun again the restarts differ. Local tasks are held apart
/// by the lock of their state file (core/open_file.hpp), which each holds from its begin to its end.
bool is_same_start(const TaskState& a, const TaskState& b);

std::string task_file_of(const std::string& folder, const Submission& submission, const TaskId& task);

/// Writes under a second name and renames. Throws InputError naming the file.
void write_task_state(const std::string& folder, const Submission& submission, const TaskId& task,
                      const TaskState& state);
/// Nothing when the task never began, or when the file is damaged: it is written again by the next start.
std::optional<TaskState> read_task_state(const std::string& folder, const Submission& submission,
                                         const TaskId& task);

/// Those of all tasks that ever began; the folder is listed once.
std::map<TaskId, TaskState> read_task_states(const std::string& folder, const Submission& submission);

}  // namespace vrda
