/// What a calibration knows, and how well, as text and as JSON.
#pragma once

#include <iosfwd>
#include <span>
#include <string>
#include <vector>

#include "setup/calibration.hpp"
#include "virtual_bench/statistics.hpp"

namespace vrda {

/// "880.2 +- 1.4 px": as many digits as the interval leaves.
std::string interval_text(double value, double half_width, const std::string& unit);

/// `parts`: those to be told of, in order.
void write_status(std::ostream& out, const Calibration& calibration, std::span<const CalibrationPart> parts);
/// An object in braces, without an end of line.
void write_status_json(std::ostream& out, const BenchFile& bench, const Calibration& calibration,
                       std::span<const CalibrationPart> parts);

/// Which of `parts` are still to be done, or to be done again.
std::vector<CalibrationPart> missing_parts(const Calibration& calibration,
                                           std::span<const CalibrationPart> parts);

/// Distribution of target errors.
struct TargetSummary {
  double median_mm = 0.0, most_of_ten_mm = 0.0, largest_mm = 0.0;  ///< most_of_ten: 9 of 10 are less
  double median_arc_min = 0.0, most_of_ten_arc_min = 0.0, largest_arc_min = 0.0;
};
TargetSummary summary_of(std::span<const TargetError> errors);
/// `missing`: parts of the bench that are to be done. With any, `after` says nothing, and is left out (null).
void write_targets(std::ostream& out, std::span<const TargetError> before, std::span<const TargetError> after,
                   std::span<const CalibrationPart> missing);
void write_targets_json(std::ostream& out, std::span<const TargetError> before,
                        std::span<const TargetError> after, std::span<const CalibrationPart> missing);

void write_statistics(std::ostream& out, const VirtualStatistics& statistics);
void write_statistics_json(std::ostream& out, const VirtualStatistics& statistics);

}  // namespace vrda
