/// Line by line through a text of words: blanks, tabs and commas separate, # starts a comment.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace vrda {

/// A text and the file's name for messages.
struct NamedText {
  std::string file;
  std::string text;
};

class TextLines {
 public:
  /// `source` has to outlive this.
  explicit TextLines(const NamedText& source) : source_(source) {}

  /// Steps to the next line that has words; false at the end of the text.
  bool next();

  const std::vector<std::string_view>& words() const { return words_; }
  /// Of the words; at the end the last line. Counts from 1.
  std::size_t line() const { return line_; }

  /// Word `k` of the line as a finite number, or as a whole one. Throw InputError naming file and line.
  double real(std::size_t k, const std::string& wanted) const;
  std::int64_t whole(std::size_t k, const std::string& wanted) const;

  /// Throws InputError for this line, or for another.
  [[noreturn]] void refuse(const std::string& found, const std::string& wanted) const;
  [[noreturn]] void refuse_at(std::size_t line, const std::string& found, const std::string& wanted) const;

 private:
  std::string shown_word(std::size_t k) const;

  const NamedText& source_;
  std::vector<std::string_view> words_;
  std::size_t at_ = 0;
  std::size_t line_ = 0;
};

/// A word in quotation marks, long ones cut.
std::string quoted(std::string_view word);

/// Letters, digits, "_", "-" and ".", a letter first, at most 100 of them: the name of a file anywhere.
bool is_component_name(std::string_view word);
inline constexpr const char* component_name_rule =
    "a name of at most 100 letters, digits, \"_\", \"-\" and \".\", a letter first";

}  // namespace vrda
