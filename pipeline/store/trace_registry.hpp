/// Registry of the trace's datasets: one row per dataset, in the order of the file (schemas/trace.md).
#pragma once

#include "store/registry_visitor.hpp"
#include "store/trace.hpp"

namespace vrda::store {

inline constexpr const char* trace_format_name = "vrda search trace";
inline constexpr const char* trace_format_version = "1.1";
inline constexpr int trace_format_minor_version = 1;

void visit_rows(Trace& trace, RowVisitor& visit);

/// Visits every row of a trace: const for writing, non-const for reading.
template <typename ATrace, typename Visitor>
void visit_trace(ATrace& trace, Visitor&& visitor)
{
  RowVisitorOf<std::remove_reference_t<Visitor>, std::is_const_v<ATrace>> rows(visitor);
  visit_rows(const_cast<Trace&>(trace), rows);
}

}  // namespace vrda::store
