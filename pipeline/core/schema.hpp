/// Validation of documents against a JSON schema: known keys, permitted values, defaults and error texts.
#pragma once

#include <memory>
#include <string_view>

#include "core/document.hpp"

namespace vrda::inline core {

/// JSON Schema (draft 7). Extension: `"infinite": true` permits infinite numbers, which TOML can express. The
/// "wanted" text of a message is the `description`; without one it is derived from type, range and choices.
class DocumentSchema {
 public:
  /// `text`: a schema with internal references only. Of the alternatives of an anyOf the one of the value's
  /// type applies.
  explicit DocumentSchema(std::string_view text);
  ~DocumentSchema();

  /// The root with every default filled in, keys in the schema's order, numbers as the schema types them.
  /// Throws InputError for an unknown key (naming the nearest known one), a missing key, a wrong type or
  /// value.
  DocumentValue checked(const Document& document) const;

  /// Parses a TOML text and checks its root; `file` is its name in messages. Throws InputError.
  Document read(std::string_view text, const std::string& file) const;

  /// Throws InputError for an unknown key. Values are not checked.
  void check_known_keys(const Document& document) const;
  /// Throws InputError for a missing key.
  void check_required_keys(const Document& document) const;

 private:
  struct Compiled;
  std::unique_ptr<const Compiled> compiled_;
};

}  // namespace vrda::inline core
