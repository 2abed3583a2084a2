#include "job/landmarks.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include "core/error.hpp"
#include "core/text.hpp"
#include "core/schema.hpp"
#include "job/csv_table.hpp"

namespace vrda::job {

const core::DocumentSchema& landmarks_schema();  // schemas/landmarks.schema.json

namespace {

constexpr std::size_t max_pairs = 10000;  // more is probably another kind of file
constexpr double least_distance = 1e-9;   // as in the schema

// A row as a table by column. Empty fields are omitted; invalid numbers stay text, which the schema rejects.
core::DocumentValue row_of(const std::vector<std::string_view>& columns,
                                const std::vector<std::string_view>& fields, const TableLine& line)
{
  core::DocumentValue::Table row;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const std::optional<double> number = columns[i] == "name" ? std::nullopt : parse_real(fields[i]);
    if (fields[i].empty()) continue;
    row.push_back({std::string(columns[i]), number && std::isfinite(*number)
                                                ? core::DocumentValue{*number}
                                                : core::DocumentValue{std::string(fields[i])}});
  }
  return {row, static_cast<int>(line.number)};
}

std::vector<std::string_view> columns_of(const CsvTable& table)
{
  std::vector<std::string_view> columns = split_fields(table.header().text);
  const core::Document header{table.file(), row_of(columns, columns, table.header())};
  landmarks_schema().check_known_keys(header);
  landmarks_schema().check_required_keys(header);
  for (const std::string_view column : columns) {
    if (std::count(columns.begin(), columns.end(), column) > 1)
      header.refuse(std::string(column), "a second column of this name", "each column once");
  }
  return columns;
}

LandmarkPair pair_of(const core::Document& row)
{
  const core::DocumentValue pair = landmarks_schema().checked(row);
  const auto point = [&](const std::string& of) {
    return Eigen::Vector3d(core::number_at(pair, of + "x"), core::number_at(pair, of + "y"),
                           core::number_at(pair, of + "z"));
  };
  const LandmarkPair landmarks{core::text_at(pair, "name"), point("a"), point("b"),
                               core::number_at(pair, "subject_mm")};
  if (!((landmarks.a_native - landmarks.b_native).norm() > least_distance))
    row.refuse("", "two coincident points", "two landmarks at different positions");
  return landmarks;
}

}  // namespace

std::vector<LandmarkPair> read_landmarks(const std::string& file, std::string_view text)
{
  const CsvTable table(file, text, {"pair", "pairs", "pairs of landmarks"});
  const std::vector<std::string_view> columns = columns_of(table);
  table.require_rows(max_pairs);
  std::vector<LandmarkPair> pairs;
  std::set<std::string> names;
  for (std::size_t i = 0; i < table.n_rows(); ++i) {
    const core::Document row{file, row_of(columns, table.fields(table.row(i)), table.row(i))};
    pairs.push_back(pair_of(row));
    if (!names.insert(pairs.back().name).second)
      row.refuse("name", CsvTable::quoted(pairs.back().name) + " a second time",
                 "a unique name for each pair");
  }
  return pairs;
}

Scaling fit_scaling(const std::vector<LandmarkPair>& pairs, double unit_mm)
{
  check(!pairs.empty(), "fitting a factor requires at least one pair");
  Scaling scaling;
  double model_subject = 0.0, model_sq = 0.0, residual_sq = 0.0;
  for (const LandmarkPair& pair : pairs) {
    const double model_mm = unit_mm * (pair.a_native - pair.b_native).norm();
    scaling.landmark.push_back(pair.name);
    scaling.model_mm.push_back(model_mm);
    scaling.subject_mm.push_back(pair.subject_mm);
    model_subject += model_mm * pair.subject_mm;
    model_sq += model_mm * model_mm;
  }
  const double factor = model_subject / model_sq;
  scaling.factor.setConstant(factor);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const double residual_mm = scaling.subject_mm[i] - factor * scaling.model_mm[i];
    scaling.residual_mm.push_back(residual_mm);
    residual_sq += residual_mm * residual_mm;
  }
  const auto n = static_cast<double>(pairs.size());
  scaling.residual_rms_mm = std::sqrt(residual_sq / n);
  if (pairs.size() > 1) scaling.standard_error = std::sqrt(residual_sq / (n - 1.0) / model_sq);
  return scaling;
}

}  // namespace vrda::job
