/// Which rows of a grid one task of many solves.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "journal/run_files.hpp"

namespace vrda {

/// "3/8". Throws InputError whose file is "--shard".
Shard shard_of(const std::string& text);

/// The rows, dealt out in turn: i with i % count == number - 1. None for the last ones of more shards than
/// rows.
std::vector<std::int32_t> rows_of(const Shard& shard, std::int32_t n_rows);

}  // namespace vrda
