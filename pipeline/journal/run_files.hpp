/// The names of what a run keeps beside its output until that is whole.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace vrda {

std::string journal_of(const std::string& output);
std::string trace_journal_of(const std::string& output);
std::string start_file_of(const std::string& output);

/// The inverse of start_file_of(); empty when the name is not of that form.
std::string output_of_start_file(const std::string& start_file);

/// One task of many that share a grid.
struct Shard {
  std::int32_t number = 1;  ///< from 1 to count
  std::int32_t count = 1;

  bool operator==(const Shard&) const = default;
};

/// "3/8", or with another separator; nothing when it is not of that form.
std::optional<Shard> parsed_shard(std::string_view text, std::string_view separator);

/// "<output>.spine.journal" and "<output>.shard-3-of-8.journal".
std::string spine_journal_of(const std::string& output);
std::string shard_journal_of(const std::string& output, const Shard& shard);

/// The shard that wrote `journal`, by its name; nothing when the name is not of that form.
std::optional<Shard> shard_of_journal(const std::string& journal);

/// The output whose spine or shard wrote `journal`; empty when the name is not of that form.
std::string output_of_journal(const std::string& journal);

/// Every journal of shards beside `output`, whatever their count, by count and number. Throws InputError when
/// the folder cannot be read.
std::vector<std::string> shard_journals_beside(const std::string& output);

/// The same for those who look on: none while the folder cannot be read.
std::vector<std::string> shard_journals_in_sight(const std::string& output);

}  // namespace vrda
