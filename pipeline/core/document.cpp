#include "core/document.hpp"

#include <toml++/toml.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <optional>
#include <sstream>
#include <utility>

#include "core/text.hpp"

namespace vrda::inline core {

std::string joined_key(const std::string& path, const std::string& key)
{
  return path.empty() ? key : path + "." + key;
}

std::string numbers_text(const Eigen::Vector3d& numbers, const char* separator)
{
  return shortest_decimal(numbers.x()) + separator + shortest_decimal(numbers.y()) + separator +
         shortest_decimal(numbers.z());
}

namespace {

// Dotted key of the first null, such as "0.dimensions".
std::optional<std::string> key_of_null(const DocumentValue& value, const std::string& path)
{
  if (value.is_null()) return path;
  if (!value.is_structured()) return std::nullopt;
  for (const auto& [key, child] : value.items()) {
    if (const auto found = key_of_null(child, joined_key(path, key))) return found;
  }
  return std::nullopt;
}

}  // namespace

DocumentValue parse_json(std::string_view text, const std::string& file, const std::string& wanted)
{
  require_shallow(text, file, Syntax::json);
  const auto refuse_at = [&](std::size_t byte, const std::string& found) {
    const auto end = text.begin() + static_cast<std::ptrdiff_t>(std::min(byte, text.size()));
    throw InputError({file, "", found, wanted, 1 + static_cast<int>(std::count(text.begin(), end, '\n'))});
  };
  DocumentValue root;
  try {
    root = DocumentValue::parse(text);
  } catch (const DocumentValue::parse_error& error) {
    refuse_at(error.byte, "invalid JSON");
  } catch (const DocumentValue::out_of_range& error) {
    // The parser tells the number, "... parsing '1e999'", but not its position.
    const std::string_view what = error.what();
    const std::size_t quote = what.find('\'');
    const std::string_view number = what.substr(quote + 1, what.rfind('\'') - quote - 1);
    refuse_at(text.find(number), "a number beyond the range of doubles");
  }
  if (const auto key = key_of_null(root, "")) throw InputError({file, *key, "null", "a value"});
  return root;
}

// TOML text to DocumentValue, and the overrides of --set.

namespace {

// Builds the tree of a TOML text and notes the lines of its values.
class TomlReader {
 public:
  explicit TomlReader(std::string file) : document_{std::move(file), {}} {}

  Document read(const toml::table& table) &&
  {
    document_.root = table_of(table, "");
    return std::move(document_);
  }

  DocumentValue value_of(const toml::node& node, const std::string& key)
  {
    if (const toml::table* table = node.as_table()) return table_of(*table, key);
    if (const toml::array* array = node.as_array()) return list_of(*array, key);
    if (const auto* flag = node.as_boolean()) return flag->get();
    if (const auto* integer = node.as_integer()) return integer->get();
    if (const auto* number = node.as_floating_point()) {
      if (std::isnan(number->get())) refuse(node, key, "nan", "a number");
      return number->get();
    }
    const auto* text = node.as_string();
    if (text == nullptr)
      refuse(node, key, "a date or time", "text, a number, true or false, a list or a table");
    if (has_control_characters(text->get(), "\t\n"))
      refuse(node, key, "a text with control characters", "text without control characters");
    return text->get();
  }

 private:
  [[noreturn]] void refuse(const toml::node& node, const std::string& key, const std::string& found,
                           const std::string& wanted) const
  {
    throw InputError({document_.file, key, found, wanted, static_cast<int>(node.source().begin.line)});
  }

  DocumentValue child_of(const toml::node& node, const std::string& key)
  {
    document_.lines[key] = static_cast<int>(node.source().begin.line);
    return value_of(node, key);
  }

  // toml++ sorts keys by name. The order of the text is restored: it is the order of a campaign's axes.
  DocumentValue table_of(const toml::table& table, const std::string& key)
  {
    std::vector<std::pair<std::string, const toml::node*>> entries;
    for (const auto& [name, node] : table) entries.emplace_back(name.str(), &node);
    std::ranges::stable_sort(entries, {}, [](const auto& entry) {
      const toml::source_position at = entry.second->source().begin;
      return std::pair(at.line, at.column);
    });
    DocumentValue::object_t in_order;
    for (const auto& [name, node] : entries)
      in_order.emplace_back(name, child_of(*node, joined_key(key, name)));
    return in_order;
  }

  DocumentValue list_of(const toml::array& array, const std::string& key)
  {
    DocumentValue items = DocumentValue::array();
    for (const toml::node& node : array)
      items.push_back(child_of(node, joined_key(key, std::to_string(items.size()))));
    return items;
  }

