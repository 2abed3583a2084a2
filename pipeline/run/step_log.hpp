/// The steps that earlier runs solved, and the journals that new ones go to.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "journal/journal.hpp"
#include "journal/trace_journal.hpp"
#include "run/patience.hpp"
#include "sweep/sweep.hpp"

namespace vrda {

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

}  // namespace vrda
