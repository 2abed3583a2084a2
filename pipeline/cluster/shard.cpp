#include "cluster/shard.hpp"

#include "core/error.hpp"

namespace vrda {

Shard shard_of(const std::string& text)
{
  if (const auto shard = parsed_shard(text, "/")) return *shard;
  throw InputError({"--shard", "", text.empty() ? "nothing" : text, "I/N with I from 1 to N, as 3/8"});
}

std::vector<std::int32_t> rows_of(const Shard& shard, std::int32_t n_rows)
{
  check(shard.number >= 1 && shard.number <= shard.count, "a shard's number is from 1 to their count");
  std::vector<std::int32_t> rows;
  for (std::int32_t i = shard.number - 1; i < n_rows; i += shard.count) rows.push_back(i);
  return rows;
}

}  // namespace vrda