  Document document_;
};

// An unquoted word, as written in a shell: +X, left, meshes/femur.stl
bool is_plain_word(const std::string& text)
{
  return !text.empty() && text.find_first_of("\"'[]{}=,#\n\r\t") == std::string::npos;
}

DocumentValue override_value(const std::string& text, const std::string& key)
{
  try {
    const toml::table table = toml::parse("value = " + text);
    if (table.size() == 1) return TomlReader("--set").value_of(*table.get("value"), key);
  } catch (const toml::parse_error&) {
    if (is_plain_word(text)) return text;
  }
  throw InputError(
      {"--set", key, text.empty() ? "nothing" : text, "one value in TOML syntax, or one plain word"});
}

// The list item with this index; null if `name` is no index or beyond the list.
const DocumentValue* item_at(const DocumentValue& list, const std::string& name)
{
  std::size_t index = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), index);
  const bool is_index = error == std::errc() && end == name.data() + name.size();
  return is_index && index < list.size() ? &list[index] : nullptr;
}

// The value of `name` in a table (added if missing), or the list item with that index.
DocumentValue& step_into(DocumentValue& value, const std::string& name, const std::string& key)
{
  if (value.is_array()) {
    if (const DocumentValue* item = item_at(value, name)) return const_cast<DocumentValue&>(*item);
    throw InputError({"--set", key, "\"" + name + "\" within a list",
                      value.empty() ? "no key: the list is empty"
                                    : "a number from 0 to " + std::to_string(value.size() - 1)});
  }
  if (!value.is_object())
    throw InputError({"--set", key, "\"" + name + "\" within " + shown(value), "the key of a table"});
  return value.contains(name) ? value[name] : value[name] = DocumentValue::object();
}

}  // namespace

DocumentValue parse_toml(std::string_view text, const std::string& file)
{
  return read_toml(text, file).root;
}

