/// `vrda trace`: what the searches of a trace did.
#pragma once

#include <string>

#include "store/trace.hpp"
#include "talk/talk.hpp"

namespace vrda {

struct TraceOptions {
  std::string file;
  AttitudeFilter filter;
  bool contact_only = false;  ///< leave out the moves that are not in contact
  bool as_csv = false;
  bool as_json = false;
};

ExitCode trace_command(const TraceOptions& options);

}  // namespace vrda
