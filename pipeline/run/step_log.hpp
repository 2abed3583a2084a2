/// The journal of one run: the steps of earlier runs of the same job, and the writers for new steps and
/// traces. In: path and job key (SHA-256). Out: known steps by key. A damaged tail is dropped with a warning;
/// another job's journal, or one that another process is writing, throws InputError.
#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <optional>
#include <string>

#include "core/error.hpp"
#include "model/step_record.hpp"
#include "store/journal.hpp"
#include "solve/stability_search.hpp"

namespace vrda::run {

/// How to wait for a journal that another process has locked.
struct JournalWait {
  std::chrono::milliseconds timeout{0};
  std::function<void()> on_start = [] {};  ///< called once when waiting starts
};

struct StepLog {
  std::string path;  ///< of the journal
  store::JournalWriter writer;
  std::map<StepKey, StepRecord> known;
  std::optional<core::FrameWriter> traces;
};

/// Resumes the journal at `path` or starts one. Throws InputError if it is another job's or being written.
StepLog open_log(const std::string& path, const std::string& key, bool is_fresh);

/// The same, but waits while another process writes the journal. Empty after the timeout, or when
/// interrupted.
std::optional<StepLog> open_log_waiting(const std::string& path, const std::string& key, bool is_fresh,
                                        const JournalWait& patience);

/// The step of an earlier run, if any.
std::optional<StepRecord> recalled_step(const StepLog& log, const StepKey& key);

/// If the output's folder was deleted or moved during a run: restores the journals from the open files and
/// throws an InputError that reports it. Otherwise returns.
void restore_lost_journals(const StepLog& log, const std::string& output);

/// Calls work(), and restore_lost_journals() if it throws InputError.
template <typename Work>
auto with_journal_restore(const StepLog& log, const std::string& output, const Work& work)
{
  try {
    return work();
  } catch (const InputError&) {
    restore_lost_journals(log, output);
    throw;
  }
}

/// Resumes the journal of traces at `path`, or starts one if `known` is empty. Throws InputError if a step of
/// the journal `steps_path` has no trace.
core::FrameWriter open_trace_log(const std::string& path, const std::string& key,
                                    const std::string& steps_path,
                                    const std::map<StepKey, StepRecord>& known);

/// Calls `solve` with an observer and appends the observed trace. Thread-safe. Must be called before the step
/// is kept, so that a kill in between loses no trace.
StepRecord solve_with_trace(core::FrameWriter& log, const StepKey& key, const MovingPose& seed,
                            const std::function<StepRecord(const SearchObserver&)>& solve);

}  // namespace vrda::run
