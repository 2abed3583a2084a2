/// The values of a TOML or JSON document: a tree that keeps the order of keys and the lines of the file.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace vrda {

struct DocumentEntry;

struct DocumentValue {
  using List = std::vector<DocumentValue>;
  using Table = std::vector<DocumentEntry>;
  std::variant<bool, std::int64_t, double, std::string, List, Table> data;
  int line = 0;  ///< of the file; 0: from no TOML file

  const Table* table() const { return std::get_if<Table>(&data); }
  const List* list() const { return std::get_if<List>(&data); }
  const std::string* text() const { return std::get_if<std::string>(&data); }
  bool is_number() const;
  /// The value of `key`; null when this is no table or lacks the key.
  const DocumentValue* find(std::string_view key) const;
  DocumentValue* find(std::string_view key);
};

struct DocumentEntry {
  std::string key;
  DocumentValue value;
};

/// The value of "display.width", "component.0.name"; null when a part of the key is missing.
const DocumentValue* find_at(const DocumentValue& root, std::string_view dotted_key);

/// Access to a checked document, where every key is known to be there and of its type: InternalError
/// otherwise. An empty key is the value itself.
const DocumentValue& value_at(const DocumentValue& root, std::string_view dotted_key);
double number_at(const DocumentValue& root, std::string_view dotted_key);
std::int64_t integer_at(const DocumentValue& root, std::string_view dotted_key);  ///< 3.0 is one, too
bool flag_at(const DocumentValue& root, std::string_view dotted_key);
const std::string& text_at(const DocumentValue& root, std::string_view dotted_key);
std::vector<double> numbers_of(const DocumentValue& value);
std::vector<double> numbers_at(const DocumentValue& root, std::string_view dotted_key);
Eigen::Vector3d vector3_at(const DocumentValue& root, std::string_view dotted_key);

/// The same of keys that may be left out.
std::vector<std::vector<double>> rows_at(const DocumentValue& root, std::string_view dotted_key);
std::vector<std::string> texts_at(const DocumentValue& root, std::string_view dotted_key);
const std::string& text_or_empty(const DocumentValue& root, std::string_view dotted_key);
const DocumentValue::List& list_or_empty(const DocumentValue& root, std::string_view dotted_key);

/// Canonical TOML of a tree, in its own order: equal trees give equal text, and parsing gives the tree back.
std::string toml_text(const DocumentValue& root);

/// One value on one line, as TOML has it after "key = ".
std::string value_text(const DocumentValue& value);

/// The same as messages show it: long ones are cut.
std::string shown(const DocumentValue& value);

}  // namespace vrda
