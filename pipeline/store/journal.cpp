#include "store/journal.hpp"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <system_error>
#include <tuple>
#include <utility>

#include "core/text.hpp"

namespace vrda::store {
namespace {

/// A record of a hundred contacts takes 7 kB; a length above 16 MiB means a damaged frame.
constexpr FrameFormat step_format{"VRDAJRNL", 2, std::uint32_t{1} << 24, "record"};

}  // namespace

JournalContent parse_journal(const std::string& path, std::string_view bytes)
{
  std::vector<StepRecord> records;
  FrameFileSummary summary =
      parse_frames(path, bytes, step_format, [&](std::string_view frame) -> std::string {
        std::optional<StepRecord> record = core::value_of_bytes<StepRecord>(frame);
        if (!record) return "a record that is not a motion step";
        records.push_back(std::move(*record));
        return {};
      });
  return {std::move(summary), std::move(records)};
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
    return OpenJournal{JournalWriter(std::move(*created)), {{key, 0, 0, {}}, {}}};
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
  file_.append(core::bytes_of_value(record));
}

namespace {

namespace fs = std::filesystem;

constexpr std::string_view start_ending = ".start.h5";
constexpr std::string_view spine_ending = ".spine.journal";
constexpr std::string_view journal_ending = ".journal";
constexpr std::string_view shard_mark = ".shard-";
constexpr std::string_view between = "-of-";

std::optional<std::int32_t> count_in(std::string_view text)
{
  std::int32_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool is_whole = error == std::errc() && end == text.data() + text.size();
  return is_whole && value > 0 && text.front() != '0' ? std::optional(value) : std::nullopt;
}

struct JournalName {
  std::string output;
  Shard shard;
};

std::optional<JournalName> shard_journal_name(std::string_view journal)
{
  if (!journal.ends_with(journal_ending)) return std::nullopt;
  const std::string_view stem = journal.substr(0, journal.size() - journal_ending.size());
  const std::size_t mark = stem.rfind(shard_mark);
  if (mark == std::string_view::npos) return std::nullopt;
  const auto shard = parse_shard(stem.substr(mark + shard_mark.size()), between);
  if (!shard) return std::nullopt;
  return JournalName{std::string(stem.substr(0, mark)), *shard};
}

struct Listing {
  std::vector<std::string> paths;
  std::error_code error;
};

Listing shard_journals_listed(const std::string& output)
{
  const fs::path folder = fs::path(output).has_parent_path() ? fs::path(output).parent_path() : ".";
  std::vector<std::tuple<std::int32_t, std::int32_t, std::string>> found;
  Listing listing;
  for (fs::directory_iterator it(folder, listing.error), end; !listing.error && it != end;
       it.increment(listing.error)) {
    const std::string path = (fs::path(output).parent_path() / it->path().filename()).string();
    const auto name = shard_journal_name(path);
    if (name && name->output == output) found.emplace_back(name->shard.count, name->shard.number, path);
  }
  std::sort(found.begin(), found.end());
  for (const auto& [count, number, path] : found) listing.paths.push_back(path);
  return listing;
}

}  // namespace

std::string journal_of(const std::string& output)
{
  return output + std::string(journal_ending);
}

std::string trace_journal_of(const std::string& output)
{
  return output + ".trace" + std::string(journal_ending);
}

std::string start_file_of(const std::string& output)
{
  return output + std::string(start_ending);
}

std::string output_of_start_file(const std::string& start_file)
{
  const bool is_one = start_file.size() > start_ending.size() && start_file.ends_with(start_ending);
  return is_one ? start_file.substr(0, start_file.size() - start_ending.size()) : std::string();
}

std::optional<Shard> parse_shard(std::string_view text, std::string_view separator)
{
  const std::size_t at = text.find(separator);
  if (at == std::string_view::npos) return std::nullopt;
  const auto number = count_in(text.substr(0, at));
  const auto count = count_in(text.substr(at + separator.size()));
  if (!number || !count || *number > *count) return std::nullopt;
  return Shard{*number, *count};
}

std::string spine_journal_of(const std::string& output)
{
  return output + std::string(spine_ending);
}

std::string shard_journal_of(const std::string& output, const Shard& shard)
{
  return output + std::string(shard_mark) + std::to_string(shard.number) + std::string(between) +
         std::to_string(shard.count) + std::string(journal_ending);
}

std::optional<Shard> shard_of_journal(const std::string& journal)
{
  const auto name = shard_journal_name(journal);
  return name ? std::optional(name->shard) : std::nullopt;
}

std::string output_of_journal(const std::string& journal)
{
  if (journal.ends_with(spine_ending)) return journal.substr(0, journal.size() - spine_ending.size());
  const auto name = shard_journal_name(journal);
  return name ? name->output : std::string();
}

std::vector<std::string> list_shard_journals(const std::string& output)
{
  const Listing listing = shard_journals_listed(output);
  if (!listing.error) return listing.paths;
  const fs::path folder = fs::path(output).has_parent_path() ? fs::path(output).parent_path() : ".";
  throw InputError({folder.string(), "", listing.error.message(), "a folder that can be read"});
}

std::vector<std::string> list_shard_journals_if_readable(const std::string& output)
{
  return shard_journals_listed(output).paths;
}

namespace {

/// A move with twenty contacts takes 1.4 kB; a search of a few thousand moves takes megabytes.
constexpr FrameFormat format{"VRDATRCJ", 1, std::uint32_t{1} << 31, "trace"};

}  // namespace

TraceJournalContent parse_trace_journal(const std::string& path, std::string_view bytes)
{
  std::map<StepKey, SearchTrace> searches;
  FrameFileSummary summary = parse_frames(path, bytes, format, [&](std::string_view frame) -> std::string {
    std::optional<SearchTrace> trace = core::value_of_bytes<SearchTrace>(frame);
    if (!trace) return "a trace that is not a search";
    const StepKey key = trace->key;
    searches.insert_or_assign(key, std::move(*trace));
    return {};
  });
  return {std::move(summary), std::move(searches)};
}

TraceJournalContent read_trace_journal(const std::string& path)
{
  return parse_trace_journal(path, read_frame_file(path));
}

FrameTail trace_journal_tail(const std::string& path)
{
  return FrameTail(path, format);
}

FrameWriter create_trace_journal(const std::string& path, const std::string& key)
{
  return FrameWriter::create(path, key, format);
}

FrameWriter resume_trace_journal(const std::string& path, const FrameFileSummary& facts)
{
  return FrameWriter::resume(path, facts.valid_bytes, format);
}

}  // namespace vrda::store
