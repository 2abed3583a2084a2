/// HDF5 file of the trace (schemas/trace.md).
#pragma once

#include <string>

#include "store/trace.hpp"

namespace vrda::store {

/// "knee.trace.h5" for "knee.h5".
std::string trace_name(const std::string& motion_model_file);

/// As write_motion_model. Equal traces give equal bytes.
void write_trace(const std::string& path, const Trace& trace);

/// As read_motion_model.
Trace read_trace(const std::string& path);

/// Throws InputError naming `trace_file` when it is not the trace of `model`, read from `model_file`.
void require_trace_matches_model(const Trace& trace, const std::string& trace_file, const MotionModel& model,
                                 const std::string& model_file);

}  // namespace vrda::store
