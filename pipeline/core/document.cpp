// JSON text to DocumentValue.
#include "core/document.hpp"

#include <toml++/toml.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <optional>
#include <sstream>
#include <utility>
#include <vector>

#include "core/text.hpp"

namespace vrda::inline core {
namespace {

using Json = nlohmann::json;

// Builds the tree from parser events, because nlohmann::json values lose the order of keys.
class TreeBuilder : public nlohmann::json_sax<Json> {
 public:
  TreeBuilder(std::string_view text, const std::string& file, const std::string& wanted)
      : text_(text), file_(file), wanted_(wanted)
  {
  }

  DocumentValue root;

  bool null() override { refuse(path(), "null", "a value"); }
  bool boolean(bool flag) override { return add({flag}); }
  bool number_integer(number_integer_t number) override { return add({std::int64_t{number}}); }
  bool number_unsigned(number_unsigned_t number) override
  {
    constexpr number_unsigned_t largest = INT64_MAX;
    return number <= largest ? add({static_cast<std::int64_t>(number)}) : add({static_cast<double>(number)});
  }
  bool number_float(number_float_t number, const std::string& /*text*/) override { return add({number}); }
  bool string(std::string& text) override { return add({text}); }
  bool binary(Json::binary_t& /*bytes*/) override { refuse("", "bytes", wanted_); }
  bool start_object(std::size_t /*n*/) override { return open({DocumentValue::Table{}}); }
  bool start_array(std::size_t /*n*/) override { return open({DocumentValue::List{}}); }
  bool end_object() override { return close(); }
  bool end_array() override { return close(); }
  bool key(std::string& name) override
  {
    keys_.back() = name;
    return true;
  }
  bool parse_error(std::size_t byte, const std::string& /*token*/, const Json::exception& error) override
  {
    const auto line =
        1 + std::count(text_.begin(), text_.begin() + static_cast<long>(std::min(byte, text_.size())), '\n');
    constexpr int out_of_range = 406;
    throw InputError({file_, "",
                      error.id == out_of_range ? "a number beyond the range of doubles" : "invalid JSON",
                      wanted_, static_cast<int>(line)});
  }

 private:
  [[noreturn]] void refuse(const std::string& key, const std::string& found, const std::string& wanted) const
  {
    throw InputError({file_, key, found, wanted});
  }

  // Dotted key of the current value, such as "0.dimensions".
  std::string path() const
  {
    std::string path;
    for (std::size_t i = 0; i < open_.size(); ++i) {
      const DocumentValue::List* list = open_[i].list();
      path += (path.empty() ? "" : ".") + (list == nullptr ? keys_[i] : std::to_string(list->size()));
    }
    return path;
  }

  // The last value of a repeated key is used.
  bool add(DocumentValue value)
  {
    DocumentValue& parent = open_.empty() ? root : open_.back();
    if (auto* list = std::get_if<DocumentValue::List>(&parent.data)) {
      list->push_back(std::move(value));
    } else if (DocumentValue* existing = open_.empty() ? &root : parent.find(keys_.back())) {
      *existing = std::move(value);
    } else {
      std::get<DocumentValue::Table>(parent.data).push_back({keys_.back(), std::move(value)});
    }
    return true;
  }

  bool open(DocumentValue value)
  {
    open_.push_back(std::move(value));
    keys_.emplace_back();
    return true;
  }

  bool close()
  {
    DocumentValue value = std::move(open_.back());
    open_.pop_back();
    keys_.pop_back();
    return add(std::move(value));
  }

  std::string_view text_;
  const std::string& file_;
  const std::string& wanted_;
  std::vector<DocumentValue> open_;  // unfinished lists and tables, outermost first
  std::vector<std::string> keys_;    // [open_] current key of each
};

}  // namespace

DocumentValue parse_json(std::string_view text, const std::string& file, const std::string& wanted)
{
  require_shallow(text, file, Syntax::json);
  TreeBuilder builder(text, file, wanted);
  Json::sax_parse(text, &builder);
  return std::move(builder.root);
}

// TOML text to DocumentValue, and the overrides of --set.

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

namespace {

// The largest documents are calibrations with about ten thousand poses.
constexpr std::size_t max_bytes = 8'000'000;

bool is_inside(const std::string& key, const std::string& outer)
{
  return key == outer || (key.size() > outer.size() && key.starts_with(outer) && key[outer.size()] == '.');
}

// The value of a table's key or the list item with this index; null if missing.
const DocumentValue* child_of(const DocumentValue& value, const std::string& name)
{
  const DocumentValue::List* list = value.list();
  if (list == nullptr) return value.find(name);
  std::size_t index = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), index);
  const bool is_index = error == std::errc() && end == name.data() + name.size();
  return is_index && index < list->size() ? &(*list)[index] : nullptr;
}

