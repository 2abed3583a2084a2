#include "calibration/calibration_report.hpp"

#include <algorithm>
#include <cmath>
#include <ostream>

#include "calibration/marks.hpp"
#include "calibration/parts.hpp"
#include "show/settings_text.hpp"

namespace vrda::calibration {
namespace {

std::string padded(std::string text, std::size_t width)
{
  text.resize(std::max(width, text.size()), ' ');
  return text;
}

/// JSON has no NaN or infinity.
std::string json_number(double value)
{
  return std::isfinite(value) ? show::number_text(value) : "null";
}

const char* state_of(const CalibrationRecord* record)
{
  if (record == nullptr || (record->marks.empty() && !record->estimate)) return "missing";
  if (!record->estimate) return "begun";
  return record->is_outdated ? "outdated" : "done";
}

void write_part(std::ostream& out, CalibrationPart part, const CalibrationRecord* record)
{
  const std::string state = state_of(record);
  out << padded(bench::name_of(part), 12) << state;
  if (state == "missing") {
    out << (calibration::is_optional(part) ? ", optional\n" : "\n");
    return;
  }
  if (state == "begun")
    out << ": " << record->marks.size() << (record->marks.size() == 1 ? " mark so far" : " marks so far");
  if (state == "outdated") out << ": must be repeated";
  out << ", " << record->date << "\n";
  if (!record->estimate) return;
  const bench::Estimate& estimate = *record->estimate;
  for (std::size_t k = 0; k < estimate.names.size(); ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    out << "  " << padded(estimate.names[k], 22) << bench::interval_text(estimate, row) << "\n";
  }
  if (!estimate.residuals.empty()) {
    out << "  residual rms "
        << show::rounded_text(estimate.residual_rms, bench::decimals_for(estimate.residual_rms))
        << " " << estimate.residual_unit << " of " << estimate.residuals.size() << "\n";
  }
  for (const std::string& remark : estimate.remarks) out << "  " << remark << "\n";
}

std::string json_of(const bench::Estimate& estimate)
{
  std::string text = "\"numbers\": [";
  for (std::size_t k = 0; k < estimate.names.size(); ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    text += std::string(k == 0 ? "" : ", ") + "{\"name\": " + show::quoted_text(estimate.names[k]) +
            ", \"unit\": " + show::quoted_text(estimate.units[k]) +
            ", \"value\": " + json_number(estimate.values[row]) +
            ", \"half_width_95\": " + json_number(bench::half_width_95(estimate, row)) + "}";
  }
  text += "], \"residual_rms\": " + json_number(estimate.residual_rms) +
          ", \"residual_unit\": " + show::quoted_text(estimate.residual_unit) +
          ", \"residuals\": " + std::to_string(estimate.residuals.size()) + ", \"remarks\": [";
  for (std::size_t k = 0; k < estimate.remarks.size(); ++k)
    text += (k == 0 ? "" : ", ") + show::quoted_text(estimate.remarks[k]);
  return text + "]";
}

std::string json_of(std::span<const CalibrationPart> parts)
{
  std::string text = "[";
  for (const CalibrationPart part : parts)
    text += (text.size() > 1 ? ", \"" : "\"") + std::string(bench::name_of(part)) + "\"";
  return text + "]";
}

/// By nearest rank.
Quantiles quantiles_of(std::vector<double> values)
{
  if (values.empty()) return {};
  std::ranges::sort(values);
  const auto at = [&](double share) {
    const double rank = std::ceil(share * static_cast<double>(values.size()));
    return values[static_cast<std::size_t>(std::max(1.0, rank)) - 1];
  };
  return {at(0.5), at(0.9), values.back()};
}

std::string json_of(const Quantiles& of)
{
  return "{\"median\": " + json_number(of.median) + ", \"p90\": " + json_number(of.p90) +
         ", \"largest\": " + json_number(of.largest) + "}";
}

std::string json_of(const TargetSummary& s)
{
  return "{\"mm\": " + json_of(s.mm) + ", \"arc_min\": " + json_of(s.arc_min) + "}";
}

void write_summary(std::ostream& out, const char* name, std::span<const TargetError> errors)
{
  const TargetSummary s = summary_of(errors);
  const auto text = [](double mm, double arc_min) {
    return show::rounded_text(mm, 2) + " mm (" + show::rounded_text(arc_min, 1) + "')";
  };
  out << "  " << padded(name, 8) << "median " << text(s.mm.median, s.arc_min.median) << ", 9 of 10 within "
      << text(s.mm.p90, s.arc_min.p90) << ", largest " << text(s.mm.largest, s.arc_min.largest) << "\n";
}

double share_of(const NumberStatistics& number)
{
  return number.n > 0 ? 100.0 * number.n_within / number.n : 0.0;
}

}  // namespace

std::vector<CalibrationPart> missing_parts(const Calibration& calibration,
                                           std::span<const CalibrationPart> parts)
{
  std::vector<CalibrationPart> missing;
  for (const CalibrationPart part : parts) {
    if (!calibration::is_optional(part) && !calibration::is_done(calibration, part))
      missing.push_back(part);
  }
  return missing;
}

void write_status(std::ostream& out, const Calibration& calibration, std::span<const CalibrationPart> parts)
{
  for (const CalibrationPart part : parts)
    write_part(out, part, calibration::find_record(calibration, part));
  const std::vector<CalibrationPart> missing = missing_parts(calibration, parts);
  if (!missing.empty()) out << "to be done: " << calibration::names_of(missing) << "\n";
}

void write_status_json(std::ostream& out, const BenchFile& bench, const Calibration& calibration,
                       std::span<const CalibrationPart> parts)
{
  out << "{\"bench\": " << show::quoted_text(bench.title) << ", \"parts\": [";
  for (std::size_t k = 0; k < parts.size(); ++k) {
    const CalibrationRecord* record = calibration::find_record(calibration, parts[k]);
    out << (k == 0 ? "" : ", ") << "{\"name\": \"" << bench::name_of(parts[k]) << "\", \"once\": \""
        << (bench::is_per_bench(parts[k]) ? "bench" : "person") << "\", \"state\": \""
        << state_of(record) << "\"";
    if (record != nullptr)
      out << ", \"date\": " << show::quoted_text(record->date) << ", \"marks\": " << record->marks.size();
    if (record != nullptr && record->estimate) out << ", " << json_of(*record->estimate);
    out << "}";
  }
  out << "], \"to_be_done\": " << json_of(missing_parts(calibration, parts)) << "}";
}

TargetSummary summary_of(std::span<const TargetError> errors)
{
  std::vector<double> mm, arc_min;
  for (const TargetError& error : errors) {
    mm.push_back(error.mm);
    arc_min.push_back(error.arc_min);
  }
  return {quantiles_of(std::move(mm)), quantiles_of(std::move(arc_min))};
}

void write_targets(std::ostream& out, std::span<const TargetError> before, std::span<const TargetError> after,
                   std::span<const CalibrationPart> missing)
{
  out << "overlay error at " << before.size() << " targets (mm across the line of sight, arc minutes)\n";
  write_summary(out, "before", before);
  if (missing.empty()) {
    write_summary(out, "after", after);
  } else {
    out << "  " << padded("after", 8)
        << "unknown until these parts are done: " << calibration::names_of(missing) << "\n";
  }
}

void write_targets_json(std::ostream& out, std::span<const TargetError> before,
                        std::span<const TargetError> after, std::span<const CalibrationPart> missing)
{
  out << "{\"n\": " << before.size() << ", \"before\": " << json_of(summary_of(before))
      << ", \"after\": " << (missing.empty() ? json_of(summary_of(after)) : "null")
      << ", \"to_be_done\": " << json_of(missing) << "}";
}

void write_joint(std::ostream& out, const JointError& error)
{
  out << "error at the joint (root mean square of both bones): by landmarks "
      << show::rounded_text(error.by_landmarks_mm, 2) << " mm, by motion "
      << show::rounded_text(error.functional_mm, 2) << " mm\n";
}

namespace {

struct JointSummary {
  Quantiles by_landmarks, functional;
  std::ptrdiff_t n_halved = 0;
};

JointSummary summary_of(std::span<const JointError> joints)
{
  std::vector<double> by_landmarks, functional;
  for (const JointError& error : joints) {
    by_landmarks.push_back(error.by_landmarks_mm);
    functional.push_back(error.functional_mm);
  }
  const auto is_halved = [](const JointError& e) { return e.functional_mm <= 0.5 * e.by_landmarks_mm; };
  return {quantiles_of(std::move(by_landmarks)), quantiles_of(std::move(functional)),
          std::ranges::count_if(joints, is_halved)};
}

void write_joints(std::ostream& out, std::span<const JointError> joints)
{
  const JointSummary s = summary_of(joints);
  const auto row = [&](const char* name, const Quantiles& of) {
    out << "  " << padded(name, 16) << "median " << show::rounded_text(of.median, 2) << " mm, 9 of 10 within "
        << show::rounded_text(of.p90, 2) << " mm, largest " << show::rounded_text(of.largest, 2) << " mm\n";
  };
  out << "error at the joint of " << joints.size() << " legs (root mean square of both bones)\n";
  row("by landmarks", s.by_landmarks);
  row("by motion", s.functional);
  out << "  at least halved in " << s.n_halved << " of " << joints.size() << "\n";
}

}  // namespace

void write_statistics(std::ostream& out, const VirtualStatistics& statistics)
{
  out << statistics.n_benches << " benches; a part was rejected and repeated on " << statistics.n_refused
      << "\n"
      << padded("part", 12) << padded("number", 22) << padded("within 95 %", 14) << padded("rms error", 12)
      << "mean half width\n";
  for (const NumberStatistics& number : statistics.numbers) {
    out << padded(number.part, 12) << padded(number.name, 22)
        << padded(show::rounded_text(share_of(number), 1) + " %", 14)
        << padded(show::rounded_text(number.rms_error, bench::decimals_for(number.rms_error)), 12)
        << show::rounded_text(number.mean_half_width, bench::decimals_for(number.mean_half_width))
        << (number.unit.empty() ? "" : " " + number.unit) << "\n";
  }
  if (!statistics.joints.empty()) return write_joints(out, statistics.joints);
  write_targets(out, statistics.before, statistics.after, {});
}

void write_statistics_json(std::ostream& out, const VirtualStatistics& statistics)
{
  out << "{\"benches\": " << statistics.n_benches << ", \"refused\": " << statistics.n_refused
      << ", \"numbers\": [";
  for (std::size_t k = 0; k < statistics.numbers.size(); ++k) {
    const NumberStatistics& number = statistics.numbers[k];
    out << (k == 0 ? "" : ", ") << "{\"part\": " << show::quoted_text(number.part)
        << ", \"name\": " << show::quoted_text(number.name)
        << ", \"unit\": " << show::quoted_text(number.unit) << ", \"n\": " << number.n
        << ", \"within\": " << number.n_within << ", \"rms_error\": " << json_number(number.rms_error)
        << ", \"mean_half_width_95\": " << json_number(number.mean_half_width) << "}";
  }
  if (!statistics.joints.empty()) {
    const JointSummary s = summary_of(std::span<const JointError>(statistics.joints));
    out << "], \"joint\": {\"n\": " << statistics.joints.size() << ", \"by_landmarks_mm\": " << json_of(s.by_landmarks)
        << ", \"by_motion_mm\": " << json_of(s.functional) << ", \"halved\": " << s.n_halved << "}}";
    return;
  }
  out << "], \"targets\": ";
  write_targets_json(out, statistics.before, statistics.after, {});
  out << "}";
}

}  // namespace vrda::calibration
