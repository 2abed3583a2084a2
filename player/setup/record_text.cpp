#include "setup/record_text.hpp"

#include <limits>
#include <set>
#include <sstream>
#include <string_view>

#include "settings/settings_text.hpp"

namespace vrda {
namespace {

constexpr const char* bench_table = "per_bench";
constexpr const char* person_table = "per_person";
constexpr double infinite = std::numeric_limits<double>::infinity();
constexpr double largest = 1e9;
/// More than any plan of tasks has, than any task takes, than a row of any kind holds.
constexpr std::size_t most_marks = 5000, most_rows = 5000, most_across = 14;
constexpr std::size_t most_bench_numbers = 20000;
constexpr std::size_t most_numbers = 100, most_residuals = 20000, most_remarks = 100;
/// A plain number's unit, as a list of texts cannot hold an empty one.
constexpr const char* plain_unit = "1";

std::vector<CalibrationMark> marks_in(const SettingsTable& table)
{
  std::vector<CalibrationMark> marks;
  std::set<std::string> names;
  for (const SettingsTable& item : table.tables("mark", most_marks)) {
    item.require_known({"task", "rows"});
    CalibrationMark mark;
    mark.task = item.text("task");
    if (!names.insert(mark.task).second)
      item.refuse("task", "'" + mark.task + "' a second time", "each task once");
    mark.rows = item.lists("rows", most_rows, most_across, {-largest, largest});
    marks.push_back(std::move(mark));
  }
  return marks;
}

/// Its rows and columns follow the numbers; what is no covariance is refused.
Eigen::MatrixXd covariance_in(const SettingsTable& table, Eigen::Index n)
{
  if (n == 0) return {};
  const std::vector<std::vector<double>> rows =
      table.rows("covariance", static_cast<std::size_t>(n), {-largest, largest});
  if (rows.size() != static_cast<std::size_t>(n)) {
    table.refuse("covariance", std::to_string(rows.size()) + " rows",
                 std::to_string(n) + ", as many as values");
  }
  Eigen::MatrixXd covariance(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    covariance.row(i) = Eigen::RowVectorXd::Map(rows[static_cast<std::size_t>(i)].data(), n);
  if (!(covariance.diagonal().minCoeff() >= 0.0))
    table.refuse("covariance", "a variance below 0", "variances on its diagonal");
  return covariance;
}

Estimate estimate_in(const SettingsTable& table)
{
  table.require_known({"names", "units", "values", "covariance", "dof", "residuals", "residual_unit",
                       "residual_rms", "remarks"});
  Estimate estimate;
  estimate.names = table.texts("names");
  const std::size_t n = estimate.names.size();
  if (n > most_numbers)
    table.refuse("names", std::to_string(n) + " names", "at most " + std::to_string(most_numbers));
  estimate.units = table.texts("units");
  if (estimate.units.size() != n) {
    table.refuse("units", std::to_string(estimate.units.size()) + " units",
                 std::to_string(n) + ", as many as names");
  }
  for (std::string& unit : estimate.units) {
    if (unit == plain_unit) unit.clear();
  }
  const std::vector<double> values = table.numbers("values", n, {-largest, largest});
  estimate.values = Eigen::VectorXd::Map(values.data(), static_cast<Eigen::Index>(n));
  estimate.covariance = covariance_in(table, static_cast<Eigen::Index>(n));
  constexpr double least_dof = 1e-3;
  estimate.dof = table.number("dof", {least_dof, infinite});
  estimate.residuals = table.list("residuals", most_residuals, {-largest, largest});
  estimate.residual_unit = table.text_or("residual_unit", "");
  estimate.residual_rms = table.number("residual_rms", {0.0, largest});
  if (table.has("remarks")) estimate.remarks = table.texts("remarks");
  if (estimate.remarks.size() > most_remarks) {
    table.refuse("remarks", std::to_string(estimate.remarks.size()) + " lines",
                 "at most " + std::to_string(most_remarks));
  }
  return estimate;
}

/// Other parts find their numbers by name.
void require_numbers_read(const SettingsTable& table, const Estimate& estimate, CalibrationPart part)
{
  for (const std::string& name : numbers_read_of(part)) {
    if (index_of(estimate, name) < 0)
      table.refuse("names", "no '" + name + "'", "the numbers that " + std::string(name_of(part)) + " finds");
  }
}

CalibrationRecord record_in(const SettingsTable& table, CalibrationPart part)
{
  table.require_known({"date", "outdated", "made_with", "mark", "result"});
  CalibrationRecord record;
  record.date = table.text("date");
  record.is_outdated = table.flag_or("outdated", false);
  if (table.has("made_with"))
    record.made_with = table.list("made_with", most_bench_numbers, {-largest, largest});
  record.marks = marks_in(table);
  if (table.has("result")) {
    const SettingsTable result = table.table("result");
    record.estimate = estimate_in(result);
    require_numbers_read(result, *record.estimate, part);
  }
  return record;
}

void add_records(const SettingsTable& root, const char* name, CalibrationRecords& records)
{
  if (!root.has(name)) return;
  const SettingsTable table = root.table(name);
  const bool is_bench = std::string_view(name) == bench_table;
  if (is_bench) {
    table.require_known({"viewport", "distortion", "rails", "stop", "probe"});
  } else {
    table.require_known({"eyepoints", "ipd", "subject", "bullseye", "head", "leg", "femur", "tibia"});
  }
  for (std::size_t k = 0; k < n_calibration_parts; ++k) {
    const auto part = static_cast<CalibrationPart>(k);
    if (is_once_a_bench(part) != is_bench || !table.has(name_of(part))) continue;
    records[part] = record_in(table.table(name_of(part)), part);
  }
}

std::string texts_text(const std::vector<std::string>& texts)
{
  std::string text = "[";
  for (const std::string& item : texts) text += (text.size() > 1 ? ", " : "") + quoted_text(item);
  return text + "]";
}

/// A row of the list on a line of its own.
std::string rows_text(const std::vector<std::vector<double>>& rows)
{
  std::string text = "[";
  for (const std::vector<double>& row : rows) text += (text.size() > 1 ? ",\n  " : "") + list_text(row);
  return text + "]";
}

void add_estimate(std::ostream& text, const std::string& place, const Estimate& estimate)
{
  std::vector<std::string> units = estimate.units;
  for (std::string& unit : units) {
    if (unit.empty()) unit = plain_unit;
  }
  std::vector<std::vector<double>> covariance;
  for (Eigen::Index i = 0; i < estimate.covariance.rows(); ++i) {
    const Eigen::VectorXd row = estimate.covariance.row(i);
    covariance.emplace_back(row.data(), row.data() + row.size());
  }
  text << "\n[" << place << ".result]\nnames = " << texts_text(estimate.names)
       << "\nunits = " << texts_text(units) << "\nvalues = "
       << list_text({estimate.values.data(), static_cast<std::size_t>(estimate.values.size())})
       << "\ncovariance = " << rows_text(covariance) << "\ndof = " << number_text(estimate.dof)
       << "\nresiduals = " << list_text(estimate.residuals) << "\n";
  if (!estimate.residual_unit.empty())
    text << "residual_unit = " << quoted_text(estimate.residual_unit) << "\n";
  text << "residual_rms = " << number_text(estimate.residual_rms) << "\n";
  if (!estimate.remarks.empty()) text << "remarks = " << texts_text(estimate.remarks) << "\n";
}

}  // namespace

CalibrationRecords records_in(const SettingsTable& root)
{
  CalibrationRecords records;
  add_records(root, bench_table, records);
  add_records(root, person_table, records);
  return records;
}

std::string records_text(const CalibrationRecords& records)
{
  std::ostringstream text;
  for (const auto& [part, record] : records) {
    const std::string place =
        std::string(is_once_a_bench(part) ? bench_table : person_table) + "." + name_of(part);
    text << "\n[" << place << "]\ndate = " << quoted_text(record.date) << "\n";
    if (record.is_outdated) text << "outdated = true  # to be done again\n";
    if (!record.made_with.empty()) text << "made_with = " << list_text(record.made_with) << "\n";
    if (record.estimate) add_estimate(text, place, *record.estimate);
    for (const CalibrationMark& mark : record.marks) {
      text << "\n[[" << place << ".mark]]\ntask = " << quoted_text(mark.task)
           << "\nrows = " << rows_text(mark.rows) << "\n";
    }
  }
  return text.str();
}

}  // namespace vrda
