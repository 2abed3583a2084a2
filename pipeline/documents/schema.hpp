/// The JSON schema of a kind of documents at work: which keys there are, what may be there, what is there by
/// default, and what messages say is wanted.
#pragma once

#include <memory>
#include <string_view>

#include "documents/document.hpp"

namespace vrda {

/// Beyond JSON Schema (draft 7), `"infinite": true` lets a number be infinite, which TOML can write. What a
/// message says is wanted is the `description`; without one it follows from type, range and choices.
class DocumentSchema {
 public:
  /// `text`: a schema whose references stay within it. Of several shapes (anyOf) a value takes the one of its
  /// type.
  explicit DocumentSchema(std::string_view text);
  ~DocumentSchema();

  /// The root with every default filled in, keys in the schema's order, numbers as the schema types them.
  /// Throws InputError for an unknown key (naming the nearest known one), a missing key, a wrong type or
  /// value.
  DocumentValue checked(const Document& document) const;

  /// The document of a TOML text, its root checked; `file` is for errors. Throws InputError like these.
  Document read(std::string_view text, const std::string& file) const;

  /// What can be said without the values: throws InputError for an unknown key.
  void check_known_keys(const Document& document) const;
  /// Throws InputError for a key that is missing.
  void check_required_keys(const Document& document) const;

 private:
  struct Compiled;
  std::unique_ptr<const Compiled> compiled_;
};

}  // namespace vrda
