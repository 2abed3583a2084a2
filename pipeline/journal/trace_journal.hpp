/// The append-only record of finished searches, move by move: what lets the trace of a killed run be whole.
/// File: frames of framed_file.hpp, one a search.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "core/step_record.hpp"
#include "journal/frame_tail.hpp"
#include "journal/framed_file.hpp"

namespace vrda {

struct TraceJournalContent {
  FrameFacts facts;
  std::map<StepKey, SearchTrace> searches;  ///< of a search solved twice the first: both are the same
};

/// The valid prefix of a journal's bytes; a damaged or torn tail is reported, not thrown. Throws InputError
/// naming `path` when they are no journal of traces, of another format version or have a damaged header.
TraceJournalContent parse_trace_journal(const std::string& path, std::string_view bytes);

/// parse_trace_journal() of a file's bytes. Throws InputError also when the file cannot be read.
TraceJournalContent read_trace_journal(const std::string& path);

/// Looks on while a journal grows; trace_of() reads its frames.
FrameTail trace_journal_tail(const std::string& path);

/// Start and go on as a JournalWriter does.
FrameWriter create_trace_journal(const std::string& path, const std::string& key);
FrameWriter resume_trace_journal(const std::string& path, const FrameFacts& facts);

/// The content of one frame, and its inverse: nothing when the bytes are no search.
std::string bytes_of(const SearchTrace& trace);
std::optional<SearchTrace> trace_of(std::string_view bytes);

}  // namespace vrda
