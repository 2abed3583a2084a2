/// Tables of comma-separated text: a line of column names, then rows. Errors name line and column.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "job/words.hpp"

namespace vrda::job {

/// Names of the rows in messages: "pair", "pairs", "pairs of landmarks".
struct RowLabels {
  const char* one;
  const char* many;
  const char* full_plural;
};

/// The text must outlive the table.
class CsvTable {
 public:
  /// Throws InputError if the text has no line other than comments.
  CsvTable(std::string file, std::string_view text, const RowLabels& words);

  const std::string& file() const { return file_; }
  const TableLine& header() const { return lines_.front(); }
  std::size_t n_rows() const { return lines_.size() - 1; }
  const TableLine& row(std::size_t i) const { return lines_.at(i + 1); }

  /// Throws InputError if there are no rows or more than `max_rows`.
  void require_rows(std::size_t max_rows) const;
  /// The fields of a row. Throws InputError if their number differs from the number of columns.
  std::vector<std::string_view> fields(const TableLine& row) const;

  /// Throws InputError naming file, line and, unless empty, column.
  [[noreturn]] void refuse(const TableLine& line, const std::string& column, const std::string& found,
                           const std::string& wanted) const;
  /// The message contains `description` (the list of known columns) and the nearest name of `known`.
  [[noreturn]] void refuse_unknown_column(std::string_view name, const std::vector<std::string>& known,
                                          const std::string& description) const;
  [[noreturn]] void refuse_number(const TableLine& line, const std::string& column,
                                  std::string_view field) const;

  /// The text in quotation marks, not shortened.
  static std::string quoted(std::string_view text);

 private:
  std::string file_;
  RowLabels words_;
  std::vector<TableLine> lines_;
  std::size_t n_columns_ = 0;
};

}  // namespace vrda::job
