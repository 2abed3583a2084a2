#include "journal/journal.hpp"

#include <optional>
#include <utility>

#include "core/error.hpp"
#include "journal/record_bytes.hpp"

namespace vrda {
namespace {

/// A record of a hundred contacts takes 7 kB; a frame that claims 16 MiB is damaged.
constexpr FrameFormat format{"VRDAJRNL", 1, std::uint32_t{1} << 24, "record"};

}  // namespace

JournalContent parse_journal(const std::string& path, std::string_view bytes)
{
  JournalContent content;
  FrameFacts facts = parse_frames(path, bytes, format, [&](std::string_view frame) -> std::string {
    std::optional<StepRecord> record = record_of(frame);
    if (!record) return "a record that is no motion step";
    content.records.push_back(std::move(*record));
    return {};
  });
  content.key = std::move(facts.key);
  content.valid_bytes = facts.valid_bytes;
  content.dropped_bytes = facts.dropped_bytes;
  content.dropped_why = std::move(facts.dropped_why);
  return content;
}

JournalContent read_journal(const std::string& path)
{
  return parse_journal(path, frame_bytes_of(path));
}

void require_key(const std::string& found, const std::string& path, const std::string& wanted)
{
  if (found == wanted) return;
  throw InputError({path, "key", "the journal of another job (" + found + ")",
                    wanted + "; use --fresh to start over, or another output"});
}

JournalWriter JournalWriter::create(const std::string& path, const std::string& key)
{
  return JournalWriter(FrameWriter::create(path, key, format));
}

JournalWriter JournalWriter::resume(const std::string& path, const JournalContent& content)
{
  return JournalWriter(FrameWriter::resume(path, content.valid_bytes, format));
}

void JournalWriter::append(const StepRecord& record)
{
  file_.append(bytes_of(record));
}

}  // namespace vrda
