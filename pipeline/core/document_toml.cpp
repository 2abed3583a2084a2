// TOML text to DocumentValue, and the overrides of --set.
#include <toml++/toml.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <sstream>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "core/text.hpp"
#include "core/depth.hpp"
#include "core/document.hpp"

namespace vrda::inline core {
namespace {

struct KeyContext {
  std::string file;
  std::string key;

  KeyContext child(const std::string& name) const { return {file, key.empty() ? name : key + "." + name}; }
  [[noreturn]] void refuse(const toml::node& node, const std::string& found, const std::string& wanted) const
  {
    throw InputError({file, key, found, wanted, static_cast<int>(node.source().begin.line)});
  }
};

DocumentValue value_of(const toml::node& node, const KeyContext& at);

// toml++ sorts keys by name. The order of the text is restored: it is the order of a campaign's axes.
DocumentValue table_of(const toml::table& table, const KeyContext& at)
{
  std::vector<std::pair<toml::source_position, DocumentEntry>> entries;
  for (const auto& [key, node] : table) {
    const std::string name(key.str());
    entries.push_back({node.source().begin, {name, value_of(node, at.child(name))}});
  }
  std::stable_sort(entries.begin(), entries.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  DocumentValue::Table in_order;
  for (auto& [position, entry] : entries) in_order.push_back(std::move(entry));
  return {in_order};
}

DocumentValue list_of(const toml::array& array, const KeyContext& at)
{
  DocumentValue::List items;
  for (const toml::node& node : array)
    items.push_back(value_of(node, at.child(std::to_string(items.size()))));
  return {items};
}

DocumentValue plain_value_of(const toml::node& node, const KeyContext& at)
{
  if (const toml::table* table = node.as_table()) return table_of(*table, at);
  if (const toml::array* array = node.as_array()) return list_of(*array, at);
  if (const auto* flag = node.as_boolean()) return {flag->get()};
  if (const auto* integer = node.as_integer()) return {integer->get()};
  if (const auto* number = node.as_floating_point()) {
    if (std::isnan(number->get())) at.refuse(node, "nan", "a number");
    return {number->get()};
  }
  const auto* text = node.as_string();
  if (text == nullptr) at.refuse(node, "a date or time", "text, a number, true or false, a list or a table");
  if (has_control_characters(text->get(), "\t\n"))
    at.refuse(node, "a text with control characters", "text without control characters");
  return {text->get()};
}

DocumentValue value_of(const toml::node& node, const KeyContext& at)
{
  DocumentValue value = plain_value_of(node, at);
  value.line = static_cast<int>(node.source().begin.line);
  return value;
}

// An unquoted word, as written in a shell: +X, left, meshes/femur.stl
bool is_plain_word(const std::string& text)
{
  return !text.empty() && text.find_first_of("\"'[]{}=,#\n\r\t") == std::string::npos;
}

DocumentValue override_value(const std::string& text, const std::string& key)
{
  try {
    const toml::table table = toml::parse("value = " + text);
    if (table.size() == 1) return plain_value_of(*table.get("value"), {"--set", key});
  } catch (const toml::parse_error&) {
    if (is_plain_word(text)) return {text};
  }
  throw InputError(
      {"--set", key, text.empty() ? "nothing" : text, "one value in TOML syntax, or one plain word"});
}

// The value of `name` in a table (added if missing), or the list item with that index.
DocumentValue& step_into(DocumentValue& value, const std::string& name, const std::string& key)
{
  if (auto* list = std::get_if<DocumentValue::List>(&value.data)) {
    std::size_t index = 0;
    const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), index);
    if (error != std::errc() || end != name.data() + name.size() || index >= list->size()) {
      throw InputError({"--set", key, "\"" + name + "\" within a list",
                        list->empty() ? "no key: the list is empty"
                                      : "a number from 0 to " + std::to_string(list->size() - 1)});
    }
    return (*list)[index];
  }
  auto* table = std::get_if<DocumentValue::Table>(&value.data);
  if (table == nullptr)
    throw InputError({"--set", key, "\"" + name + "\" within " + shown(value), "the key of a table"});
  const auto found =
      std::find_if(table->begin(), table->end(), [&](const DocumentEntry& e) { return e.key == name; });
  if (found != table->end()) return found->value;
  table->push_back({name, DocumentValue{DocumentValue::Table{}}});
  return table->back().value;
}

}  // namespace

DocumentValue parse_toml(std::string_view text, const std::string& file)
{
  require_shallow(text, file, Syntax::toml);
  try {
    const toml::table table = toml::parse(text);
    return table_of(table, {file, ""});
  } catch (const toml::parse_error& error) {
    const toml::source_position at = error.source().begin;
    throw InputError({file, "line " + std::to_string(at.line) + ", column " + std::to_string(at.column),
                      std::string(error.description()), "valid TOML"});
  }
}

void apply_override(Document& document, const std::string& assignment)
{
  const std::size_t equals = assignment.find('=');
  const std::string key = assignment.substr(0, equals);
  const bool has_key =
      !key.empty() && key.front() != '.' && key.back() != '.' && key.find("..") == std::string::npos;
  if (equals == std::string::npos || !has_key) {
    throw InputError({"--set", "", "\"" + assignment + "\"", "key.path=value"});
  }
  require_shallow_override(key, assignment.substr(equals + 1));
  DocumentValue given = override_value(assignment.substr(equals + 1), key);
  DocumentValue* value = &document.root;
  std::istringstream names(key);
  for (std::string name; std::getline(names, name, '.');) value = &step_into(*value, name, key);
  *value = std::move(given);
  document.overridden.push_back(key);
}

}  // namespace vrda::inline core
