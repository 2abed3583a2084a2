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

/// A moment that a clock set anew cannot spoil, as long as it is compared on the same machine, not restarted.
struct Moment {
  std::string boot;      ///< the kernel's name for the machine's start; empty when there is none
  double seconds = 0.0;  ///< since then
};

/// One process, told from others of the same number.
struct ProcessId {
  std::string host;
  std::int64_t pid = 0;
  std::uint64_t started = 0;  ///< clock ticks since the machine's start

  bool operator==(const ProcessId&) const = default;
};

struct TaskState {
  TaskPhase phase = TaskPhase::running;
  ProcessId process;
  std::string begun;  ///< UTC
  std::string ended;  ///< UTC; empty while running
  Moment begun_at;
  std::int64_t n_done_at_begin = 0;  ///< attitudes (of a spine: steps) in the journals
  std::int64_t n_done_at_end = 0;
  std::string slurm_job;        ///< "13_3", or empty
  std::int32_t n_restarts = 0;  ///< by Slurm
  std::int32_t exit_code = 0;   ///< of the command; meaningful once ended
  std::string reason;           ///< one line: why it failed, or what it waits for
};

/// "2026-03-01T10:00:00Z".
std::string utc_text(std::chrono::system_clock::time_point when);
std::string host_name();
Moment now();
/// Seconds from `begin` to `end`; nothing when they were taken on different machines or across a restart.
std::optional<double> seconds_between(const Moment& begin, const Moment& end);

/// This process, by this machine.
ProcessId own_process();
/// Whether it runs on this host; nothing when it is another host's.
std::optional<bool> is_alive(const ProcessId& process);

/// The state of a task that begins now, in this process; Slurm's numbers from the environment.
TaskState begun_now(std::int64_t n_done);

std::string task_file_of(const std::string& folder, const Submission& submission, const TaskId& task);

/// Writes under a second name and renames. Throws InputError naming the file.
void write_task_state(const std::string& folder, const Submission& submission, const TaskId& task,
                      const TaskState& state);
/// Nothing when the task never began, or when the file is damaged: it is made anew by the next start.
std::optional<TaskState> read_task_state(const std::string& folder, const Submission& submission,
                                         const TaskId& task);

/// Those of all tasks that ever began, with one look at the folder.
std::map<TaskId, TaskState> read_task_states(const std::string& folder, const Submission& submission);

}  // namespace vrda
