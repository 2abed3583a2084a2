/// Calibrated values of display, person, tracker and leg.
#pragma once

#include <map>
#include <string>

#include "bench/bench_file.hpp"
#include "bench/calibration_record.hpp"
#include "view/eye.hpp"
#include "bench/screw.hpp"

namespace vrda::bench {

struct Calibration {
  view::EyePair eyes;
  double image_distance_mm = 800.0;  ///< distance of the virtual images of the screens
  bench::PoseParameters X_tracker_table;
  bench::PoseParameters X_table_eyes;  ///< with the stage at zero; eyes: the midpoint between the eyes
  Eigen::Vector3d stage_direction_table = Eigen::Vector3d::UnitX();  ///< unit; eye motion per mm of stage
  bench::PoseParameters X_headbody_eyes;                          ///< head tracked by a body
  /// Per role except head: stored vertices (tibia: of the moving object, else of the reference) -> body.
  std::array<bench::PoseParameters, n_body_roles> X_body_model;
  double subject_scale = 1.0;                            ///< scales the model's lengths, motion included
  std::map<CalibrationPart, CalibrationRecord> records;  ///< of parts started or finished
};

/// Values for an uncalibrated bench: windows fully visible, optical axes at their centres, eye distance 880
/// px, eyes 64 mm apart and 800 mm in front of the table origin.
Calibration nominal_calibration(const BenchFile& bench);

/// Reads a calibration file (schemas/calibration.md). Throws InputError with file and key, also when the file
/// belongs to another bench or display.
Calibration read_calibration(const std::string& path, const BenchFile& bench);
Calibration parse_calibration(const std::string& text, const std::string& path, const BenchFile& bench);

/// Text of a calibration file; reading it gives equal numbers.
std::string calibration_text(const Calibration& calibration, const BenchFile& bench);

/// A calibration file that other programs may write too.
class CalibrationFile {
 public:
  /// `text`: what was read from the file; empty without a file. `bench` must outlive this object.
  CalibrationFile(const BenchFile& bench, std::string path, std::string text);
  /// Throws InputError on a write error, and if the file no longer has the text that was read or last
  /// written.
  void write(const Calibration& calibration);

 private:
  const BenchFile& bench_;
  std::string path_, text_;
};

}  // namespace vrda::bench
