/// The layout of a trace file as a table: schemas/trace.md for programs.
#pragma once

#include "store/layout.hpp"

namespace vrda {

inline constexpr const char* trace_format_name = "vrda search trace";
inline constexpr const char* trace_format_version = "1.0";

struct TraceShape {
  std::int64_t n_searches = 0;
  std::int64_t n_moves = 0;
  std::int64_t n_contacts = 0;
  std::int64_t n_inputs = 0;
};

FileLayout trace_layout_of(const TraceShape& shape);

}  // namespace vrda
