#include "settings/settings_table.hpp"

#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <optional>
#include <sstream>

#include "core/error.hpp"
#include "core/text.hpp"

namespace vrda {
namespace {

/// Settings are some pages of text; a calibration keeps some ten thousand places besides.
constexpr std::size_t most_bytes = 8000000;
constexpr std::size_t longest_text = 4096;

std::string text_of(const toml::array& list)
{
  std::ostringstream text;
  for (const toml::node& item : list)
    text << (&item == list.get(0) ? "[" : ", ") << toml::node_view<const toml::node>(item);
  return list.empty() ? "[]" : text.str() + "]";
}

std::string range_text(const NumberRange& range)
{
  return "from " + shortest(range.least) + " to " + shortest(range.most);
}

bool is_plain(const std::string& text)
{
  return std::none_of(text.begin(), text.end(),
                      [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7F; });
}

/// What stands at a key, for a message.
std::string found_at(const toml::table& table, std::string_view name)
{
  const toml::node* node = table.get(name);
  if (node == nullptr) return "nothing";
  if (const toml::array* list = node->as_array()) return text_of(*list);
  if (node->is_table()) return "a table";
  std::ostringstream text;
  text << toml::node_view<const toml::node>(node);
  return text.str();
}

/// The numbers of a list of up to `most`; nothing where it is no such list.
std::optional<std::vector<double>> numbers_of(const toml::node* node, std::size_t most,
                                              const NumberRange& range)
{
  const toml::array* list = node != nullptr ? node->as_array() : nullptr;
  if (list == nullptr || list->size() > most) return std::nullopt;
  std::vector<double> values;
  for (const toml::node& item : *list) {
    const std::optional<double> value = item.value<double>();
    if (!value || !(*value >= range.least && *value <= range.most)) return std::nullopt;
    values.push_back(*value);
  }
  return values;
}

}  // namespace

std::string settings_file_text(const std::string& path, const std::string& what)
{
  std::ifstream file(path, std::ios::binary);
  if (!file) throw InputError({path, "", "no file that can be read", what});
  std::string text(most_bytes + 1, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (file.bad()) throw InputError({path, "", "no file that can be read", what});
  text.resize(static_cast<std::size_t>(file.gcount()));
  if (text.size() > most_bytes)
    throw InputError({path, "", "more than " + std::to_string(most_bytes) + " bytes", what});
  return text;
}

struct SettingsTable::File {
  std::string name;
  toml::table root;
};

struct SettingsTable::Node {
  const toml::table* table = nullptr;
  std::string key;
};

SettingsTable::SettingsTable(std::shared_ptr<const File> file, std::shared_ptr<const Node> node)
    : file_(std::move(file)), node_(std::move(node))
{
}

SettingsTable SettingsTable::parsed(const std::string& text, const std::string& name)
{
  try {
    auto file = std::make_shared<const File>(File{name, toml::parse(text)});
    auto node = std::make_shared<const Node>(Node{&file->root, ""});
    return {std::move(file), std::move(node)};
  } catch (const toml::parse_error& error) {
    const toml::source_position at = error.source().begin;
    throw InputError({name, "line " + std::to_string(at.line) + ", column " + std::to_string(at.column),
                      std::string(error.description()), "valid TOML"});
  }
}

SettingsTable SettingsTable::read(const std::string& path, const std::string& what)
{
  return parsed(settings_file_text(path, what), path);
}

const std::string& SettingsTable::file() const
{
  return file_->name;
}

std::string SettingsTable::place_of(std::string_view name) const
{
  return node_->key.empty() ? std::string(name) : node_->key + "." + std::string(name);
}

void SettingsTable::refuse(std::string_view name, const std::string& found, const std::string& wanted) const
{
  throw InputError({file_->name, place_of(name), found, wanted});
}

void SettingsTable::require_known(std::initializer_list<const char*> names) const
{
  const std::vector<std::string> known(names.begin(), names.end());
  for (const auto& [key, value] : *node_->table) {
    const std::string name(key.str());
    if (std::find(known.begin(), known.end(), name) != known.end()) continue;
    refuse(name, "an unknown key", "such a key as " + nearest_word(name, known));
  }
}

bool SettingsTable::has(std::string_view name) const
{
  return node_->table->contains(name);
}

double SettingsTable::number(std::string_view name, const NumberRange& range) const
{
  const toml::node* node = node_->table->get(name);
  const std::optional<double> value = node != nullptr ? node->value<double>() : std::nullopt;
  if (!value || !(*value >= range.least && *value <= range.most))
    refuse(name, found_at(*node_->table, name), "a number " + range_text(range));
  return *value;
}

double SettingsTable::number_or(std::string_view name, double otherwise, const NumberRange& range) const
{
  return has(name) ? number(name, range) : otherwise;
}

int SettingsTable::whole(std::string_view name, const NumberRange& range) const
{
  const double value = number(name, range);
  if (value != std::floor(value))
    refuse(name, found_at(*node_->table, name), "a whole number " + range_text(range));
  return static_cast<int>(value);
}

int SettingsTable::whole_or(std::string_view name, int otherwise, const NumberRange& range) const
{
  return has(name) ? whole(name, range) : otherwise;
}

bool SettingsTable::flag_or(std::string_view name, bool otherwise) const
{
  if (!has(name)) return otherwise;
  const std::optional<bool> value = node_->table->get(name)->value_exact<bool>();
  if (!value) refuse(name, found_at(*node_->table, name), "true or false");
  return *value;
}

std::string SettingsTable::text(std::string_view name) const
{
  const toml::node* node = node_->table->get(name);
  const std::optional<std::string> value =
      node != nullptr ? node->value_exact<std::string>() : std::optional<std::string>();
  if (!value || value->empty() || value->size() > longest_text || !is_plain(*value))
    refuse(name, found_at(*node_->table, name), "a line of text in quotes");
  return *value;
}

std::string SettingsTable::text_or(std::string_view name, const std::string& otherwise) const
{
  return has(name) ? text(name) : otherwise;
}

std::size_t SettingsTable::word(std::string_view name, const std::vector<std::string>& words) const
{
  std::string known;
  for (const std::string& word : words) known += (known.empty() ? "" : ", ") + word;
  const toml::node* node = node_->table->get(name);
  const std::optional<std::string> value =
      node != nullptr ? node->value_exact<std::string>() : std::optional<std::string>();
  const auto found = value ? std::find(words.begin(), words.end(), *value) : words.end();
  if (found == words.end()) refuse(name, found_at(*node_->table, name), "one of " + known);
  return static_cast<std::size_t>(found - words.begin());
}

std::vector<double> SettingsTable::numbers(std::string_view name, std::size_t n,
                                           const NumberRange& range) const
{
  std::optional<std::vector<double>> values = numbers_of(node_->table->get(name), n, range);
  if (!values || values->size() != n)
    refuse(name, found_at(*node_->table, name), std::to_string(n) + " numbers " + range_text(range));
  return *std::move(values);
}

std::vector<std::vector<double>> SettingsTable::rows(std::string_view name, std::size_t n,
                                                     const NumberRange& range) const
{
  const auto wrong = [&] {
    refuse(name, found_at(*node_->table, name),
           "a list of rows of " + std::to_string(n) + " numbers " + range_text(range));
  };
  const toml::node* node = node_->table->get(name);
  const toml::array* list = node != nullptr ? node->as_array() : nullptr;
  if (list == nullptr || list->empty()) wrong();
  std::vector<std::vector<double>> rows;
  for (const toml::node& item : *list) {
    std::optional<std::vector<double>> row = numbers_of(&item, n, range);
    if (!row || row->size() != n) wrong();
    rows.push_back(*std::move(row));
  }
  return rows;
}

std::vector<double> SettingsTable::list(std::string_view name, std::size_t most,
                                        const NumberRange& range) const
{
  std::optional<std::vector<double>> values = numbers_of(node_->table->get(name), most, range);
  if (!values) {
    refuse(name, found_at(*node_->table, name),
           "a list of up to " + std::to_string(most) + " numbers " + range_text(range));
  }
  return *std::move(values);
}

std::vector<std::vector<double>> SettingsTable::lists(std::string_view name, std::size_t most,
                                                      std::size_t most_across, const NumberRange& range) const
{
  const auto wrong = [&](const std::string& found) {
    refuse(name, found,
           "a list of up to " + std::to_string(most) + " rows, each of up to " + std::to_string(most_across) +
               " numbers " + range_text(range));
  };
  const toml::node* node = node_->table->get(name);
  const toml::array* list = node != nullptr ? node->as_array() : nullptr;
  if (list == nullptr) wrong(found_at(*node_->table, name));
  if (list->size() > most) wrong(std::to_string(list->size()) + " rows");
  std::vector<std::vector<double>> rows;
  for (const toml::node& item : *list) {
    std::optional<std::vector<double>> row = numbers_of(&item, most_across, range);
    if (!row) wrong("row " + std::to_string(rows.size() + 1) + ", which is none");
    rows.push_back(*std::move(row));
  }
  return rows;
}

std::vector<std::string> SettingsTable::texts(std::string_view name) const
{
  const auto wrong = [&] { refuse(name, found_at(*node_->table, name), "a list of texts in quotes"); };
  const toml::node* node = node_->table->get(name);
  const toml::array* list = node != nullptr ? node->as_array() : nullptr;
  if (list == nullptr) wrong();
  std::vector<std::string> texts;
  for (const toml::node& item : *list) {
    const std::optional<std::string> value = item.value_exact<std::string>();
    if (!value || value->empty() || value->size() > longest_text || !is_plain(*value)) wrong();
    texts.push_back(*value);
  }
  return texts;
}

SettingsTable SettingsTable::table(std::string_view name) const
{
  const toml::node* node = node_->table->get(name);
  const toml::table* found = node != nullptr ? node->as_table() : nullptr;
  if (found == nullptr) refuse(name, node != nullptr ? "no table" : "nothing", "a table");
  return {file_, std::make_shared<const Node>(Node{found, place_of(name)})};
}

std::vector<SettingsTable> SettingsTable::tables(std::string_view name, std::size_t most) const
{
  std::vector<SettingsTable> tables;
  if (!has(name)) return tables;
  const std::string wanted = "a list of tables: [[" + std::string(name) + "]]";
  const toml::array* list = node_->table->get(name)->as_array();
  if (list == nullptr) refuse(name, "no list", wanted);
  if (list->size() > most)
    refuse(name, std::to_string(list->size()) + " tables", "at most " + std::to_string(most));
  for (std::size_t i = 0; i < list->size(); ++i) {
    const toml::table* item = (*list)[i].as_table();
    if (item == nullptr) refuse(name, "an item that is no table", wanted);
    tables.push_back(SettingsTable(
        file_, std::make_shared<const Node>(Node{item, place_of(name) + "." + std::to_string(i)})));
  }
  return tables;
}

}  // namespace vrda
