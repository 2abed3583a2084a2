#include "job/csv_table.hpp"

#include <utility>

#include "core/error.hpp"
#include "core/text.hpp"

namespace vrda::job {

CsvTable::CsvTable(std::string file, std::string_view text, const RowLabels& words)
    : file_(std::move(file)), words_(words), lines_(table_lines(text))
{
  if (lines_.empty()) {
    throw InputError(
        {file_, "", "no line except comments", std::string("column names, then ") + words_.full_plural});
  }
  n_columns_ = split_fields(header().text).size();
}

void CsvTable::require_rows(std::size_t max_rows) const
{
  if (n_rows() == 0) refuse(header(), "", std::string("column names but no ") + words_.one, "at least one");
  if (n_rows() > max_rows) {
    refuse(header(), "", std::to_string(n_rows()) + ' ' + words_.many, "at most " + std::to_string(max_rows));
  }
}

std::vector<std::string_view> CsvTable::fields(const TableLine& row) const
{
  if (has_control_characters(row.text, "\t\r")) refuse(row, "", "control characters", "plain text");
  std::vector<std::string_view> fields = split_fields(row.text);
  if (fields.size() == n_columns_) return fields;
  refuse(row, "", std::to_string(fields.size()) + " fields",
         "as many as the columns of line " + std::to_string(header().number) + ", " +
             std::to_string(n_columns_));
}

void CsvTable::refuse(const TableLine& line, const std::string& column, const std::string& found,
                      const std::string& wanted) const
{
  const std::string place = "line " + std::to_string(line.number);
  throw InputError({file_, column.empty() ? place : place + ", " + column, found, wanted});
}

void CsvTable::refuse_unknown_column(std::string_view name, const std::vector<std::string>& known,
                                     const std::string& description) const
{
  constexpr std::size_t max_compared = 100;  // characters: bounds the cost of the edit distance
  refuse(header(), "", "the unknown column " + quoted(name),
         description + "; the nearest is " +
             quoted(nearest_word(std::string(name.substr(0, max_compared)), known)));
}

void CsvTable::refuse_number(const TableLine& line, const std::string& column, std::string_view field) const
{
  refuse(line, column, field.empty() ? "nothing" : quoted(field), "a number");
}

std::string CsvTable::quoted(std::string_view text)
{
  return '"' + std::string(text) + '"';
}

}  // namespace vrda::job
