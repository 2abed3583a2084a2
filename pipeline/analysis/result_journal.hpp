/// Journals of ranges of motion and fits: one record a frame, continued where a killed run stopped.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "core/framed_file.hpp"
#include "core/text.hpp"

namespace vrda::analysis {

/// A journal of values with a list of fields (core/fields.hpp), one a frame.
struct JournalFormat {
  core::FrameFormat frames;
  const char* other;  ///< of what a journal with another key is: "another job or other measurements"
};

/// Calls `take` with each value of the journal at `path`, up to a damaged or torn one. Throws InputError if
/// it cannot be read, or if its key is not `key`.
template <typename Value, typename Take>
core::FrameFileSummary read_journal(const std::string& path, const std::string& key,
                                    const JournalFormat& format, const Take& take)
{
  const auto take_frame = [&](std::string_view frame) -> std::string {
    std::optional<Value> value = core::value_of_bytes<Value>(frame);
    if (!value) return "a frame of another kind";
    take(std::move(*value));
    return {};
  };
  const core::FrameFileSummary summary =
      core::parse_frames(path, core::read_frame_file(path), format.frames, take_frame);
  if (summary.key != key)
    throw InputError(
        {path, "key", std::string("the journal of ") + format.other, "--fresh, or another --output"});
  return summary;
}

/// read_journal(), and the writer that appends to it; without a file, or with `is_fresh`, a new journal.
/// Throws InputError also if another process writes it.
template <typename Value, typename Take>
core::FrameWriter open_journal(const std::string& path, const std::string& key, bool is_fresh,
                               const JournalFormat& format, const Take& take)
{
  std::error_code error;
  if (is_fresh || !std::filesystem::exists(path, error))
    return core::FrameWriter::create(path, key, format.frames);
  std::optional<core::FrameWriter> writer = core::FrameWriter::try_lock(path, format.frames);
  const core::FrameFileSummary summary = read_journal<Value>(path, key, format, take);
  if (!writer) core::refuse_locked(path);
  writer->cut(summary.valid_bytes);
  return std::move(*writer);
}

}  // namespace vrda::analysis
