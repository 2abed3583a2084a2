#include "cluster/shard.hpp"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <string_view>
#include <tuple>

#include "core/error.hpp"

namespace vrda {
namespace {

namespace fs = std::filesystem;

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

// "3/8" or, within a name, "3-of-8".
std::optional<Shard> parsed(std::string_view text, std::string_view separator)
{
  const std::size_t at = text.find(separator);
  if (at == std::string_view::npos) return std::nullopt;
  const auto number = count_in(text.substr(0, at));
  const auto count = count_in(text.substr(at + separator.size()));
  if (!number || !count || *number > *count) return std::nullopt;
  return Shard{*number, *count};
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
  const auto shard = parsed(stem.substr(mark + shard_mark.size()), between);
  if (!shard) return std::nullopt;
  return JournalName{std::string(stem.substr(0, mark)), *shard};
}

}  // namespace

Shard shard_of(const std::string& text)
{
  if (const auto shard = parsed(text, "/")) return *shard;
  throw InputError({"--shard", "", text.empty() ? "nothing" : text, "I/N with I from 1 to N, as 3/8"});
}

std::vector<std::int32_t> rows_of(const Shard& shard, std::int32_t n_rows)
{
  check(shard.number >= 1 && shard.number <= shard.count, "a shard's number is from 1 to their count");
  std::vector<std::int32_t> rows;
  for (std::int32_t i = shard.number - 1; i < n_rows; i += shard.count) rows.push_back(i);
  return rows;
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

std::vector<std::string> shard_journals_beside(const std::string& output)
{
  const fs::path folder = fs::path(output).has_parent_path() ? fs::path(output).parent_path() : ".";
  std::vector<std::tuple<std::int32_t, std::int32_t, std::string>> found;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    const std::string path = (fs::path(output).parent_path() / it->path().filename()).string();
    const auto name = shard_journal_name(path);
    if (name && name->output == output) found.emplace_back(name->shard.count, name->shard.number, path);
  }
  if (error) throw InputError({folder.string(), "", error.message(), "a folder that can be read"});
  std::sort(found.begin(), found.end());
  std::vector<std::string> paths;
  for (const auto& [count, number, path] : found) paths.push_back(path);
  return paths;
}

}  // namespace vrda
