/// Motion models and traces as plain bytes of this machine, to hand them from one process to another. No file
/// format: nothing but this program reads them, and only while it runs.
#pragma once

#include <string>
#include <string_view>

#include "store/motion_model.hpp"
#include "store/trace.hpp"

namespace vrda {

/// Of models that write_motion_model would take, and traces likewise.
std::string plain_bytes(const MotionModel& model);
std::string plain_bytes(const Trace& trace);

/// What plain_bytes was given. Whatever the bytes are, no byte beyond them is read and no more than ten times
/// their number and some MB allocated. The values follow the specification, or InputError names `file`.
MotionModel motion_model_of(std::string_view bytes, const std::string& file);
Trace trace_of(std::string_view bytes, const std::string& file);

}  // namespace vrda
