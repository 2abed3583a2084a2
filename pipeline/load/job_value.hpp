/// A job as a tree of values: what stands between TOML, the schema and the Job. Tables keep their order.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace vrda {

struct JobEntry;

struct JobValue {
  using List = std::vector<JobValue>;
  using Table = std::vector<JobEntry>;
  std::variant<bool, std::int64_t, double, std::string, List, Table> data;

  const Table* table() const { return std::get_if<Table>(&data); }
  const List* list() const { return std::get_if<List>(&data); }
  const std::string* text() const { return std::get_if<std::string>(&data); }
  /// The value of `key`; null when this is no table or lacks the key.
  const JobValue* find(std::string_view key) const;
  JobValue* find(std::string_view key);
};

struct JobEntry {
  std::string key;
  JobValue value;
};

/// A job with where its keys come from, for messages.
struct JobDocument {
  std::string file;
  JobValue root;
  std::vector<std::string> overridden;  ///< dotted keys given by --set

  /// The file's name, "--set" where an override gave `key`, both where one gave a part of it.
  std::string source_of(const std::string& key) const;
  /// Of several keys that do not fit together: the file, and the first of them that an override gave.
  std::string source_of_all(const std::vector<std::string>& keys) const;
};

/// Access to a checked job, where every key is known to be there: InternalError otherwise.
const JobValue& value_at(const JobValue& root, std::string_view dotted_key);
double number_at(const JobValue& root, std::string_view dotted_key);
std::int64_t integer_at(const JobValue& root, std::string_view dotted_key);
bool flag_at(const JobValue& root, std::string_view dotted_key);
const std::string& text_at(const JobValue& root, std::string_view dotted_key);
std::vector<double> numbers_of(const JobValue& value);

/// Reads TOML, tables in the order written. Throws InputError with line and column.
JobValue parse_toml(std::string_view text, const std::string& file);

/// Applies "key.path=value": TOML syntax, a plain word is text, a number steps into a list.
/// Throws InputError whose file is "--set".
void apply_override(JobDocument& document, const std::string& assignment);

/// Canonical TOML of a tree, in its own order: equal trees give equal text, and parsing gives the tree back.
std::string toml_text(const JobValue& root);

/// One value on one line, as TOML has it after "key = ".
std::string value_text(const JobValue& value);

/// The same as messages show it: long ones are cut.
std::string shown(const JobValue& value);

}  // namespace vrda
