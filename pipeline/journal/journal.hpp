/// The append-only record of finished motion steps: what lets a killed run go on.
///
/// File: a header (magic, format version, key, CRC-32), then one frame a step: length, CRC-32 of length and
/// content, content. All integers little-endian, doubles as their 64 bits.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "core/step_record.hpp"

namespace vrda {

struct JournalContent {
  std::string key;                  ///< of the job that wrote it
  std::vector<StepRecord> records;  ///< in the order of finishing
  std::uint64_t valid_bytes = 0;    ///< header and whole records
  std::uint64_t dropped_bytes = 0;  ///< what follows them
  std::string dropped_why;          ///< empty: nothing was dropped
};

/// The valid prefix of a journal's bytes; a damaged or torn tail is reported, not thrown. Throws InputError
/// naming `path` when they are no journal, of another format version or have a damaged header.
JournalContent parse_journal(const std::string& path, std::string_view bytes);

/// parse_journal() of a file's bytes. Throws InputError also when the file cannot be read.
JournalContent read_journal(const std::string& path);

/// Throws InputError naming the file, the key found and the key wanted when the journal is of another job.
void require_key(const JournalContent& content, const std::string& path, const std::string& key);

/// Appends to one journal. The file is locked: a second writer of the same file gets an InputError.
class JournalWriter {
 public:
  /// Starts an empty journal, replacing what is there; the header appears whole or not at all.
  /// `key`: hexadecimal SHA-256 of the resolved job, the meshes and the solver's version.
  static JournalWriter create(const std::string& path, const std::string& key);

  /// Goes on after `content` as read from `path`; cuts a dropped tail off. Check the key first.
  static JournalWriter resume(const std::string& path, const JournalContent& content);

  ~JournalWriter();
  JournalWriter(const JournalWriter&) = delete;
  JournalWriter& operator=(const JournalWriter&) = delete;

  /// Hands one record to the system in one write; from then on a kill of the process cannot lose it. Waits
  /// for the disk when the last wait is sync_every() ago, so that a power cut loses no more than that.
  /// Any thread may call. Throws InputError when the disk is full or gone; what was written stays valid.
  /// Throws one too when the file was deleted or moved meanwhile; the record is in it even then.
  void append(const StepRecord& record);

  /// Waits until everything has reached the disk, so that a power cut cannot lose it. Throws like append().
  void flush();

  /// 5 s unless told: an fdatasync takes milliseconds, on a slow network disk tenths of a second.
  void sync_every(std::chrono::steady_clock::duration interval) { sync_interval_ = interval; }
  /// Bytes that append() has not waited for.
  std::uint64_t n_unsynced_bytes() const { return n_bytes_ - n_synced_bytes_; }

  /// Whether the path still leads to this file: an open file lives on when its folder is deleted or moved.
  bool is_in_place() const;

  /// Makes the folder and the file anew with all that was appended. Throws InputError when another file
  /// stands there, or when it cannot be written. Nothing may be appended afterwards.
  void restore() const;

  /// flush() and let go of the file. Nothing may be appended afterwards.
  void close();

 private:
  JournalWriter(std::string path, int descriptor, std::uint64_t n_bytes);

  void write(std::string_view frame);
  void sync_when_due();
  void require_in_place() const;

  std::string path_;
  std::mutex mutex_;
  int descriptor_;
  bool had_name_;                              ///< some file systems count no names of a file
  std::atomic<std::uint64_t> n_bytes_;         ///< header and whole records
  std::atomic<std::uint64_t> n_synced_bytes_;  ///< of them on the disk
  std::chrono::steady_clock::duration sync_interval_ = std::chrono::seconds(5);
  std::chrono::steady_clock::time_point synced_ = std::chrono::steady_clock::now();
};

}  // namespace vrda
