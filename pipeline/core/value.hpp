/// The value tree of a TOML or JSON document, with the order of keys and the lines of the file.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace vrda::inline core {

struct DocumentEntry;

struct DocumentValue {
  using List = std::vector<DocumentValue>;
  using Table = std::vector<DocumentEntry>;
  std::variant<bool, std::int64_t, double, std::string, List, Table> data;
  int line = 0;  ///< line of the TOML file; 0 if unknown

  const Table* table() const { return std::get_if<Table>(&data); }
  const List* list() const { return std::get_if<List>(&data); }
  const std::string* text() const { return std::get_if<std::string>(&data); }
  bool is_number() const;
  /// The value of `key`; null if this is not a table or the key is missing.
  const DocumentValue* find(std::string_view key) const;
  DocumentValue* find(std::string_view key);
};

struct DocumentEntry {
  std::string key;
  DocumentValue value;
};

/// The value of a key such as "display.width"; null if a part of the key is missing. Lists are not indexed.
const DocumentValue* find_at(const DocumentValue& root, std::string_view dotted_key);

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
const DocumentValue::List& list_or_empty(const DocumentValue& root, std::string_view dotted_key);

/// Canonical TOML in the order of the tree. Equal trees give equal text; parsing restores the tree.
std::string toml_text(const DocumentValue& root);

/// One value on one line, in TOML syntax.
std::string value_text(const DocumentValue& value);

/// The same for messages: at most 60 characters, then "...".
std::string shown(const DocumentValue& value);

}  // namespace vrda::inline core
