/// The steps of earlier runs, and the journals of steps and traces for new ones.
#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <optional>
#include <string>

#include "core/error.hpp"
#include "core/step_record.hpp"
#include "journal/journal.hpp"
#include "solve/stability_search.hpp"

namespace vrda {

/// How to wait for a journal that another process has locked.
struct Patience {
  std::chrono::milliseconds longest{0};
  std::function<void()> begins = [] {};  ///< called once when waiting starts
};

struct StepLog {
  std::string path;  ///< of the journal
  JournalWriter writer;
  std::map<StepKey, StepRecord> known;
  std::optional<FrameWriter> traces;
};

/// Resumes the journal at `path` or starts one. Throws InputError if it is another job's or being written.
StepLog open_log(const std::string& path, const std::string& key, bool is_fresh);

/// The same, but waits while another process writes the journal. Empty after the timeout, or when
/// interrupted.
std::optional<StepLog> open_log_waiting(const std::string& path, const std::string& key, bool is_fresh,
                                        const Patience& patience);

/// The step of an earlier run, if any.
std::optional<StepRecord> recalled(const StepLog& log, const StepKey& key);

/// If the output's folder was deleted or moved during a run: restores the journals from the open files and
/// throws an InputError that reports it. Otherwise returns.
void put_back_lost(const StepLog& log, const std::string& output);

/// Calls work(), and restore_lost_journals() if it throws InputError.
template <typename Work>
auto putting_back_lost(const StepLog& log, const std::string& output, const Work& work)
{
  try {
    return work();
  } catch (const InputError&) {
    put_back_lost(log, output);
    throw;
  }
}

/// Resumes the journal of traces at `path`, or starts one if `known` is empty. Throws InputError if a step of
/// the journal `steps_path` has no trace.
FrameWriter open_trace_log(const std::string& path, const std::string& key, const std::string& steps_path,
                           const std::map<StepKey, StepRecord>& known);

/// Calls `solve` with an observer and appends the observed trace. Thread-safe. Must be called before the step
/// is kept, so that a kill in between loses no trace.
StepRecord followed(FrameWriter& log, const StepKey& key, const MovingPose& seed,
                    const std::function<StepRecord(const Watch&)>& solve);

}  // namespace vrda
