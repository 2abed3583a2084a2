/// The steps that earlier runs solved, and the journals and traces that new ones go to.
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

struct Patience {
  std::chrono::milliseconds longest{0};
  std::function<void()> begins = [] {};  ///< told once when there is something to wait for
};

struct StepLog {
  std::string path;  ///< of the writer's file
  JournalWriter writer;
  std::map<StepKey, StepRecord> known;
  std::optional<FrameWriter> traces;
};

/// Goes on with the journal at `path` or starts one, and says so. Throws InputError when it is another job's
/// or another process writes it.
StepLog open_log(const std::string& path, const std::string& key, bool is_fresh);

/// The same, but waits while another process writes the journal: a task that begins again may find its
/// predecessor about to end. Nothing when patience ends, or when interrupted.
std::optional<StepLog> open_log_waiting(const std::string& path, const std::string& key, bool is_fresh,
                                        const Patience& patience);

/// Recalls what `log` knows. Both refer to it.
std::optional<StepRecord> recalled(const StepLog& log, const StepKey& key);

/// Where the output's folder was deleted or moved under a run: the journals, which are still open, go back to
/// their places, and the InputError says so. Returns when they are in place.
void put_back_lost(const StepLog& log, const std::string& output);

/// work(), and put_back_lost() when it fails.
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

/// Goes on with the journal of traces at `path`, or starts one when nothing is known yet. Throws InputError
/// when it lacks the trace of a step that the journal of steps, `steps_path`, holds.
FrameWriter open_trace_log(const std::string& path, const std::string& key, const std::string& steps_path,
                           const std::map<StepKey, StepRecord>& known);

/// Runs `solve` with a watch and appends what it saw. From any thread. Call it before the step is kept: then
/// a kill in between loses no trace.
StepRecord followed(FrameWriter& log, const StepKey& key, const MovingPose& seed,
                    const std::function<StepRecord(const Watch&)>& solve);

}  // namespace vrda
