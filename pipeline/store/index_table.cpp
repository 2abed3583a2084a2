#include "store/index_table.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "core/error.hpp"
#include "core/text.hpp"
#include "core/whole_file.hpp"
#include "store/dataset_specs.hpp"
#include "store/dataset_writer.hpp"
#include "store/h5_writer.hpp"

namespace vrda {
namespace {

std::size_t n_rows_of(const IndexTable& table)
{
  check(!table.columns.empty(), "an index has a first column: the names of its rows");
  return std::get<std::vector<std::string>>(table.columns.front().values).size();
}

DatasetSpec spec_of(const IndexColumn& column, const std::string& dimension)
{
  const std::string path = "/" + column.name;
  DatasetSpec spec =
      numbers(path, ValueKind::text, {dimension}, column.units.c_str(), column.long_name.c_str());
  if (std::holds_alternative<std::vector<double>>(column.values)) {
    spec.kind = ValueKind::float64;
    spec.may_be_nan = true;
  } else if (std::holds_alternative<std::vector<std::int8_t>>(column.values)) {
    spec.kind = ValueKind::int8;
    spec.flags = column.flags;
  }
  return spec;
}

FileLayout layout_of_table(const IndexTable& table)
{
  FileLayout layout;
  const std::string dimension = "/" + table.columns.front().name;
  layout.dimensions.push_back({dimension, static_cast<std::int64_t>(n_rows_of(table))});
  for (const IndexColumn& column : table.columns) layout.datasets.push_back(spec_of(column, dimension));
  return layout;
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
  throw InternalError("a code of an index stands in its table");
}

std::string field_of(const IndexColumn& column, std::size_t row)
{
  if (const auto* texts = std::get_if<std::vector<std::string>>(&column.values))
    return csv_cell(texts->at(row));
  if (const auto* codes = std::get_if<std::vector<std::int8_t>>(&column.values))
    return word_of(column.flags, codes->at(row));
  const double number = std::get<std::vector<double>>(column.values).at(row);
  return std::isnan(number) ? "" : shortest(number);
}

}  // namespace

void write_index_file(const std::string& path, const IndexTable& table)
{
  const FileLayout layout = layout_of_table(table);
  H5Writer writer(path);
  writer.write_attribute("/", "format", std::string(index_format_name));
  writer.write_attribute("/", "format_version", std::string(index_format_version));
  writer.write_attribute("/", "Conventions", std::string(conventions));
  writer.write_attribute("/", "title", table.title);
  DatasetWriter write(writer, layout);
  for (const IndexColumn& column : table.columns) {
    std::visit([&](const auto& values) { write("/" + column.name, values); }, column.values);
  }
  const std::string content = writer.bytes();
  write_whole(path, {content});
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

}  // namespace vrda
