/// Reports of a calibration as text and JSON.
#pragma once

#include <iosfwd>
#include <span>
#include <string>
#include <vector>

#include "bench_files/calibration.hpp"
#include "virtual_bench/statistics.hpp"

namespace vrda::calibrate {

/// "880.2 +- 1.4 px", with two significant digits of the interval.
std::string interval_text(double value, double half_width, const std::string& unit);

/// Writes the state and the results of `parts`, in order.
void write_status(std::ostream& out, const bench_files::Calibration& calibration,
                  std::span<const bench_files::CalibrationPart> parts);
/// The same as a JSON object without a final line feed.
void write_status_json(std::ostream& out, const bench_files::BenchFile& bench,
                       const bench_files::Calibration& calibration,
                       std::span<const bench_files::CalibrationPart> parts);

/// Parts that are not done or outdated.
std::vector<bench_files::CalibrationPart> missing_parts(const bench_files::Calibration& calibration,
                                                        std::span<const bench_files::CalibrationPart> parts);

/// Distribution of target errors.
struct TargetSummary {
  double median_mm = 0.0, p90_mm = 0.0, largest_mm = 0.0;  ///< most_of_ten: 90 % quantile
  double median_arc_min = 0.0, p90_arc_min = 0.0, largest_arc_min = 0.0;
};
TargetSummary summary_of(std::span<const virtual_bench::TargetError> errors);
/// `missing`: parts that are not done; if not empty, `after` is not written (JSON: null).
void write_targets(std::ostream& out, std::span<const virtual_bench::TargetError> before,
                   std::span<const virtual_bench::TargetError> after,
                   std::span<const bench_files::CalibrationPart> missing);
void write_targets_json(std::ostream& out, std::span<const virtual_bench::TargetError> before,
                        std::span<const virtual_bench::TargetError> after,
                        std::span<const bench_files::CalibrationPart> missing);

void write_statistics(std::ostream& out, const virtual_bench::VirtualStatistics& statistics);
void write_statistics_json(std::ostream& out, const virtual_bench::VirtualStatistics& statistics);

}  // namespace vrda::calibrate
