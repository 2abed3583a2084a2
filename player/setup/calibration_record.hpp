/// What calibration did, kept beside what it found: every part's marks, estimate and date.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "calibration/estimate.hpp"

namespace vrda {

/// A piece of the procedure that is solved by itself. The order is that of doing them.
enum class CalibrationPart {
  viewport,
  distortion,
  rails,
  stop,
  probe,  // once a bench
  eyepoints,
  ipd,
  subject,
  bullseye,
  head,
  leg,
  femur,
  tibia  // once a person
};
inline constexpr std::size_t n_calibration_parts = 13;
const char* name_of(CalibrationPart part);
std::optional<CalibrationPart> calibration_part_named(const std::string& name);
bool is_once_a_bench(CalibrationPart part);

/// Names of the numbers that other parts read from what this one found; often none.
std::vector<std::string> numbers_read_of(CalibrationPart part);

/// One finished task: rows of numbers as the task's kind says (guide/task.hpp).
struct CalibrationMark {
  std::string task;  ///< its name, which is unique in its part
  std::vector<std::vector<double>> rows;
};

struct CalibrationRecord {
  std::string date;  ///< "2026-11-22", of the last mark
  /// In the order of the part's tasks; the first task without one is asked for next.
  std::vector<CalibrationMark> marks;
  /// Numbers of the bench file that the marks belong to (guide/parts.hpp); empty: there are none, or the file
  /// does not tell.
  std::vector<double> made_with;
  std::optional<Estimate> estimate;  ///< once it is solved
  /// To be done again: it was asked for anew, or a part that it rests on was done again since.
  bool is_outdated = false;
};

}  // namespace vrda
