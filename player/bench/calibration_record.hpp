/// The stored data of each part of a calibration: marks as measured, estimate with covariance, date. Units
/// are those of schemas/calibration.md: px, mm, degrees.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bench/estimate.hpp"

namespace vrda::bench {

/// A part of the procedure with a fit of its own, in the order of execution.
enum class CalibrationPart {
  viewport,
  distortion,
  rails,
  stop,
  probe,  // the last part per bench
  eyepoints,
  ipd,
  subject,
  bullseye,
  head,
  leg,
  femur,
  tibia,
  functional  // the last part per person; optional
};
inline constexpr std::size_t n_calibration_parts = 14;
const char* name_of(CalibrationPart part);
bool is_per_bench(CalibrationPart part);
/// Key of its record in the calibration file: "per_bench.viewport".
std::string record_key(CalibrationPart part);

/// Names of the estimated numbers that other parts use; may be empty.
std::vector<std::string> shared_estimate_names(CalibrationPart part);

/// Measurement of one finished task; the task kind (calibration_tasks/task.hpp) defines the rows.
struct CalibrationMark {
  std::string task;  ///< task name, unique within its part
  std::vector<std::vector<double>> rows;
};

struct CalibrationRecord {
  std::string date;  ///< "2026-11-22", of the last mark
  /// In the order of the part's tasks; the first task without a mark is the next one.
  std::vector<CalibrationMark> marks;
  /// Values of the bench file to which the marks belong (calibration_tasks/parts.hpp); may be empty.
  std::vector<double> made_with;
  std::optional<Estimate> estimate;  ///< once solved
  /// The part must be repeated: by --anew, or because a part that it depends on was repeated.
  bool is_outdated = false;
};

}  // namespace vrda::bench
