#include "core/value.hpp"

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "core/text.hpp"

namespace vrda::inline core {
namespace {

bool is_bare(const std::string& key)
{
  constexpr std::string_view bare = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_-";
  return !key.empty() && key.find_first_not_of(bare) == std::string::npos;
}

std::string quoted(const std::string& text)
{
  constexpr std::string_view hex = "0123456789ABCDEF";
  std::string out = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      out += '\\';
      out += c;
    } else if (byte < 0x20 || byte == 0x7f) {
      out += "\\u00";
      out += hex[byte >> 4U];
      out += hex[byte & 15U];
    } else {
      out += c;
    }
  }
  return out + '"';
}

bool is_list_of_tables(const DocumentValue& value)
{
  const DocumentValue::List* list = value.list();
  return list != nullptr && !list->empty() && list->front().table() != nullptr;
}

bool is_section(const DocumentValue& value)
{
  return value.table() != nullptr || is_list_of_tables(value);
}

// A table needs a header if it has plain keys or is empty.
bool needs_header(const DocumentValue::Table& table)
{
  const auto is_plain = [](const DocumentEntry& entry) { return !is_section(entry.value); };
  return table.empty() || std::any_of(table.begin(), table.end(), is_plain);
}

// Plain keys first, then subtables, as TOML requires.
void write_table(const DocumentValue::Table& table, const std::string& path, std::string& out)
{
  for (const DocumentEntry& entry : table) {
    if (is_section(entry.value)) continue;
    out += (is_bare(entry.key) ? entry.key : quoted(entry.key)) + " = " + value_text(entry.value) + "\n";
  }
  for (const DocumentEntry& entry : table) {
    const std::string key =
        (path.empty() ? "" : path + ".") + (is_bare(entry.key) ? entry.key : quoted(entry.key));
    if (const DocumentValue::Table* inner = entry.value.table()) {
      if (needs_header(*inner)) out += "\n[" + key + "]\n";
      write_table(*inner, key, out);
    } else if (is_list_of_tables(entry.value)) {
      for (const DocumentValue& item : *entry.value.list()) {
        out += "\n[[" + key + "]]\n";
        write_table(*item.table(), key, out);
      }
    }
  }
}

}  // namespace

const DocumentValue* DocumentValue::find(std::string_view key) const
{
  const Table* entries = table();
  if (entries == nullptr) return nullptr;
  const auto found =
      std::find_if(entries->begin(), entries->end(), [&](const DocumentEntry& e) { return e.key == key; });
  return found == entries->end() ? nullptr : &found->value;
}

DocumentValue* DocumentValue::find(std::string_view key)
{
  return const_cast<DocumentValue*>(static_cast<const DocumentValue*>(this)->find(key));
}

bool DocumentValue::is_number() const
{
  return std::holds_alternative<std::int64_t>(data) || std::holds_alternative<double>(data);
}

const DocumentValue* find_at(const DocumentValue& root, std::string_view dotted_key)
{
  const DocumentValue* value = &root;
  while (value != nullptr && !dotted_key.empty()) {
    const std::size_t dot = dotted_key.find('.');
    value = value->find(dotted_key.substr(0, dot));
    dotted_key = dot == std::string_view::npos ? std::string_view{} : dotted_key.substr(dot + 1);
  }
  return value;
}

const DocumentValue& value_at(const DocumentValue& root, std::string_view dotted_key)
{
  const DocumentValue* value = find_at(root, dotted_key);
  check(value != nullptr, "a validated document lacks a key");
  return *value;
}

double number_at(const DocumentValue& root, std::string_view dotted_key)
{
  const DocumentValue& value = value_at(root, dotted_key);
  if (const auto* integer = std::get_if<std::int64_t>(&value.data)) return static_cast<double>(*integer);
  const auto* number = std::get_if<double>(&value.data);
  check(number != nullptr, "a value of a validated document is not a number");
  return *number;
}