// The path from the root to the value of a key, or to its innermost existing parent.
std::vector<const DocumentValue*> path_to(const DocumentValue& root, const std::string& key)
{
  std::vector<const DocumentValue*> values{&root};
  for (std::size_t from = 0; from < key.size();) {
    const std::size_t dot = std::min(key.find('.', from), key.size());
    const DocumentValue* next = child_of(*values.back(), key.substr(from, dot - from));
    if (next == nullptr) break;
    values.push_back(next);
    from = dot + 1;
  }
  return values;
}

}  // namespace

std::string Document::source_of(const std::string& key) const
{
  for (const std::string& set : overridden) {
    if (is_inside(key, set)) return "--set";
  }
  // A conflict between keys of a table may include one from the command line.
  for (const std::string& set : overridden) {
    if (is_inside(set, key)) return file + " with --set " + set;
  }
  return file;
}

std::string Document::source_of_conflict(const std::vector<std::string>& keys) const
{
  for (const std::string& key : keys) {
    if (source_of(key) != file) return file + " with --set " + key;
  }
  return file;
}

int Document::line_of(const std::string& key) const
{
  int line = 0;
  if (source_of(key) != file) return line;
  for (const DocumentValue* value : path_to(root, key)) {
    if (value->line > 0) line = value->line;
  }
  return line;
}

void Document::refuse(const std::string& key, const std::string& found, const std::string& wanted) const
{
  throw InputError({source_of(key), key.empty() ? "" : prefix + key, found, wanted, line_of(key)});
}

void Document::refuse_value(const std::string& key, const std::string& wanted) const
{
  refuse(key, shown(*path_to(root, key).back()), wanted);
}

