#include "store/journal.hpp"

#include <unistd.h>

#include <cerrno>
#include <optional>
#include <utility>

#include "core/error.hpp"
#include "store/record_bytes.hpp"

namespace vrda::store {
namespace {

/// A record of a hundred contacts takes 7 kB; a length above 16 MiB means a damaged frame.
constexpr FrameFormat step_format{"VRDAJRNL", 2, std::uint32_t{1} << 24, "record"};

}  // namespace

JournalContent parse_journal(const std::string& path, std::string_view bytes)
{
  JournalContent content;
  FrameFileSummary facts = parse_frames(path, bytes, step_format, [&](std::string_view frame) -> std::string {
    std::optional<StepRecord> record = record_of(frame);
    if (!record) return "a record that is not a motion step";
    content.records.push_back(std::move(*record));
    return {};
  });
  content.key = std::move(facts.key);
  content.valid_bytes = facts.valid_bytes;
  content.dropped_bytes = facts.dropped_bytes;
  content.dropped_reason = std::move(facts.dropped_reason);
  return content;
}

JournalContent read_journal(const std::string& path)
{
  return parse_journal(path, read_frame_file(path));
}

FrameTail journal_tail(const std::string& path)
{
  return FrameTail(path, step_format);
}

void require_key(const std::string& found, const std::string& path, const std::string& wanted)
{
  if (found == wanted) return;
  throw InputError({path, "key", "the journal of another job (" + found + ")",
                    wanted + ", or " + start_over_remedy + ", or another output"});
}

JournalWriter JournalWriter::create(const std::string& path, const std::string& key)
{
  return JournalWriter(FrameWriter::create(path, key, step_format));
}

std::optional<OpenJournal> JournalWriter::try_open(const std::string& path, const std::string& key)
{
  if (access(path.c_str(), F_OK) != 0) {
    std::optional<FrameWriter> created = FrameWriter::try_create(path, key, step_format);
    if (!created) return std::nullopt;
    return OpenJournal{JournalWriter(std::move(*created)), {key, {}, 0, 0, {}}};
  }
  std::optional<FrameWriter> locked = FrameWriter::try_lock(path, step_format);
  const std::optional<std::string> bytes = read_frame_file_if_present(path);
  if (!bytes) return std::nullopt;  // its writer has just finished the model and removed it
  // The lock excludes other writers; a journal of another job is an error even while it is being written.
  JournalContent content = parse_journal(path, *bytes);
  require_key(content.key, path, key);
  if (!locked) return std::nullopt;
  locked->cut(content.valid_bytes);
  return OpenJournal{JournalWriter(std::move(*locked)), std::move(content)};
}

OpenJournal JournalWriter::open(const std::string& path, const std::string& key)
{
  std::optional<OpenJournal> opened = try_open(path, key);
  if (opened) return std::move(*opened);
  refuse_locked(path);
}

void JournalWriter::append(const StepRecord& record)
{
  file_.append(bytes_of(record));
}

}  // namespace vrda::store
