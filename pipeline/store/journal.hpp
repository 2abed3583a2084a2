/// The append-only journal of finished motion steps, from which a killed run resumes.
/// File: frames of framed_file.hpp, one per step; doubles as their 64 bits.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "model/step_record.hpp"
#include "core/frame_tail.hpp"
#include "core/framed_file.hpp"

namespace vrda::store {

struct JournalContent {
  std::string key;                  ///< of the job that wrote it
  std::vector<StepRecord> records;  ///< in the order of completion
  std::uint64_t valid_bytes = 0;    ///< header and valid records
  std::uint64_t dropped_bytes = 0;  ///< the rest
  std::string dropped_reason;       ///< empty: nothing was dropped
};

/// The valid prefix of a journal's bytes; a damaged or torn tail is reported, not thrown. Throws InputError
/// with `path` if they are not a journal, have another format version or a damaged header.
JournalContent parse_journal(const std::string& path, std::string_view bytes);

/// parse_journal() of a file's bytes. Throws InputError also if the file cannot be read.
JournalContent read_journal(const std::string& path);

/// Reads a growing journal; record_of() (record_bytes.hpp) parses its frames.
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

}  // namespace vrda::store
