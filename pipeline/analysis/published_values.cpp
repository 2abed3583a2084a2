#include "analysis/published_values.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/text.hpp"
#include "core/units.hpp"
#include "job/csv_table.hpp"
#include "job/words.hpp"

namespace vrda::analysis {
namespace {

constexpr std::size_t most_rows = 100000;

enum Field : std::size_t { f_test, f_flexion, f_value, f_load, f_sd, f_source, f_state, n_fields };
constexpr const char* field_names[] = {"test", "flexion_deg", "value", "load", "sd", "source", "state",
                                       // Further columns of laxity.csv, not read.
                                       "load_unit", "unit", "position", "change_by_cut", "status"};

std::vector<std::string> test_names()
{
  std::vector<std::string> names;
  for (std::size_t k = 0; k < n_laxity_tests; ++k) {
    const TestKind& kind = kind_of(static_cast<LaxityTest>(k));
    names.emplace_back(kind.name);
    if (k % 2 == 1) names.emplace_back(kind.both);
  }
  return names;
}

double number_of(const job::CsvTable& table, const job::TableLine& line, Field field, std::string_view text)
{
  const std::optional<double> number = job::parse_real(text);
  if (!number || !std::isfinite(*number)) table.refuse_number(line, field_names[field], text);
  return *number;
}

// Nothing for a row of a cut, or one without a value.
std::optional<PublishedValue> value_of(const job::CsvTable& table, const job::TableLine& line,
                                       const std::vector<Field>& columns)
{
  PublishedValue row;
  bool is_whole = true;
  const std::vector<std::string_view> texts = table.fields(line);
  for (std::size_t k = 0; k < texts.size(); ++k) {
    const Field field = columns[k];
    const std::string text(texts[k]);
    if (field == f_test) {
      row.test = text;
      if (!is_test_name(text)) table.refuse(line, "test", '"' + text + '"', join_alternatives(test_names()));
    } else if (field == f_source) {
      row.source = text;
    } else if (field == f_state) {
      is_whole = text.empty() || text == whole_state;
    } else if (field >= n_fields) {
      continue;
    } else if (field == f_value && text.empty()) {
      row.value = nan;
    } else if (!text.empty() || field == f_flexion) {
      const double number = number_of(table, line, field, text);
      if (field == f_flexion) row.flexion_deg = number;
      if (field == f_value) row.value = number;
      if (field == f_load) row.load = number;
      if (field == f_sd) row.sd = number;
      if ((field == f_load || field == f_sd) && !(number > 0.0))
        table.refuse(line, field_names[field], text, "a number above 0");
    }
  }
  if (!is_whole || std::isnan(row.value)) return std::nullopt;
  return row;
}

// Of one direction at a flexion row.
double at_row(const LaxityResult& result, LaxityTest test, std::size_t flexion, double load)
{
  for (const LaxityCurve& curve : result.curves) {
    if (curve.state != 0 || curve.test != test || curve.flexion != flexion) continue;
    return in_file_unit(kind_of(test), std::isnan(load) ? curve.laxity() : laxity_at_load(curve, load));
  }
  return nan;
}

// Linear between the flexions of the job.
double at_flexion(const LaxityResult& result, LaxityTest test, const PublishedValue& row)
{
  const std::vector<double>& flexions = result.loads.flexion_deg;
  for (std::size_t k = 0; k < flexions.size(); ++k) {
    if (row.flexion_deg == flexions[k]) return at_row(result, test, k, row.load);
    if (k + 1 == flexions.size() || row.flexion_deg < flexions[k] || row.flexion_deg > flexions[k + 1])
      continue;
    const double share = (row.flexion_deg - flexions[k]) / (flexions[k + 1] - flexions[k]);
    return (1.0 - share) * at_row(result, test, k, row.load) + share * at_row(result, test, k + 1, row.load);
  }
  return nan;
}

}  // namespace

bool is_test_name(const std::string& name)
{
  const std::vector<std::string> names = test_names();
  return std::find(names.begin(), names.end(), name) != names.end();
}

double in_file_unit(const TestKind& kind, double value)
{
  return kind.is_force() ? value : deg_from_rad(value);
}

std::vector<PublishedValue> published_values(const std::string& file, std::string_view text)
{
  const job::CsvTable table(file, text, {"value", "values", "values"});
  const std::vector<std::string> known(std::begin(field_names), std::end(field_names));
  std::vector<Field> columns;
  for (const std::string_view name : job::split_fields(table.header().text)) {
    const auto at = std::find(known.begin(), known.end(), name);
    if (at == known.end())
      table.refuse_unknown_column(name, known, "test, flexion_deg, value, load, sd, source");
    columns.push_back(static_cast<Field>(at - known.begin()));
    if (std::count(columns.begin(), columns.end(), columns.back()) > 1)
      table.refuse(table.header(), std::string(name), "the column twice", "each column once");
  }
  for (const Field needed : {f_test, f_flexion, f_value}) {
    if (std::find(columns.begin(), columns.end(), needed) == columns.end())
      table.refuse(table.header(), field_names[needed], "no such column", "this column");
  }
  table.require_rows(most_rows);
  std::vector<PublishedValue> rows;
  for (std::size_t k = 0; k < table.n_rows(); ++k) {
    if (const std::optional<PublishedValue> row = value_of(table, table.row(k), columns))
      rows.push_back(*row);
  }
  return rows;
}

std::vector<Compared> compared(const LaxityResult& result, const std::vector<PublishedValue>& published)
{
  std::vector<Compared> all;
  for (const PublishedValue& row : published) {
    Compared one{row, 0.0, {}};
    for (std::size_t k = 0; k < n_laxity_tests; ++k) {
      const auto test = static_cast<LaxityTest>(k);
      if (row.test == kind_of(test).name || row.test == kind_of(test).both)
        one.found += at_flexion(result, test, row);
    }
    if (std::isnan(one.found))
      one.missing = "not among the tests, flexions and loads of the job, or not solved";
    all.push_back(one);
  }
  return all;
}

}  // namespace vrda::analysis
