#include "load/job_value.hpp"

#include <algorithm>

#include "core/error.hpp"
#include "core/text.hpp"

namespace vrda {
namespace {

bool is_inside(const std::string& key, const std::string& outer)
{
  return key == outer || (key.size() > outer.size() && key.starts_with(outer) && key[outer.size()] == '.');
}

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

bool is_list_of_tables(const JobValue& value)
{
  const JobValue::List* list = value.list();
  return list != nullptr && !list->empty() && list->front().table() != nullptr;
}

bool is_section(const JobValue& value)
{
  return value.table() != nullptr || is_list_of_tables(value);
}

// A header is needed where plain keys follow it, or nothing at all.
bool needs_header(const JobValue::Table& table)
{
  const auto is_plain = [](const JobEntry& entry) { return !is_section(entry.value); };
  return table.empty() || std::any_of(table.begin(), table.end(), is_plain);
}

// Plain keys first, then the tables below, as TOML wants it.
void write_table(const JobValue::Table& table, const std::string& path, std::string& out)
{
  for (const JobEntry& entry : table) {
    if (is_section(entry.value)) continue;
    out += (is_bare(entry.key) ? entry.key : quoted(entry.key)) + " = " + value_text(entry.value) + "\n";
  }
  for (const JobEntry& entry : table) {
    const std::string key =
        (path.empty() ? "" : path + ".") + (is_bare(entry.key) ? entry.key : quoted(entry.key));
    if (const JobValue::Table* inner = entry.value.table()) {
      if (needs_header(*inner)) out += "\n[" + key + "]\n";
      write_table(*inner, key, out);
    } else if (is_list_of_tables(entry.value)) {
      for (const JobValue& item : *entry.value.list()) {
        out += "\n[[" + key + "]]\n";
        write_table(*item.table(), key, out);
      }
    }
  }
}

}  // namespace

const JobValue* JobValue::find(std::string_view key) const
{
  const Table* entries = table();
  if (entries == nullptr) return nullptr;
  const auto found =
      std::find_if(entries->begin(), entries->end(), [&](const JobEntry& e) { return e.key == key; });
  return found == entries->end() ? nullptr : &found->value;
}

JobValue* JobValue::find(std::string_view key)
{
  return const_cast<JobValue*>(static_cast<const JobValue*>(this)->find(key));
}

std::string JobDocument::source_of(const std::string& key) const
{
  for (const std::string& set : overridden) {
    if (is_inside(key, set)) return "--set";
  }
  // A message about keys that do not fit together: one of them may come from the command line.
  for (const std::string& set : overridden) {
    if (is_inside(set, key)) return file + " with --set " + set;
  }
  return file;
}

std::string JobDocument::source_of_all(const std::vector<std::string>& keys) const
{
  for (const std::string& key : keys) {
    if (source_of(key) != file) return file + " with --set " + key;
  }
  return file;
}

const JobValue& value_at(const JobValue& root, std::string_view dotted_key)
{
  const JobValue* value = &root;
  while (!dotted_key.empty()) {
    const std::size_t dot = dotted_key.find('.');
    value = value->find(dotted_key.substr(0, dot));
    check(value != nullptr, "a checked job lacks a key");
    dotted_key = dot == std::string_view::npos ? std::string_view{} : dotted_key.substr(dot + 1);
  }
  return *value;
}

double number_at(const JobValue& root, std::string_view dotted_key)
{
  const JobValue& value = value_at(root, dotted_key);
  if (const auto* integer = std::get_if<std::int64_t>(&value.data)) return static_cast<double>(*integer);
  const auto* number = std::get_if<double>(&value.data);
  check(number != nullptr, "a checked job holds no number where one belongs");
  return *number;
}

std::int64_t integer_at(const JobValue& root, std::string_view dotted_key)
{
  const auto* integer = std::get_if<std::int64_t>(&value_at(root, dotted_key).data);
  check(integer != nullptr, "a checked job holds no whole number where one belongs");
  return *integer;
}

bool flag_at(const JobValue& root, std::string_view dotted_key)
{
  const auto* flag = std::get_if<bool>(&value_at(root, dotted_key).data);
  check(flag != nullptr, "a checked job holds no flag where one belongs");
  return *flag;
}

const std::string& text_at(const JobValue& root, std::string_view dotted_key)
{
  const std::string* text = value_at(root, dotted_key).text();
  check(text != nullptr, "a checked job holds no text where it belongs");
  return *text;
}

std::vector<double> numbers_of(const JobValue& value)
{
  check(value.list() != nullptr, "a checked job holds no list where one belongs");
  std::vector<double> numbers;
  for (const JobValue& item : *value.list()) numbers.push_back(number_at(item, ""));
  return numbers;
}

std::string value_text(const JobValue& value)
{
  struct Visitor {
    std::string operator()(bool flag) const { return flag ? "true" : "false"; }
    std::string operator()(std::int64_t number) const { return std::to_string(number); }
    std::string operator()(double number) const { return shortest(number); }
    std::string operator()(const std::string& text) const { return quoted(text); }
    std::string operator()(const JobValue::List& list) const
    {
      std::string out = "[";
      for (const JobValue& item : list) out += (out.size() > 1 ? ", " : "") + value_text(item);
      return out + "]";
    }
    std::string operator()(const JobValue::Table& table) const
    {
      if (table.empty()) return "{}";
      std::string out = "{ ";
      for (const JobEntry& entry : table) {
        out += (out.size() > 2 ? ", " : "") + (is_bare(entry.key) ? entry.key : quoted(entry.key)) + " = " +
               value_text(entry.value);
      }
      return out + " }";
    }
  };
  return std::visit(Visitor{}, value.data);
}

std::string toml_text(const JobValue& root)
{
  check(root.table() != nullptr, "toml_text: the root of a job is a table");
  std::string out;
  write_table(*root.table(), "", out);
  return out;
}

std::string shown(const JobValue& value)
{
  constexpr std::size_t longest = 60;  // characters: one message, one line
  std::string text = value_text(value);
  return text.size() > longest ? text.substr(0, longest) + "..." : text;
}

}  // namespace vrda
