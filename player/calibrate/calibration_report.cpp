#include "calibrate/calibration_report.hpp"

#include <algorithm>
#include <cmath>
#include <ostream>

#include "calibration_tasks/parts.hpp"
#include "settings/settings_text.hpp"

namespace vrda::calibrate {
namespace {

std::string padded(std::string text, std::size_t width)
{
  text.resize(std::max(width, text.size()), ' ');
  return text;
}

/// JSON has no NaN or infinity.
std::string json_number(double value)
{
  return std::isfinite(value) ? settings::number_text(value) : "null";
}

/// Decimals for two significant digits of `size`.
int decimals_for(double size)
{
  constexpr int most = 9;
  if (!(size > 0.0) || !std::isfinite(size)) return 3;
  return std::clamp(1 - static_cast<int>(std::floor(std::log10(size))), 0, most);
}

const bench_files::CalibrationRecord* record_of(const bench_files::Calibration& calibration,
                                                bench_files::CalibrationPart part)
{
  const auto found = calibration.records.find(part);
  return found == calibration.records.end() ? nullptr : &found->second;
}

const char* state_of(const bench_files::CalibrationRecord* record)
{
  if (record == nullptr || (record->marks.empty() && !record->estimate)) return "missing";
  if (!record->estimate) return "begun";
  return record->is_outdated ? "outdated" : "done";
}

void write_part(std::ostream& out, bench_files::CalibrationPart part,
                const bench_files::CalibrationRecord* record)
{
  const std::string state = state_of(record);
  out << padded(bench_files::name_of(part), 12) << state;
  if (state == "missing") {
    out << "\n";
    return;
  }
  if (state == "begun")
    out << ": " << record->marks.size() << (record->marks.size() == 1 ? " mark so far" : " marks so far");
  if (state == "outdated") out << ": must be repeated";
  out << ", " << record->date << "\n";
  if (!record->estimate) return;
  const calibration::Estimate& estimate = *record->estimate;
  for (std::size_t k = 0; k < estimate.names.size(); ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    out << "  " << padded(estimate.names[k], 22)
        << interval_text(estimate.values[row], calibration::half_width_95(estimate, row), estimate.units[k])
        << "\n";
  }
  if (!estimate.residuals.empty()) {
    out << "  residual rms "
        << settings::rounded_text(estimate.residual_rms, decimals_for(estimate.residual_rms)) << " "
        << estimate.residual_unit << " of " << estimate.residuals.size() << "\n";
  }
  for (const std::string& remark : estimate.remarks) out << "  " << remark << "\n";
}

std::string json_of(const calibration::Estimate& estimate)
{
  std::string text = "\"numbers\": [";
  for (std::size_t k = 0; k < estimate.names.size(); ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    text += std::string(k == 0 ? "" : ", ") + "{\"name\": " + settings::quoted_text(estimate.names[k]) +
            ", \"unit\": " + settings::quoted_text(estimate.units[k]) +
            ", \"value\": " + json_number(estimate.values[row]) +
            ", \"half_width_95\": " + json_number(calibration::half_width_95(estimate, row)) + "}";
  }
  text += "], \"residual_rms\": " + json_number(estimate.residual_rms) +
          ", \"residual_unit\": " + settings::quoted_text(estimate.residual_unit) +
          ", \"residuals\": " + std::to_string(estimate.residuals.size()) + ", \"remarks\": [";
  for (std::size_t k = 0; k < estimate.remarks.size(); ++k)
    text += (k == 0 ? "" : ", ") + settings::quoted_text(estimate.remarks[k]);
  return text + "]";
}

std::string json_of(std::span<const bench_files::CalibrationPart> parts)
{
  std::string text = "[";
  for (const bench_files::CalibrationPart part : parts)
    text += (text.size() > 1 ? ", \"" : "\"") + std::string(bench_files::name_of(part)) + "\"";
  return text + "]";
}

struct Quantiles {
  double median = 0.0, most_of_ten = 0.0, largest = 0.0;
};

/// By nearest rank.
Quantiles quantiles_of(std::vector<double> values)
{
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  const auto at = [&](double share) {
    const double rank = std::ceil(share * static_cast<double>(values.size()));
    return values[static_cast<std::size_t>(std::max(1.0, rank)) - 1];
  };
  return {at(0.5), at(0.9), values.back()};
}

std::string json_of(const TargetSummary& s)
{
  return "{\"mm\": {\"median\": " + json_number(s.median_mm) + ", \"p90\": " + json_number(s.p90_mm) +
         ", \"largest\": " + json_number(s.largest_mm) +
         "}, \"arc_min\": {\"median\": " + json_number(s.median_arc_min) +
         ", \"p90\": " + json_number(s.p90_arc_min) + ", \"largest\": " + json_number(s.largest_arc_min) +
         "}}";
}

void write_summary(std::ostream& out, const char* name, std::span<const virtual_bench::TargetError> errors)
{
  const TargetSummary s = summary_of(errors);
  const auto mm = [](double value) { return settings::rounded_text(value, 2); };
  const auto arc_min = [](double value) { return settings::rounded_text(value, 1); };
  out << "  " << padded(name, 8) << "median " << mm(s.median_mm) << " mm (" << arc_min(s.median_arc_min)
      << "'), 9 of 10 within " << mm(s.p90_mm) << " mm (" << arc_min(s.p90_arc_min) << "'), largest "
      << mm(s.largest_mm) << " mm (" << arc_min(s.largest_arc_min) << "')\n";
}

double share_of(const virtual_bench::NumberStatistics& number)
{
  return number.n > 0 ? 100.0 * number.n_within / number.n : 0.0;
}

}  // namespace

std::string interval_text(double value, double half_width, const std::string& unit)
{
  const int decimals = decimals_for(half_width);
  return settings::rounded_text(value, decimals) + " +- " + settings::rounded_text(half_width, decimals) +
         (unit.empty() ? "" : " " + unit);
}

std::vector<bench_files::CalibrationPart> missing_parts(const bench_files::Calibration& calibration,
                                                        std::span<const bench_files::CalibrationPart> parts)
{
  std::vector<bench_files::CalibrationPart> missing;
  for (const bench_files::CalibrationPart part : parts) {
    const bench_files::CalibrationRecord* record = record_of(calibration, part);
    if (record == nullptr || !record->estimate || record->is_outdated) missing.push_back(part);
  }
  return missing;
}

void write_status(std::ostream& out, const bench_files::Calibration& calibration,
                  std::span<const bench_files::CalibrationPart> parts)
{
  for (const bench_files::CalibrationPart part : parts) write_part(out, part, record_of(calibration, part));
  const std::vector<bench_files::CalibrationPart> missing = missing_parts(calibration, parts);
  if (!missing.empty()) out << "to be done: " << calibration_tasks::names_of(missing) << "\n";
}

void write_status_json(std::ostream& out, const bench_files::BenchFile& bench,
                       const bench_files::Calibration& calibration,
                       std::span<const bench_files::CalibrationPart> parts)
{
  out << "{\"bench\": " << settings::quoted_text(bench.title) << ", \"parts\": [";
  for (std::size_t k = 0; k < parts.size(); ++k) {
    const bench_files::CalibrationRecord* record = record_of(calibration, parts[k]);
    out << (k == 0 ? "" : ", ") << "{\"name\": \"" << bench_files::name_of(parts[k]) << "\", \"once\": \""
        << (bench_files::is_per_bench(parts[k]) ? "bench" : "person") << "\", \"state\": \""
        << state_of(record) << "\"";
    if (record != nullptr)
      out << ", \"date\": " << settings::quoted_text(record->date) << ", \"marks\": " << record->marks.size();
    if (record != nullptr && record->estimate) out << ", " << json_of(*record->estimate);
    out << "}";
  }
  out << "], \"to_be_done\": " << json_of(missing_parts(calibration, parts)) << "}";
}

TargetSummary summary_of(std::span<const virtual_bench::TargetError> errors)
{
  std::vector<double> mm, arc_min;
  for (const virtual_bench::TargetError& error : errors) {
    mm.push_back(error.mm);
    arc_min.push_back(error.arc_min);
  }
  const Quantiles lengths = quantiles_of(std::move(mm)), angles = quantiles_of(std::move(arc_min));
  return {lengths.median, lengths.most_of_ten, lengths.largest,
          angles.median,  angles.most_of_ten,  angles.largest};
}

void write_targets(std::ostream& out, std::span<const virtual_bench::TargetError> before,
                   std::span<const virtual_bench::TargetError> after,
                   std::span<const bench_files::CalibrationPart> missing)
{
  out << "overlay error at " << before.size() << " targets (mm across the line of sight, arc minutes)\n";
  write_summary(out, "before", before);
  if (missing.empty()) {
    write_summary(out, "after", after);
  } else {
    out << "  " << padded("after", 8)
        << "unknown until these parts are done: " << calibration_tasks::names_of(missing) << "\n";
  }
}

void write_targets_json(std::ostream& out, std::span<const virtual_bench::TargetError> before,
                        std::span<const virtual_bench::TargetError> after,
                        std::span<const bench_files::CalibrationPart> missing)
{
  out << "{\"n\": " << before.size() << ", \"before\": " << json_of(summary_of(before))
      << ", \"after\": " << (missing.empty() ? json_of(summary_of(after)) : "null")
      << ", \"to_be_done\": " << json_of(missing) << "}";
}

void write_statistics(std::ostream& out, const virtual_bench::VirtualStatistics& statistics)
{
  out << statistics.n_benches << " benches; a part was rejected and repeated on " << statistics.n_refused
      << "\n"
      << padded("part", 12) << padded("number", 22) << padded("within 95 %", 14) << padded("rms error", 12)
      << "mean half width\n";
  for (const virtual_bench::NumberStatistics& number : statistics.numbers) {
    out << padded(number.part, 12) << padded(number.name, 22)
        << padded(settings::rounded_text(share_of(number), 1) + " %", 14)
        << padded(settings::rounded_text(number.rms_error, decimals_for(number.rms_error)), 12)
        << settings::rounded_text(number.mean_half_width, decimals_for(number.mean_half_width))
        << (number.unit.empty() ? "" : " " + number.unit) << "\n";
  }
  write_targets(out, statistics.before, statistics.after, {});
}

void write_statistics_json(std::ostream& out, const virtual_bench::VirtualStatistics& statistics)
{
  out << "{\"benches\": " << statistics.n_benches << ", \"refused\": " << statistics.n_refused
      << ", \"numbers\": [";
  for (std::size_t k = 0; k < statistics.numbers.size(); ++k) {
    const virtual_bench::NumberStatistics& number = statistics.numbers[k];
    out << (k == 0 ? "" : ", ") << "{\"part\": " << settings::quoted_text(number.part)
        << ", \"name\": " << settings::quoted_text(number.name)
        << ", \"unit\": " << settings::quoted_text(number.unit) << ", \"n\": " << number.n
        << ", \"within\": " << number.n_within << ", \"rms_error\": " << json_number(number.rms_error)
        << ", \"mean_half_width_95\": " << json_number(number.mean_half_width) << "}";
  }
  out << "], \"targets\": ";
  write_targets_json(out, statistics.before, statistics.after, {});
  out << "}";
}

}  // namespace vrda::calibrate
