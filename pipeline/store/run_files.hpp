/// Names of the files that a run keeps next to its output until that is complete.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace vrda::store {

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

}  // namespace vrda::store
