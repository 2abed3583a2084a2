/// The trace and its HDF5 file. schemas/trace.md specifies the file.
#pragma once

#include <string>
#include <vector>

#include "store/finding.hpp"
#include "store/trace.hpp"

namespace vrda {

/// "knee.trace.h5" for "knee.h5".
std::string trace_name(const std::string& motion_model_file);

/// As write_motion_model. Equal traces give equal bytes.
void write_trace(const std::string& path, const Trace& trace);

/// Reads a trace that follows the specification. Throws InputError naming the file and the first object that
/// does not.
Trace read_trace(const std::string& path);

/// As validate_motion_model.
std::vector<Finding> validate_trace(const std::string& path);

/// Throws InputError naming `trace_file` when it is not the trace of `model`, read from `model_file`.
void require_beside(const Trace& trace, const std::string& trace_file, const MotionModel& model,
                    const std::string& model_file);

/// Whether the file says that it is a trace. Throws InputError as the readers do when it is no HDF5 file.
bool is_trace(const std::string& path);

}  // namespace vrda
