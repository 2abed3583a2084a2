#include <array>
#include <set>
#include <sstream>

#include "bench/document_parts.hpp"
#include "show/settings_text.hpp"

namespace vrda::bench {
namespace {

constexpr std::array<const char*, n_calibration_parts> part_names{
    "viewport", "distortion", "rails", "stop", "probe", "eyepoints", "ipd",
    "subject",  "bullseye",   "head",  "leg",  "femur", "tibia",     "functional"};

}  // namespace

const char* name_of(CalibrationPart part)
{
  return part_names[static_cast<std::size_t>(part)];
}

std::vector<std::string> shared_estimate_names(CalibrationPart part)
{
  const auto of_each_eye = [](const std::vector<std::string>& numbers) {
    std::vector<std::string> named;
    for (const char* side : {"left.", "right."}) {
      for (const std::string& number : numbers) named.push_back(side + number);
    }
    return named;
  };
  switch (part) {
    case CalibrationPart::viewport:
      return of_each_eye({"edge_left", "edge_right", "edge_top", "edge_bottom", "pixel_aspect"});
    case CalibrationPart::distortion:
      return of_each_eye({"k1", "k2", "centre_x", "centre_y", "pixel_aspect"});
    case CalibrationPart::eyepoints:
      return of_each_eye({"distance", "depth"});
    case CalibrationPart::ipd:
      return {"ipd"};
    case CalibrationPart::rails:
      return pose_number_names("table");
    case CalibrationPart::probe:
      return {"probe.tip_x", "probe.tip_y", "probe.tip_z"};
    case CalibrationPart::subject:
      return {"subject.scale"};
    case CalibrationPart::femur:
    case CalibrationPart::tibia:
      return pose_number_names(name_of(part));
    default:
      return {};
  }
}

bool is_per_bench(CalibrationPart part)
{
  return part < CalibrationPart::eyepoints;
}

std::string record_key(CalibrationPart part)
{
  return std::string(is_per_bench(part) ? "per_bench." : "per_person.") + name_of(part);
}

namespace {

/// Unit of a dimensionless number in the file: the list of texts must not contain empty texts.
constexpr const char* dimensionless_unit = "1";

std::vector<CalibrationMark> marks_in(const core::Document& document, const std::string& key)
{
  std::vector<CalibrationMark> marks;
  std::set<std::string> names;
  for (const core::DocumentValue& item : core::list_or_empty(document.root, key)) {
    const CalibrationMark mark{core::text_at(item, "task"), core::rows_at(item, "rows")};
    if (!names.insert(mark.task).second) {
      document.refuse(key + "." + std::to_string(marks.size()) + ".task", "'" + mark.task + "' twice",
                      "each task only once");
    }
    marks.push_back(mark);
  }
  return marks;
}

/// Checks that a list has one item a name.
void require_size(const core::Document& document, const std::string& key, std::size_t found,
                  std::size_t wanted, const char* items)
{
  if (found == wanted) return;
  document.refuse(key, std::to_string(found) + " " + items, std::to_string(wanted) + ", one for each name");
}

/// Reads an [n, n] covariance; rows and columns follow `names`. A negative variance is an error.
Eigen::MatrixXd covariance_in(const core::Document& document, const std::string& key, std::size_t n)
{
  if (n == 0) return {};
  const std::vector<std::vector<double>> rows = core::rows_at(document.root, key);
  require_size(document, key, rows.size(), n, "rows");
  const auto size = static_cast<Eigen::Index>(n);
  Eigen::MatrixXd covariance(size, size);
  for (std::size_t i = 0; i < n; ++i) {
    require_size(document, key + "." + std::to_string(i), rows[i].size(), n, "numbers");
    covariance.row(static_cast<Eigen::Index>(i)) = Eigen::RowVectorXd::Map(rows[i].data(), size);
  }
  if (!(covariance.diagonal().minCoeff() >= 0.0))
    document.refuse(key, "a negative variance", "a covariance with a non-negative diagonal");
  return covariance;
}

Estimate estimate_in(const core::Document& document, const std::string& key)
{
  const core::DocumentValue& table = core::value_at(document.root, key);
  Estimate estimate;
  estimate.names = core::texts_at(table, "names");
  estimate.units = core::texts_at(table, "units");
  const std::size_t n = estimate.names.size();
  require_size(document, key + ".units", estimate.units.size(), n, "units");
  for (std::string& unit : estimate.units) {
    if (unit == dimensionless_unit) unit.clear();
  }
  const std::vector<double> values = core::numbers_at(table, "values");
  require_size(document, key + ".values", values.size(), n, "numbers");
  estimate.values = Eigen::VectorXd::Map(values.data(), static_cast<Eigen::Index>(n));
  estimate.covariance = covariance_in(document, key + ".covariance", n);
  estimate.dof = core::number_at(table, "dof");
  estimate.residuals = core::numbers_at(table, "residuals");
  estimate.residual_unit = core::text_or_empty(table, "residual_unit");
  estimate.residual_rms = core::number_at(table, "residual_rms");
  estimate.remarks = core::texts_at(table, "remarks");
  return estimate;
}

/// Checks that the numbers that other parts read by name are present.
void require_estimate_names(const core::Document& document, const std::string& key,
                            const Estimate& estimate, CalibrationPart part)
{
  for (const std::string& name : shared_estimate_names(part)) {
    if (index_of(estimate, name) >= 0) continue;
    document.refuse(key + ".names", "no '" + name + "'",
                    "the numbers that the part " + std::string(name_of(part)) + " estimates");
  }
}

CalibrationRecord record_in(const core::Document& document, const std::string& key, CalibrationPart part)
{
  const core::DocumentValue& table = core::value_at(document.root, key);
  CalibrationRecord record;
  record.date = core::text_at(table, "date");
  record.is_outdated = core::flag_at(table, "outdated");
  if (table.find("made_with") != nullptr) record.made_with = core::numbers_at(table, "made_with");
  record.marks = marks_in(document, key + ".mark");
  if (table.find("result") != nullptr) {
    record.estimate = estimate_in(document, key + ".result");
    require_estimate_names(document, key + ".result", *record.estimate, part);
  }
  return record;
}

std::string texts_text(const std::vector<std::string>& texts)
{
  std::string text = "[";
  for (const std::string& item : texts) text += (text.size() > 1 ? ", " : "") + show::quoted_text(item);
  return text + "]";
}

/// Writes each row on its own line.
std::string rows_text(const std::vector<std::vector<double>>& rows)
{
  std::string text = "[";
  for (const std::vector<double>& row : rows)
    text += (text.size() > 1 ? ",\n  " : "") + show::list_text(row);
  return text + "]";
}

void add_estimate(std::ostream& text, const std::string& key, const Estimate& estimate)
{
  std::vector<std::string> units = estimate.units;
  for (std::string& unit : units) {
    if (unit.empty()) unit = dimensionless_unit;
  }
  std::vector<std::vector<double>> covariance;
  for (Eigen::Index i = 0; i < estimate.covariance.rows(); ++i) {
    const Eigen::VectorXd row = estimate.covariance.row(i);
    covariance.emplace_back(row.data(), row.data() + row.size());
  }
  text << "\n[" << key << ".result]\nnames = " << texts_text(estimate.names)
       << "\nunits = " << texts_text(units) << "\nvalues = "
       << show::list_text({estimate.values.data(), static_cast<std::size_t>(estimate.values.size())})
       << "\ncovariance = " << rows_text(covariance) << "\ndof = " << show::number_text(estimate.dof)
       << "\nresiduals = " << show::list_text(estimate.residuals) << "\n";
  if (!estimate.residual_unit.empty())
    text << "residual_unit = " << show::quoted_text(estimate.residual_unit) << "\n";
  text << "residual_rms = " << show::number_text(estimate.residual_rms) << "\n";
  if (!estimate.remarks.empty()) text << "remarks = " << texts_text(estimate.remarks) << "\n";
}

}  // namespace

CalibrationRecords read_calibration_records(const core::Document& document)
{
  CalibrationRecords records;
  for (std::size_t k = 0; k < n_calibration_parts; ++k) {
    const auto part = static_cast<CalibrationPart>(k);
    if (core::find_at(document.root, record_key(part)) != nullptr)
      records[part] = record_in(document, record_key(part), part);
  }
  return records;
}

std::string records_text(const CalibrationRecords& records)
{
  std::ostringstream text;
  for (const auto& [part, record] : records) {
    const std::string key = record_key(part);
    text << "\n[" << key << "]\ndate = " << show::quoted_text(record.date) << "\n";
    if (record.is_outdated) text << "outdated = true  # must be repeated\n";
    if (!record.made_with.empty()) text << "made_with = " << show::list_text(record.made_with) << "\n";
    if (record.estimate) add_estimate(text, key, *record.estimate);
    for (const CalibrationMark& mark : record.marks) {
      text << "\n[[" << key << ".mark]]\ntask = " << show::quoted_text(mark.task)
           << "\nrows = " << rows_text(mark.rows) << "\n";
    }
  }
  return text.str();
}

}  // namespace vrda::bench
