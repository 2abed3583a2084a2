/// What `vrda run --trace` notes down while it solves.
#pragma once

#include <functional>
#include <map>
#include <string>

#include "core/step_record.hpp"
#include "journal/trace_journal.hpp"
#include "solve/stability_search.hpp"

namespace vrda {

/// Goes on with the journal of traces at `path`, or starts one when nothing is known yet. Throws InputError
/// when it lacks the trace of a step that the journal of steps, `steps_path`, holds.
FrameWriter open_trace_log(const std::string& path, const std::string& key, const std::string& steps_path,
                           const std::map<StepKey, StepRecord>& known);

/// Runs `solve` with a watch and appends what it saw. From any thread. Call it before the step is kept: then
/// a kill in between loses no trace.
StepRecord followed(FrameWriter& log, const StepKey& key, const MovingPose& seed,
                    const std::function<StepRecord(const Watch&)>& solve);

}  // namespace vrda
