/// Which rows of a grid one task of many solves, and where it writes.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace vrda {

struct Shard {
  std::int32_t number = 1;  ///< from 1 to count
  std::int32_t count = 1;

  bool operator==(const Shard&) const = default;
};

/// "3/8". Throws InputError whose file is "--shard".
Shard shard_of(const std::string& text);

/// The rows, dealt out in turn: i with i % count == number - 1. None for the last ones of more shards than
/// rows.
std::vector<std::int32_t> rows_of(const Shard& shard, std::int32_t n_rows);

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

}  // namespace vrda
