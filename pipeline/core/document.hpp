/// TOML and JSON documents: the value tree, the line of each key, and messages.
#pragma once

#include <Eigen/Core>
#include <nlohmann/json.hpp>

#include <cstdint>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace vrda::inline core {

/// Tables keep the order of their keys in the text; a parsed document has no null.
using DocumentValue = nlohmann::ordered_json;

/// The value of `key` in a table; null if `value` is not a table or the key is missing.
const DocumentValue* find_key(const DocumentValue& value, const std::string& key);

/// The value of a key such as "display.width" or "follower.0.name"; null if a part of the key is missing.
const DocumentValue* find_at(const DocumentValue& root, std::string_view dotted_key);
DocumentValue* find_at(DocumentValue& root, std::string_view dotted_key);

/// Access to a validated document. Throws InternalError if the key is missing or has another type. An empty
/// key selects the value itself.
const DocumentValue& value_at(const DocumentValue& root, std::string_view dotted_key);
double number_at(const DocumentValue& root, std::string_view dotted_key);
std::int64_t integer_at(const DocumentValue& root, std::string_view dotted_key);  ///< accepts 3.0
bool flag_at(const DocumentValue& root, std::string_view dotted_key);
const std::string& text_at(const DocumentValue& root, std::string_view dotted_key);
std::vector<double> numbers_of(const DocumentValue& value);
std::vector<double> numbers_at(const DocumentValue& root, std::string_view dotted_key);
Eigen::Vector3d vector3_at(const DocumentValue& root, std::string_view dotted_key);

/// The same for optional keys; empty if missing.
std::vector<std::vector<double>> rows_at(const DocumentValue& root, std::string_view dotted_key);
std::vector<std::string> texts_at(const DocumentValue& root, std::string_view dotted_key);
const std::string& text_or_empty(const DocumentValue& root, std::string_view dotted_key);
const DocumentValue& list_or_empty(const DocumentValue& root, std::string_view dotted_key);

/// "path.key"; "key" without a path.
std::string joined_key(const std::string& path, const std::string& key);

/// The three numbers in the fewest digits, as "1, 2.5, 3".
std::string numbers_text(const Eigen::Vector3d& numbers, const char* separator = ", ");

/// Canonical TOML in the order of the tree. Equal trees give equal text; parsing restores the tree.
std::string toml_text(const DocumentValue& root);

/// One value on one line, in TOML syntax.
std::string value_text(const DocumentValue& value);

/// The same for messages: at most 60 characters, then "...".
std::string shown(const DocumentValue& value);

// TOML and JSON input documents: the source of each value, and the error report for an invalid one.

struct Document {
  std::string file;
  DocumentValue root;
  std::vector<std::string> overridden = {};  ///< dotted keys set by --set
  std::string prefix = {};                   ///< of keys in messages, where `root` is only a part of the file
  std::unordered_map<std::string, int> lines = {};  ///< by `prefix` and key; "": of the whole

  /// The file name; "--set" if an override set `key`; both if an override set a part of it.
  std::string source_of(const std::string& key) const;
  /// For a conflict between several keys: the file name and the first of the keys that an override set.
  std::string source_of_conflict(const std::vector<std::string>& keys) const;
  /// Line of the key, or of the innermost enclosing table in the file; 0 if unknown or if --set gave it.
  int line_of(const std::string& key) const;

  /// Throws InputError naming source, line and key.
  [[noreturn]] void refuse(const std::string& key, const std::string& found, const std::string& wanted) const;
  /// The same, with the value of the key as `found`.
  [[noreturn]] void refuse_value(const std::string& key, const std::string& wanted) const;
};

/// Reads the text of a document. Throws InputError if the file is unreadable or larger than 8 MB; the message
/// contains `wanted`.
std::string read_document_text(const std::string& path, const std::string& wanted);

/// Parses TOML; tables keep the order of the text. Throws InputError for a syntax error (with line and
/// column), control characters, dates, NaN and more than 40 levels.
Document read_toml(std::string_view text, const std::string& file);
/// The same without the lines.
DocumentValue parse_toml(std::string_view text, const std::string& file);

/// Parses JSON. Throws InputError for a syntax error (with line), null and more than 40 levels; the message
/// contains `wanted` or the limit.
DocumentValue parse_json(std::string_view text, const std::string& file, const std::string& wanted);

/// Applies "key.path=value". The value is TOML or an unquoted word; a number in the path indexes a list.
/// Throws InputError whose file is "--set".
void apply_override(Document& document, const std::string& assignment);

// The limit on nested keys, lists and tables, before a parser sees the text.

enum class Syntax { toml, json };

/// Throws InputError naming file, line and depth if the text has more than 40 levels: each part of a dotted
/// key or header, each list and each table is one. Time linear in the text.
void require_shallow(std::string_view text, const std::string& file, Syntax syntax);

/// The same for an override "key=value", whose file is "--set".
void require_shallow_override(std::string_view key, std::string_view value);

// JSON that the program itself writes and reads again: results, not jobs.

/// A JSON file whose values are read by their path ("limits/strain"); every failure is an InputError that
/// names file and path, the value found and the one wanted.
class JsonFile {
 public:
  using Json = nlohmann::ordered_json;

  /// Throws InputError with `wanted` unless the text is a JSON object of at most 40 levels.
  JsonFile(std::string file, std::string_view text, const std::string& wanted);

  const Json& root() const { return root_; }
  const Json& at(const std::string& path) const;
  double number(const std::string& path) const;
  std::string text(const std::string& path) const;
  std::vector<std::string> texts(const std::string& path) const;
  /// `n`: number of entries; 0: any. Without `if_null`, that is NaN, null is refused.
  std::vector<double> numbers(const std::string& path, std::size_t n, double if_null) const;

  [[noreturn]] void refuse(const std::string& path, const std::string& found,
                           const std::string& wanted) const;

 private:
  const Json& list(const std::string& path, std::size_t n) const;

  std::string file_;
  Json root_;
};

/// A value of such a file for messages: a table or list by its type.
std::string shown_json(const nlohmann::ordered_json& value);

// The library's reader and writer, compiled once.

/// The text of `json`, on one line if `indent` is -1. Invalid UTF-8, which a path may contain, is replaced.
std::string json_text(const nlohmann::ordered_json& json, int indent);

/// The value of a text that the program itself has written. Throws nlohmann::json::exception.
nlohmann::ordered_json json_in(std::string_view text);

}  // namespace vrda::inline core
