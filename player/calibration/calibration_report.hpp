/// Reports of a calibration as text and JSON.
#pragma once

#include <iosfwd>
#include <span>
#include <string>
#include <vector>

#include "calibration/calibrate.hpp"

namespace vrda::calibration {

/// Writes the state and the results of `parts`, in order.
void write_status(std::ostream& out, const Calibration& calibration, std::span<const CalibrationPart> parts);
/// The same as a JSON object without a final line feed.
void write_status_json(std::ostream& out, const BenchFile& bench, const Calibration& calibration,
                       std::span<const CalibrationPart> parts);

/// Parts that are not done or outdated.
std::vector<CalibrationPart> missing_parts(const Calibration& calibration,
                                           std::span<const CalibrationPart> parts);

/// Distribution of target errors, by nearest rank.
struct Quantiles {
  double median = 0.0, p90 = 0.0, largest = 0.0;
};
struct TargetSummary {
  Quantiles mm, arc_min;
};
TargetSummary summary_of(std::span<const TargetError> errors);
/// `missing`: parts that are not done; if not empty, `after` is not written (JSON: null).
void write_targets(std::ostream& out, std::span<const TargetError> before, std::span<const TargetError> after,
                   std::span<const CalibrationPart> missing);
void write_targets_json(std::ostream& out, std::span<const TargetError> before,
                        std::span<const TargetError> after, std::span<const CalibrationPart> missing);

/// Error of the placements at the joint.
void write_joint(std::ostream& out, const JointError& error);
void write_statistics(std::ostream& out, const VirtualStatistics& statistics);
void write_statistics_json(std::ostream& out, const VirtualStatistics& statistics);

}  // namespace vrda::calibration
