/// Reports of a calibration as text and JSON.
#pragma once

#include <iosfwd>
#include <span>
#include <string>
#include <vector>

#include "setup/calibration.hpp"
#include "virtual_bench/statistics.hpp"

namespace vrda {

/// "880.2 +- 1.4 px", with two significant digits of the interval.
std::string interval_text(double value, double half_width, const std::string& unit);

/// Writes the state and the results of `parts`, in order.
void write_status(std::ostream& out, const Calibration& calibration, std::span<const CalibrationPart> parts);
/// The same as a JSON object without a final line feed.
void write_status_json(std::ostream& out, const BenchFile& bench, const Calibration& calibration,
                       std::span<const CalibrationPart> parts);

/// Parts that are not done or outdated.
std::vector<CalibrationPart> missing_parts(const Calibration& calibration,
                                           std::span<const CalibrationPart> parts);

/// Distribution of target errors.
struct TargetSummary {
  double median_mm = 0.0, most_of_ten_mm = 0.0, largest_mm = 0.0;  ///< most_of_ten: 90 % quantile
  double median_arc_min = 0.0, most_of_ten_arc_min = 0.0, largest_arc_min = 0.0;
};
TargetSummary summary_of(std::span<const TargetError> errors);
/// `missing`: parts that are not done; if not empty, `after` is not written (JSON: null).
void write_targets(std::ostream& out, std::span<const TargetError> before, std::span<const TargetError> after,
                   std::span<const CalibrationPart> missing);
void write_targets_json(std::ostream& out, std::span<const TargetError> before,
                        std::span<const TargetError> after, std::span<const CalibrationPart> missing);

void write_statistics(std::ostream& out, const VirtualStatistics& statistics);
void write_statistics_json(std::ostream& out, const VirtualStatistics& statistics);

}  // namespace vrda
