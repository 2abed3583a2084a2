/// The append-only journal of finished motion steps, from which a killed run resumes.
/// File: frames of framed_file.hpp, one per step: bytes_of_value() of its StepRecord (mm and rad, frame S).
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/framed_file.hpp"
#include "model/step_record.hpp"

namespace vrda::store {

struct JournalContent : FrameFileSummary {
  std::vector<StepRecord> records;  ///< in the order of completion
};

/// The valid prefix of a journal's bytes; a damaged or torn tail is reported, not thrown. Throws InputError
/// with `path` if they are not a journal, have another format version or a damaged header.
JournalContent parse_journal(const std::string& path, std::string_view bytes);

/// parse_journal() of a file's bytes. Throws InputError also if the file cannot be read.
JournalContent read_journal(const std::string& path);

/// Reads a growing journal; value_of_bytes<StepRecord>() parses its frames.
FrameTail journal_tail(const std::string& path);

/// Throws InputError with the file and both keys if a journal is of another job.
void require_key(const std::string& found, const std::string& path, const std::string& wanted);

struct OpenJournal;

/// Appends to one journal, which it locks: a second writer of the same file gets an InputError.
class JournalWriter {
 public:
  /// Creates an empty journal atomically, replacing an existing one.
  /// `key`: hexadecimal SHA-256 of the resolved job, the meshes and the solver's version.
  static JournalWriter create(const std::string& path, const std::string& key);

  /// Resumes the journal at `path`, or starts one; cuts off a damaged tail. Empty if another process writes
  /// it or has just removed it. Throws like read_journal() and require_key().
  static std::optional<OpenJournal> try_open(const std::string& path, const std::string& key);
  /// The same, but throws InputError if another process writes it.
  static OpenJournal open(const std::string& path, const std::string& key);

  /// See FrameWriter.
  void append(const StepRecord& record);
  void flush() { file_.flush(); }
  void close() { file_.close(); }
  bool is_in_place() const { return file_.is_in_place(); }
  void restore() const { file_.restore(); }
  void sync_every(std::chrono::steady_clock::duration interval) { file_.sync_every(interval); }
  std::uint64_t n_unsynced_bytes() const { return file_.n_unsynced_bytes(); }

 private:
  explicit JournalWriter(FrameWriter file) : file_(std::move(file)) {}

  FrameWriter file_;
};

/// A journal to append to, and its content when it was locked.
struct OpenJournal {
  JournalWriter writer;
  JournalContent content;
};

// Names of the files that a run keeps next to its output until that is complete.

std::string journal_of(const std::string& output);
std::string trace_journal_of(const std::string& output);
std::string start_file_of(const std::string& output);

/// The inverse of start_file_of(); empty if the name does not match.
std::string output_of_start_file(const std::string& start_file);

/// One of several tasks that share a grid.
struct Shard {
  std::int32_t number = 1;  ///< from 1 to count
  std::int32_t count = 1;

  bool operator==(const Shard&) const = default;
};

/// Parses "3/8", or with another separator; empty if the text does not match.
std::optional<Shard> parse_shard(std::string_view text, std::string_view separator);

/// "<output>.spine.journal" and "<output>.shard-3-of-8.journal".
std::string spine_journal_of(const std::string& output);
std::string shard_journal_of(const std::string& output, const Shard& shard);

/// The shard that wrote `journal`, from its name; empty if the name does not match.
std::optional<Shard> shard_of_journal(const std::string& journal);

/// The output whose spine or shard wrote `journal`, from its name; empty if the name does not match.
std::string output_of_journal(const std::string& journal);

/// The journals of all shards next to `output`, for any count, sorted by count and number. Throws InputError
/// if the folder cannot be read.
std::vector<std::string> list_shard_journals(const std::string& output);

/// The same without errors: an empty list if the folder cannot be read.
std::vector<std::string> list_shard_journals_if_readable(const std::string& output);

// The append-only journal of finished searches with all their moves, so that a resumed run has a complete
// trace. File: frames of framed_file.hpp, one per search: bytes_of_value() of its SearchTrace.

struct TraceJournalContent : FrameFileSummary {
  std::map<StepKey, SearchTrace> searches;  ///< the last of each key
};

/// The valid prefix of a journal's bytes; a damaged or torn tail is reported, not thrown. Throws InputError
/// with `path` if they are not a journal of traces, have another format version or a damaged header.
TraceJournalContent parse_trace_journal(const std::string& path, std::string_view bytes);

/// parse_trace_journal() of a file's bytes. Throws InputError also if the file cannot be read.
TraceJournalContent read_trace_journal(const std::string& path);

/// Reads a growing journal; value_of_bytes<SearchTrace>() parses its frames.
FrameTail trace_journal_tail(const std::string& path);

/// Like JournalWriter::create() and resuming one.
FrameWriter create_trace_journal(const std::string& path, const std::string& key);
FrameWriter resume_trace_journal(const std::string& path, const FrameFileSummary& facts);

}  // namespace vrda::store
