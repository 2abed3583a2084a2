/// What tables of comma-separated text have in common: a line of column names, then rows, refused by line
/// and column.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "load/words.hpp"

namespace vrda {

/// What a row is, for messages: "pair", "pairs", "pairs of landmarks".
struct RowWords {
  const char* one;
  const char* many;
  const char* in_full;
};

/// Refers to the text.
class CommaTable {
 public:
  /// Throws InputError of a text without any line.
  CommaTable(std::string file, std::string_view text, const RowWords& words);

  const std::string& file() const { return file_; }
  const TableLine& header() const { return lines_.front(); }
  std::size_t n_rows() const { return lines_.size() - 1; }
  const TableLine& row(std::size_t i) const { return lines_.at(i + 1); }

  /// Refuses a table without rows or with more than `most`.
  void require_rows(std::size_t most) const;
  /// The fields of a row; refuses another number than there are columns.
  std::vector<std::string_view> fields(const TableLine& row) const;

  /// Throws InputError naming the file, the line and, where there is one, the column.
  [[noreturn]] void refuse(const TableLine& line, const std::string& column, const std::string& found,
                           const std::string& wanted) const;
  /// Tells the known columns, as `in_words` lists them, and the nearest of `known`.
  [[noreturn]] void refuse_unknown(std::string_view name, const std::vector<std::string>& known,
                                   const std::string& in_words) const;
  [[noreturn]] void refuse_number(const TableLine& line, const std::string& column,
                                  std::string_view field) const;

  /// In quotation marks, whole.
  static std::string quoted(std::string_view text);

 private:
  std::string file_;
  RowWords words_;
  std::vector<TableLine> lines_;
  std::size_t n_columns_ = 0;
};

}  // namespace vrda
