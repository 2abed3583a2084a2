#include "store/index_table.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "core/error.hpp"
#include "core/text.hpp"
#include "store/h5_visitors.hpp"

namespace vrda::store {
namespace {

std::size_t n_rows_of(const IndexTable& table)
{
  check(!table.columns.empty(), "an index must have a first column, the names of its rows");
  return std::get<std::vector<std::string>>(table.columns.front().values).size();
}

Dataset dataset_of(const IndexColumn& column, const std::string& dimension)
{
  Dataset dataset{"/" + column.name, {dimension}, {column.units.c_str(), 0}, {}, column.long_name.c_str()};
  if (std::holds_alternative<std::vector<double>>(column.values)) dataset.valid.rule = Rule::number_or_nan;
  if (std::holds_alternative<std::vector<std::int8_t>>(column.values))
    dataset.valid = {.rule = Rule::codes, .flags = column.flags};
  return dataset;
}

std::string csv_cell(const std::string& text)
{
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + "\"";
}

std::string word_of(FlagSet flags, std::int8_t code)
{
  const FlagTable table = flag_table(flags);
  std::istringstream words(table.meanings);
  std::string word;
  for (const std::int8_t value : table.values) {
    words >> word;
    if (value == code) return word;
  }
  throw InternalError("a code of an index must be in its flag table");
}

std::string field_of(const IndexColumn& column, std::size_t row)
{
  if (const auto* texts = std::get_if<std::vector<std::string>>(&column.values))
    return csv_cell(texts->at(row));
  if (const auto* codes = std::get_if<std::vector<std::int8_t>>(&column.values))
    return word_of(column.flags, codes->at(row));
  const double number = std::get<std::vector<double>>(column.values).at(row);
  return std::isnan(number) ? "" : shortest_decimal(number);
}

}  // namespace

std::string index_bytes(const std::string& path, const IndexTable& table)
{
  const std::string dimension = "/" + table.columns.front().name;
  H5Writer writer(path);
  write_format(writer, index_format_name, index_format_version);
  writer.write_attribute("/", "title", table.title);
  Hdf5WriteVisitor write(writer, Hdf5WriteVisitor::Pass::datasets);
  write.dimension(dimension, DimensionSize::counted(n_rows_of(table)));
  for (const IndexColumn& column : table.columns)
    std::visit([&](const auto& values) { write(dataset_of(column, dimension), values); }, column.values);
  return writer.bytes();
}

std::string index_csv(const IndexTable& table)
{
  const std::size_t n_rows = n_rows_of(table);
  std::string out;
  for (const IndexColumn& column : table.columns) out += (out.empty() ? "" : ",") + column.name;
  out += "\n";
  for (std::size_t row = 0; row < n_rows; ++row) {
    for (std::size_t k = 0; k < table.columns.size(); ++k) {
      out += (k == 0 ? "" : ",") + field_of(table.columns[k], row);
    }
    out += "\n";
  }
  return out;
}

}  // namespace vrda::store
