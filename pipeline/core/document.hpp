/// TOML and JSON input documents: the source of each value, and the error report for an invalid one.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/value.hpp"

namespace vrda::inline core {

struct Document {
  std::string file;
  DocumentValue root;
  std::vector<std::string> overridden = {};  ///< dotted keys set by --set
  std::string prefix = {};                   ///< of keys in messages, where `root` is only a part of the file

  /// The file name; "--set" if an override set `key`; both if an override set a part of it.
  std::string source_of(const std::string& key) const;
  /// For a conflict between several keys: the file name and the first of the keys that an override set.
  std::string source_of_conflict(const std::vector<std::string>& keys) const;
  /// Line of the key, or of the innermost enclosing table in the file; 0 if --set gave it.
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
DocumentValue parse_toml(std::string_view text, const std::string& file);

/// Parses JSON. Throws InputError for a syntax error (with line), null and more than 40 levels; the message
/// contains `wanted` or the limit.
DocumentValue parse_json(std::string_view text, const std::string& file, const std::string& wanted);

/// Applies "key.path=value". The value is TOML or an unquoted word; a number in the path indexes a list.
/// Throws InputError whose file is "--set".
void apply_override(Document& document, const std::string& assignment);

}  // namespace vrda::inline core