Document read_toml(std::string_view text, const std::string& file)
{
  require_shallow(text, file, Syntax::toml);
  try {
    return TomlReader(file).read(toml::parse(text));
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

bool is_list_of_tables(const DocumentValue& value)
{
  return value.is_array() && !value.empty() && value.front().is_object();
}

bool is_section(const DocumentValue& value)
{
  return value.is_object() || is_list_of_tables(value);
}

std::string key_text(const std::string& key)
{
  return is_bare(key) ? key : quoted_text(key);
}

// Plain keys first, then subtables, as TOML requires. A table needs a header if it has plain keys or is
// empty.
void write_table(const DocumentValue& table, const std::string& path, std::string& out)
{
  for (const auto& [key, value] : table.items()) {
    if (!is_section(value)) out += key_text(key) + " = " + value_text(value) + "\n";
  }
  for (const auto& [name, value] : table.items()) {
    const std::string key = joined_key(path, key_text(name));
    if (value.is_object()) {
      if (value.empty() || !std::ranges::all_of(value, is_section)) out += "\n[" + key + "]\n";
      write_table(value, key, out);
    } else if (is_list_of_tables(value)) {
      for (const DocumentValue& item : value) {
        out += "\n[[" + key + "]]\n";
        write_table(item, key, out);
      }
    }
  }
}

}  // namespace

const DocumentValue* find_key(const DocumentValue& value, const std::string& key)
{
  const auto found = value.find(key);
  return found == value.end() ? nullptr : &*found;
}

const DocumentValue* find_at(const DocumentValue& root, std::string_view dotted_key)
{
  const DocumentValue* value = &root;
  while (value != nullptr && !dotted_key.empty()) {
    const std::size_t dot = dotted_key.find('.');
    const std::string name(dotted_key.substr(0, dot));
    value = value->is_array() ? item_at(*value, name) : find_key(*value, name);
    dotted_key = dot == std::string_view::npos ? std::string_view{} : dotted_key.substr(dot + 1);
  }
  return value;
}

DocumentValue* find_at(DocumentValue& root, std::string_view dotted_key)
{
  return const_cast<DocumentValue*>(find_at(std::as_const(root), dotted_key));
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
  check(value.is_number(), "a value of a validated document is not a number");
  return value.get<double>();
}

std::int64_t integer_at(const DocumentValue& root, std::string_view dotted_key)
{
  const DocumentValue& value = value_at(root, dotted_key);
  if (value.is_number_integer()) return value.get<std::int64_t>();
  const double number = number_at(value, ""), whole = std::round(number);
  constexpr double rounding = 1e-15;  // tolerance of the validator for a multiple of 1
  check(std::abs(number - whole) < rounding, "a value of a validated document is not a whole number");
  return static_cast<std::int64_t>(whole);
}

bool flag_at(const DocumentValue& root, std::string_view dotted_key)
{
  const DocumentValue& value = value_at(root, dotted_key);
  check(value.is_boolean(), "a value of a validated document is not a flag");
  return value.get<bool>();
}

const std::string& text_at(const DocumentValue& root, std::string_view dotted_key)
{
  const DocumentValue& value = value_at(root, dotted_key);
  check(value.is_string(), "a value of a validated document is not a text");
  return value.get_ref<const std::string&>();
}

std::vector<double> numbers_of(const DocumentValue& value)
{
  check(value.is_array(), "a value of a validated document is not a list");
  std::vector<double> numbers;
  for (const DocumentValue& item : value) numbers.push_back(number_at(item, ""));
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

const DocumentValue& list_or_empty(const DocumentValue& root, std::string_view dotted_key)
{
  static const DocumentValue empty = DocumentValue::array();
  const DocumentValue* value = find_at(root, dotted_key);
  if (value == nullptr) return empty;
  check(value->is_array(), "a value of a validated document is not a list");
  return *value;
}

std::string value_text(const DocumentValue& value)
{
  if (value.is_number_float()) return shortest_decimal(value.get<double>());
  if (value.is_string()) return quoted_text(value.get_ref<const std::string&>());
  if (!value.is_structured()) return value.dump();
  std::string out;
  for (const auto& [key, child] : value.items())
    out += (out.empty() ? "" : ", ") + (value.is_object() ? key_text(key) + " = " : "") + value_text(child);
  if (value.is_array()) return "[" + out + "]";
  return out.empty() ? "{}" : "{ " + out + " }";
}

std::string toml_text(const DocumentValue& root)
{
  check(root.is_object(), "toml_text: the root of a document must be a table");
  std::string out;
  write_table(root, "", out);
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
  if (source_of(key) != file) return 0;
  for (std::string inner = prefix + key;;) {
    if (const auto found = lines.find(inner); found != lines.end()) return found->second;
    if (inner.empty()) return 0;
    const std::size_t dot = inner.rfind('.');
    inner.resize(dot == std::string::npos ? 0 : dot);
  }
}

void Document::refuse(const std::string& key, const std::string& found, const std::string& wanted) const
{
  throw InputError({source_of(key), key.empty() ? "" : prefix + key, found, wanted, line_of(key)});
}

void Document::refuse_value(const std::string& key, const std::string& wanted) const
{
  const DocumentValue* value = &root;  // of the key, or of its innermost existing table
  std::istringstream names(key);
  for (std::string name; value->is_structured() && std::getline(names, name, '.');) {
    const DocumentValue* next = value->is_array() ? item_at(*value, name) : find_key(*value, name);
    if (next == nullptr) break;
    value = next;
  }
  refuse(key, shown(*value), wanted);
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

std::string json_text(const nlohmann::ordered_json& json, int indent)
{
  return json.dump(indent, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

nlohmann::ordered_json json_in(std::string_view text)
{
  return nlohmann::ordered_json::parse(text);
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
  if (!value.is_number()) refuse(path, shown_json(value), "a number");
  return value.get<double>();
}

std::string JsonFile::text(const std::string& path) const
{
  const Json& value = at(path);
  if (!value.is_string()) refuse(path, shown_json(value), "text");
  return value.get<std::string>();
}

std::vector<double> JsonFile::numbers(const std::string& path, std::size_t n, double if_null) const
{
  std::vector<double> values;
  for (const Json& value : list(path, n)) {
    if (!value.is_number() && !(value.is_null() && std::isnan(if_null)))
      refuse(path, shown_json(value), "numbers");
    values.push_back(value.is_null() ? if_null : value.get<double>());
  }
  return values;
}

std::vector<std::string> JsonFile::texts(const std::string& path) const
{
  std::vector<std::string> values;
  for (const Json& value : list(path, 0)) {
    if (!value.is_string()) refuse(path, shown_json(value), "a list of texts");
    values.push_back(value.get<std::string>());
  }
  return values;
}

const JsonFile::Json& JsonFile::list(const std::string& path, std::size_t n) const
{
  const Json& value = at(path);
  if (!value.is_array()) refuse(path, shown_json(value), "a list");
  if (n > 0 && value.size() != n) refuse(path, std::to_string(value.size()) + " entries", std::to_string(n));
  return value;
}

std::string shown_json(const nlohmann::ordered_json& value)
{
  if (value.is_array()) return "a list";
  if (value.is_object()) return "a table";
  return json_text(value, -1);
}

}  // namespace vrda::inline core
