/// Splits text files into words, fields, lines and numbers, for mesh formats and tables.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

namespace vrda::job {

/// Blank, tab or line end.
bool is_space(char c);

/// The words of a line, separated by blanks and tabs; a final carriage return is ignored.
std::vector<std::string_view> split_words(std::string_view line);

/// Without white space at either end.
std::string_view trimmed(std::string_view text);

/// The fields between the commas of a line, trimmed; one more than the number of commas.
std::vector<std::string_view> split_fields(std::string_view line);

/// A trimmed line of a table and its line number, from 1.
struct TableLine {
  std::string_view text;
  std::size_t number = 0;
};

/// The lines that are neither empty nor comments (#). A byte order mark is skipped.
std::vector<TableLine> table_lines(std::string_view text);

/// The number if the whole word is one, with an optional sign; "nan" and "inf" are accepted.
std::optional<double> parse_real(std::string_view word);
std::optional<std::int64_t> parse_integer(std::string_view word);

}  // namespace vrda::job
