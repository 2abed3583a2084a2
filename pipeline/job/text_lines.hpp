/// Reads a text line by line. Blanks, tabs and commas separate words; # starts a comment.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace vrda::job {

/// A text and its file name for messages.
struct NamedText {
  std::string file;
  std::string text;
};

class TextLines {
 public:
  /// `source` must outlive this object.
  explicit TextLines(const NamedText& source) : source_(source) {}

  /// Advances to the next line with words; false at the end of the text.
  bool next();

  const std::vector<std::string_view>& words() const { return words_; }
  /// Number of the current line, from 1; at the end that of the last line.
  std::size_t line() const { return line_; }

  /// Word `k` of the line as a finite or a whole number. Throws InputError with file and line.
  double real(std::size_t k, const std::string& wanted) const;
  std::int64_t whole(std::size_t k, const std::string& wanted) const;

  /// Throws InputError for the current line, or for line `line`.
  [[noreturn]] void refuse(const std::string& found, const std::string& wanted) const;
  [[noreturn]] void refuse_at(std::size_t line, const std::string& found, const std::string& wanted) const;

 private:
  std::string shown_word(std::size_t k) const;

  const NamedText& source_;
  std::vector<std::string_view> words_;
  std::size_t at_ = 0;
  std::size_t line_ = 0;
};

/// A word in quotation marks, cut at 40 characters.
std::string quoted(std::string_view word);

/// Whether the word is a portable file name, as in component_name_rule.
bool is_component_name(std::string_view word);
inline constexpr const char* component_name_rule =
    "a name of at most 100 letters, digits, \"_\", \"-\" and \".\", a letter first";

}  // namespace vrda::job
