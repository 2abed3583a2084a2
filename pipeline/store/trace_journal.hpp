/// The append-only journal of finished searches with all their moves, so that a resumed run has a complete
/// trace. File: frames of framed_file.hpp, one per search.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "model/step_record.hpp"
#include "core/frame_tail.hpp"
#include "core/framed_file.hpp"

namespace vrda::store {

struct TraceJournalContent {
  FrameFileSummary summary;
  std::map<StepKey, SearchTrace> searches;  ///< the last of each key
};

/// The valid prefix of a journal's bytes; a damaged or torn tail is reported, not thrown. Throws InputError
/// with `path` if they are not a journal of traces, have another format version or a damaged header.
TraceJournalContent parse_trace_journal(const std::string& path, std::string_view bytes);

/// parse_trace_journal() of a file's bytes. Throws InputError also if the file cannot be read.
TraceJournalContent read_trace_journal(const std::string& path);

/// Reads a growing journal; trace_of() parses its frames.
FrameTail trace_journal_tail(const std::string& path);

/// Like JournalWriter::create() and resuming one.
FrameWriter create_trace_journal(const std::string& path, const std::string& key);
FrameWriter resume_trace_journal(const std::string& path, const FrameFileSummary& facts);

/// The content of one frame, and its inverse: empty if the bytes are not a valid search.
std::string bytes_of(const SearchTrace& trace);
std::optional<SearchTrace> trace_of(std::string_view bytes);

}  // namespace vrda::store
