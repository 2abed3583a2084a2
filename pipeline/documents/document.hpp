/// Documents that people write: where their values come from, and how what is wrong with one is said.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "documents/value.hpp"

namespace vrda {

struct Document {
  std::string file;
  DocumentValue root;
  std::vector<std::string> overridden = {};  ///< dotted keys given by --set
  std::string prefix = {};                   ///< of keys in messages, where `root` is a part of the file

  /// The file's name, "--set" where an override gave `key`, both where one gave a part of it.
  std::string source_of(const std::string& key) const;
  /// Of several keys that do not fit together: the file, and the first of them that an override gave.
  std::string source_of_all(const std::vector<std::string>& keys) const;
  /// Of the key, or of the innermost table around it that the file has; 0 where --set gave it.
  int line_of(const std::string& key) const;

  /// Throws InputError naming source, line and key.
  [[noreturn]] void refuse(const std::string& key, const std::string& found, const std::string& wanted) const;
  /// The same of the value that the key has, as the file writes it.
  [[noreturn]] void refuse_value(const std::string& key, const std::string& wanted) const;
};

/// The text of a document. Throws InputError when there is none or it is longer than documents are; `what`
/// completes "wanted ...".
std::string document_text(const std::string& path, const std::string& what);

/// Reads TOML, tables in the order written. Throws InputError with line and column, and for control
/// characters, dates and NaN.
DocumentValue parse_toml(std::string_view text, const std::string& file);

/// Reads JSON. Throws InputError naming the line, and for null; `what` completes "wanted ...".
DocumentValue parse_json(std::string_view text, const std::string& file, const std::string& what);

/// Applies "key.path=value": TOML syntax, a plain word is text, a number steps into a list.
/// Throws InputError whose file is "--set".
void apply_override(Document& document, const std::string& assignment);

}  // namespace vrda
