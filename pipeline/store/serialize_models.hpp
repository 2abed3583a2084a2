/// Serialization of motion models and traces to pass them between processes. Not a file format.
#pragma once

#include <string>
#include <string_view>

#include "store/motion_model.hpp"
#include "store/trace.hpp"

namespace vrda::store {

/// Preconditions as for write_motion_model and write_trace.
std::string serialize(const MotionModel& model);
std::string serialize(const Trace& trace);

/// Inverse of serialize. For any bytes: never reads beyond them, and allocates at most ten times their number
/// plus some MB. Throws InputError naming `file` if the values violate the specification.
MotionModel deserialize_motion_model(std::string_view bytes, const std::string& file);
Trace trace_of(std::string_view bytes, const std::string& file);

}  // namespace vrda::store
