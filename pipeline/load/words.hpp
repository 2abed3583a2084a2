/// Words and numbers of text files, as mesh formats and tables separate them.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

namespace vrda {

/// Blank, tab or line end.
bool is_space(char c);

/// The words of a line without its end: blanks and tabs separate, a carriage return before the end goes.
std::vector<std::string_view> words_in(std::string_view line);

/// Without blanks at either end.
std::string_view trimmed(std::string_view text);

/// What stands between the commas of a line, trimmed: always one more than there are commas.
std::vector<std::string_view> fields_in(std::string_view line);

/// A line of a table, trimmed, and its place in the file from 1.
struct TableLine {
  std::string_view text;
  std::size_t number = 0;
};

/// The lines with something on them; those that begin with # are comments, a byte order mark is none of them.
std::vector<TableLine> table_lines(std::string_view text);

/// The number a word spells and nothing else, with or without a sign; "nan" and "inf" are numbers here.
std::optional<double> real_in(std::string_view word);
std::optional<std::int64_t> whole_in(std::string_view word);

}  // namespace vrda