std::string read_document_text(const std::string& path, const std::string& wanted)
{
  std::ifstream file(path, std::ios::binary);
  if (!file) throw InputError({path, "", "no readable file", wanted});
  std::string text(max_bytes + 1, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (file.bad()) throw InputError({path, "", "no readable file", wanted});
  text.resize(static_cast<std::size_t>(file.gcount()));
  if (text.size() > max_bytes)
    throw InputError({path, "", "more than " + std::to_string(max_bytes) + " bytes", wanted});
  return text;
}

// The depth of a document, measured on its text: a parser and every tree it builds are recursive.

namespace {

// A schema has about a dozen levels; a recursive function takes well below a kilobyte of stack for each.
constexpr std::size_t largest_depth = 40;

// Follows keys, headers and brackets only, so the text need not be valid.
class DepthScan {
 public:
  DepthScan(std::string_view text, Syntax syntax) : text_(text), has_headers_(syntax == Syntax::toml)
  {
    is_line_start_ = has_headers_;
    while (at_ < text_.size()) step(text_[at_++]);
  }

  std::size_t deepest() const { return deepest_; }
  int line_of_deepest() const { return line_of_deepest_; }

 private:
  void step(char c)
  {
    const bool is_line_start = is_line_start_;
    is_line_start_ = is_line_start && (c == ' ' || c == '\t');
    switch (c) {
      case '\n':
        end_line();
        break;
      case '#':
        at_ = std::min(text_.find('\n', at_), text_.size());
        break;
      case '"':
      case '\'':
        skip_string(c);
        break;
      case '.':
        ++n_parts_;
        break;
      case '=':
        reach(level_.emplace(level() + n_parts_));
        break;
      case ',':
        begin_key();
        break;
      case '[':
        if (open_.empty() && (is_line_start || n_header_brackets_ > 0)) {
          ++n_header_brackets_;
          begin_key();
        } else {
          open();
        }
        break;
      case '{':
        open();
        break;
      case ']':
      case '}':
        close();
        break;
      default:
        break;
    }
  }

  // Of the table that contains the current key.
  std::size_t level() const { return open_.empty() ? header_level_ : open_.back(); }

  void reach(std::size_t level)
  {
    if (level <= deepest_) return;
    deepest_ = level;
    line_of_deepest_ = line_;
  }

  void begin_key()
  {
    n_parts_ = 1;
    level_.reset();
  }

  void end_line()
  {
    ++line_;
    if (!open_.empty()) return;
    begin_key();
    n_header_brackets_ = 0;
    is_line_start_ = has_headers_;
  }

  void open()
  {
    open_.push_back(level_.value_or(level() + 1));
    reach(open_.back());
    begin_key();
  }

  void close()
  {
    if (n_header_brackets_ > 0) {
      reach(header_level_ = n_parts_ + n_header_brackets_ - 1);
      n_header_brackets_ = 0;
    }
    if (!open_.empty()) open_.pop_back();
    begin_key();
  }

  void skip_string(char quote)
  {
    const std::string three(3, quote);
    const bool is_long = has_headers_ && text_.substr(at_ - 1, 3) == three;
    if (is_long) at_ += 2;
    for (; at_ < text_.size(); ++at_) {
      if (text_[at_] == '\\' && quote == '"') {
        ++at_;
      } else if (is_long ? text_.substr(at_, 3) == three : text_[at_] == quote || text_[at_] == '\n') {
        break;
      }
      if (at_ < text_.size() && text_[at_] == '\n') ++line_;
    }
    if (is_long) at_ += 3;
    if (!is_long && at_ < text_.size() && text_[at_] == quote) ++at_;
    at_ = std::min(at_, text_.size());
  }

  std::string_view text_;
  bool has_headers_;
  std::size_t at_ = 0;
  int line_ = 1;
  bool is_line_start_ = false;
  std::size_t header_level_ = 0, n_header_brackets_ = 0;  // of the last header; of one that is being read
  std::size_t n_parts_ = 1;                               // of the current key
  std::optional<std::size_t> level_;                      // of the value after "="
  std::vector<std::size_t> open_;                         // levels of the open lists and tables
  std::size_t deepest_ = 0;
  int line_of_deepest_ = 0;
};

[[noreturn]] void refuse(std::size_t levels, const InputError::Facts& where)
{
  throw InputError({where.file, where.field, std::to_string(levels) + " nested keys, lists or tables",
                    "at most " + std::to_string(largest_depth), where.line});
}

}  // namespace

void require_shallow(std::string_view text, const std::string& file, Syntax syntax)
{
  const DepthScan scan(text, syntax);
  if (scan.deepest() > largest_depth) refuse(scan.deepest(), {file, "", "", "", scan.line_of_deepest()});
}

void require_shallow_override(std::string_view key, std::string_view value)
{
  const std::string with_key = "=" + std::string(value);  // a key of one part
  const auto n_dots = static_cast<std::size_t>(std::count(key.begin(), key.end(), '.'));
  const std::size_t levels = n_dots + DepthScan(with_key, Syntax::toml).deepest();
  if (levels > largest_depth) refuse(levels, {"--set", std::string(key.substr(0, key.find('.'))), "", "", 0});
}

JsonFile::JsonFile(std::string file, std::string_view text, const std::string& wanted)
    : file_(std::move(file))
{
  require_shallow(text, file_, Syntax::json);
  root_ = Json::parse(text, nullptr, false);
  if (!root_.is_object()) refuse("", "another kind of file", wanted);
}

void JsonFile::refuse(const std::string& path, const std::string& found, const std::string& wanted) const
{
  throw InputError({file_, path, found, wanted});
}

const JsonFile::Json& JsonFile::at(const std::string& path) const
{
  const Json::json_pointer pointer("/" + path);
  if (!root_.contains(pointer)) refuse(path, "nothing", "a value");
  return root_.at(pointer);
}

double JsonFile::number(const std::string& path) const
{
  const Json& value = at(path);
  if (!value.is_number()) refuse(path, shown(value), "a number");
  return value.get<double>();
}

std::string JsonFile::text(const std::string& path) const
{
  const Json& value = at(path);
  if (!value.is_string()) refuse(path, shown(value), "text");
  return value.get<std::string>();
}

std::vector<double> JsonFile::numbers(const std::string& path, std::size_t n, double if_null) const
{
  std::vector<double> values;
  for (const Json& value : list(path, n)) {
    if (!value.is_number() && !(value.is_null() && std::isnan(if_null)))
      refuse(path, shown(value), "numbers");
    values.push_back(value.is_null() ? if_null : value.get<double>());
  }
  return values;
}

std::vector<std::string> JsonFile::texts(const std::string& path) const
{
  std::vector<std::string> values;
  for (const Json& value : list(path, 0)) {
    if (!value.is_string()) refuse(path, shown(value), "a list of texts");
    values.push_back(value.get<std::string>());
  }
  return values;
}

const JsonFile::Json& JsonFile::list(const std::string& path, std::size_t n) const
{
  const Json& value = at(path);
  if (!value.is_array()) refuse(path, shown(value), "a list");
  if (n > 0 && value.size() != n) refuse(path, std::to_string(value.size()) + " entries", std::to_string(n));
  return value;
}

std::string shown(const nlohmann::ordered_json& value)
{
  if (value.is_array()) return "a list";
  if (value.is_object()) return "a table";
  return json_text(value, -1);
}

}  // namespace vrda::inline core