std::int64_t integer_at(const DocumentValue& root, std::string_view dotted_key)
{
  const DocumentValue& value = value_at(root, dotted_key);
  if (const auto* integer = std::get_if<std::int64_t>(&value.data)) return *integer;
  const double number = number_at(value, ""), whole = std::round(number);
  constexpr double rounding = 1e-15;  // tolerance of the validator for a multiple of 1
  check(std::abs(number - whole) < rounding, "a value of a validated document is not a whole number");
  return static_cast<std::int64_t>(whole);
}

bool flag_at(const DocumentValue& root, std::string_view dotted_key)
{
  const auto* flag = std::get_if<bool>(&value_at(root, dotted_key).data);
  check(flag != nullptr, "a value of a validated document is not a flag");
  return *flag;
}

const std::string& text_at(const DocumentValue& root, std::string_view dotted_key)
{
  const std::string* text = value_at(root, dotted_key).text();
  check(text != nullptr, "a value of a validated document is not a text");
  return *text;
}

std::vector<double> numbers_of(const DocumentValue& value)
{
  check(value.list() != nullptr, "a value of a validated document is not a list");
  std::vector<double> numbers;
  for (const DocumentValue& item : *value.list()) numbers.push_back(number_at(item, ""));
  return numbers;
}

std::vector<double> numbers_at(const DocumentValue& root, std::string_view dotted_key)
{
  return numbers_of(value_at(root, dotted_key));
}

Eigen::Vector3d vector3_at(const DocumentValue& root, std::string_view dotted_key)
{
  const std::vector<double> numbers = numbers_at(root, dotted_key);
  check(numbers.size() == 3, "a value of a validated document is not three numbers");
  return {numbers[0], numbers[1], numbers[2]};
}

std::vector<std::vector<double>> rows_at(const DocumentValue& root, std::string_view dotted_key)
{
  std::vector<std::vector<double>> rows;
  for (const DocumentValue& row : list_or_empty(root, dotted_key)) rows.push_back(numbers_of(row));
  return rows;
}

std::vector<std::string> texts_at(const DocumentValue& root, std::string_view dotted_key)
{
  std::vector<std::string> texts;
  for (const DocumentValue& text : list_or_empty(root, dotted_key)) texts.push_back(text_at(text, ""));
  return texts;
}

const std::string& text_or_empty(const DocumentValue& root, std::string_view dotted_key)
{
  static const std::string empty;
  return find_at(root, dotted_key) == nullptr ? empty : text_at(root, dotted_key);
}

const DocumentValue::List& list_or_empty(const DocumentValue& root, std::string_view dotted_key)
{
  static const DocumentValue::List empty;
  const DocumentValue* value = find_at(root, dotted_key);
  if (value == nullptr) return empty;
  check(value->list() != nullptr, "a value of a validated document is not a list");
  return *value->list();
}

std::string value_text(const DocumentValue& value)
{
  struct Visitor {
    std::string operator()(bool flag) const { return flag ? "true" : "false"; }
    std::string operator()(std::int64_t number) const { return std::to_string(number); }
    std::string operator()(double number) const { return shortest_decimal(number); }
    std::string operator()(const std::string& text) const { return quoted(text); }
    std::string operator()(const DocumentValue::List& list) const
    {
      std::string out = "[";
      for (const DocumentValue& item : list) out += (out.size() > 1 ? ", " : "") + value_text(item);
      return out + "]";
    }
    std::string operator()(const DocumentValue::Table& table) const
    {
      if (table.empty()) return "{}";
      std::string out = "{ ";
      for (const DocumentEntry& entry : table) {
        out += (out.size() > 2 ? ", " : "") + (is_bare(entry.key) ? entry.key : quoted(entry.key)) + " = " +
               value_text(entry.value);
      }
      return out + " }";
    }
  };
  return std::visit(Visitor{}, value.data);
}

std::string toml_text(const DocumentValue& root)
{
  check(root.table() != nullptr, "toml_text: the root of a document must be a table");
  std::string out;
  write_table(*root.table(), "", out);
  return out;
}

std::string shown(const DocumentValue& value)
{
  constexpr std::size_t max_characters = 60;  // keeps a message on one line
  std::string text = value_text(value);
  return text.size() > max_characters ? text.substr(0, max_characters) + "..." : text;
}

}  // namespace vrda::inline core
