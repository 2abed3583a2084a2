#include "support/refusal_table.hpp"

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <stdexcept>

#include "support/messages.hpp"

namespace vrda::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::size_t longest_name = 40;
// A gigabyte: no refusal needs what a few bytes promise.
constexpr long absurd_kb = 1L << 20;

template <typename Number>
std::string bytes_of(const json& numbers)
{
  std::string bytes;
  for (const json& one : numbers) {
    const auto value = one.get<Number>();
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  return bytes;
}

std::string content_of(const json& part)
{
  if (part.is_string()) return part.get<std::string>();
  std::string bytes;
  if (part.is_array()) {
    for (const json& one : part) bytes += content_of(one);
    return bytes;
  }
  if (part.contains("u8")) return bytes_of<std::uint8_t>(part["u8"]);
  if (part.contains("u32")) return bytes_of<std::uint32_t>(part["u32"]);
  if (part.contains("f32")) return bytes_of<float>(part["f32"]);
  for (int k = 0; k < part.at("times").get<int>(); ++k) {
    std::string text = part.at("repeat").get<std::string>();
    const std::size_t number = text.find('#');
    bytes += number == std::string::npos ? text : text.replace(number, 1, std::to_string(k));
  }
  return bytes;
}

/// One text or a list of them.
std::vector<std::string> list_of(const json& row, const char* key)
{
  if (!row.contains(key)) return {};
  const json& value = row[key];
  return value.is_array() ? value.get<std::vector<std::string>>() : std::vector{value.get<std::string>()};
}

Values values_of(const json& row, const char* key)
{
  Values values;
  values.all = list_of(row, key);
  return values;
}

std::string name_from(const std::string& text)
{
  std::string name;
  for (const char c : text.substr(0, longest_name))
    name += std::isalnum(static_cast<unsigned char>(c)) != 0 ? c : '_';
  return name;
}

void require_known_keys(const json& row)
{
  static const std::set<std::string> known{
      "name",   "rows",   "scene",   "files", "write", "file",  "target", "text",   "edit",      "cut",
      "append", "remove", "command", "add",   "field", "found", "wanted", "writes", "exit_code", "names"};
  for (const auto& [key, value] : row.items()) {
    if (known.count(key) == 0) throw std::runtime_error("unknown key of a refusal: " + key);
  }
}

/// `number`: of the row in its group, from 1.
RefusalRow row_of(const json& group, const json& own, int number)
{
  json row = group;
  row.update(own);
  require_known_keys(row);
  RefusalRow out;
  out.name = name_from(group.at("name").get<std::string>()) + "_" + std::to_string(number) + "_" +
             name_from(own.value("name", row.value("field", "")));
  out.scene = row.value("scene", "");
  out.target = row.value("target", row.value("file", ""));
  for (const char* key : {"files", "write"}) {
    const json files = row.value(key, json::object());
    for (const auto& [name, content] : files.items()) out.files.emplace_back(name, content_of(content));
  }
  if (row.contains("text")) out.files.emplace_back(out.target, content_of(row["text"]));
  json edits = row.value("edit", json::array());
  if (!edits.empty() && edits[0].is_string()) edits = json::array({edits});
  for (const json& edit : edits) out.edits.emplace_back(edit.at(0), edit.at(1));
  out.cut_bytes = row.value("cut", 0L);
  out.appended = row.contains("append") ? content_of(row["append"]) : "";
  out.removed = row.value("remove", "");
  out.words = row.at("command").get<std::vector<std::string>>();
  std::replace(out.words.begin(), out.words.end(), std::string("{file}"), out.target);
  for (const std::string& word : list_of(row, "add")) out.words.push_back(word);
  out.writes = list_of(row, "writes");
  out.refusal = {row.value("file", out.target), row.value("field", ""), values_of(row, "found"),
                 values_of(row, "wanted")};
  out.exit_code = row.value("exit_code", 0);
  out.names = values_of(row, "names");
  return out;
}

void spoil_target(const RefusalRow& row, const Scratch& scratch)
{
  const bool is_changed = !row.edits.empty() || row.cut_bytes != 0 || !row.appended.empty();
  if (!is_changed) return;
  std::string bytes = read_bytes(scratch.path() / row.target);
  for (const auto& [from, to] : row.edits) {
    const std::size_t at = bytes.find(from);
    if (at == std::string::npos) throw std::runtime_error("not in " + row.target + ": " + from);
    bytes.replace(at, from.size(), to);
  }
  if (row.cut_bytes != 0)
    bytes.resize(static_cast<std::size_t>(row.cut_bytes) + (row.cut_bytes < 0 ? bytes.size() : 0));
  scratch.write(row.target, bytes + row.appended);
}

void make_input(const RefusalRow& row, const Scratch& scratch, const Scenes& scenes)
{
  if (!row.scene.empty()) scenes.at(row.scene)(scratch);
  for (const auto& [name, bytes] : row.files) scratch.write(name, bytes);
  spoil_target(row, scratch);
  if (!row.removed.empty()) fs::remove(scratch.path() / row.removed);
}

/// Path below the folder and bytes of each file; a folder has none.
std::map<std::string, std::string> files_in(const fs::path& folder)
{
  std::map<std::string, std::string> files;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder))
    files[fs::relative(entry.path(), folder)] = entry.is_regular_file() ? read_bytes(entry.path()) : "";
  return files;
}

/// Lines of the program's own name; others are warnings and progress.
std::ptrdiff_t n_messages(const std::string& said, const std::string& start)
{
  std::istringstream lines(said);
  std::ptrdiff_t n = 0;
  for (std::string line; std::getline(lines, line);) n += line.starts_with(start) ? 1 : 0;
  return n;
}

}  // namespace

std::vector<RefusalRow> read_refusals(const fs::path& file)
{
  std::vector<RefusalRow> rows;
  for (const json& group : json::parse(read_bytes(file))) {
    json defaults = group;
    defaults.erase("rows");
    int number = 0;
    for (const json& row : group.at("rows")) rows.push_back(row_of(defaults, row, ++number));
  }
  return rows;
}

void expect_row_refused(const RefusalRow& row, const fs::path& program, const Scenes& scenes)
{
  const Scratch scratch;
  make_input(row, scratch, scenes);
  const auto before = files_in(scratch.path());
  const Ended ended = run({program, row.words, {}, scratch.path()});
  EXPECT_THAT(ended, refuses(row.refusal));
  EXPECT_EQ(n_messages(ended.err, program.filename().string() + ": "), 1) << ended.err;
  EXPECT_EQ(ended.out, "");
  EXPECT_LT(ended.peak_kb, absurd_kb);
  auto after = files_in(scratch.path());
  for (const std::string& name : row.writes) EXPECT_EQ(after.erase(name), 1U) << name;
  EXPECT_TRUE(after == before) << "a file was written or changed";
}

void expect_row_answered(const RefusalRow& row, const fs::path& program, const Scenes& scenes)
{
  const Scratch scratch;
  make_input(row, scratch, scenes);
  const Ended ended = run({program, row.words, {}, scratch.path()});
  EXPECT_EQ(ended.exit_code, row.exit_code) << ended.err;
  EXPECT_THAT(ended.out + ended.err, has_line(Message{row.refusal.field, row.names, row.exit_code == 0}));
}

}  // namespace vrda::test
