/// What calibration found: of the display, of the person, of the tracker and the leg.
#pragma once

#include <map>
#include <string>

#include "optics/eye.hpp"
#include "setup/bench_file.hpp"
#include "setup/calibration_record.hpp"
#include "tracking/screw.hpp"

namespace vrda {

struct Calibration {
  EyePair eyes;
  double image_distance_mm = 800.0;  ///< of the screens' virtual images
  SixNumbers X_tracker_table;
  SixNumbers X_table_eyes;  ///< with the stage at zero; E: the middle between the eyes
  Eigen::Vector3d stage_direction_table = Eigen::Vector3d::UnitX();  ///< unit; the head's way per mm of stage
  SixNumbers X_headbody_eyes;                                        ///< with a body on the display
  /// Of each role but the head: what takes stored vertices (of the moving object for the tibia, else of the
  /// reference) to the body.
  std::array<SixNumbers, n_body_roles> X_body_model;
  double subject_scale = 1.0;  ///< of the model's lengths, motion included
  std::map<CalibrationPart, CalibrationRecord>
      records;  ///< of parts begun or done; kept as they are by whoever writes values
};

/// Of a bench that was never calibrated: windows wholly visible, sight in their middles, 880 px of distance,
/// 64 mm between the eyes, 800 mm in front of the table's origin.
Calibration nominal_calibration(const BenchFile& bench);

/// Reads a TOML file as schemas/calibration.md describes it. Throws InputError naming file and key, and when
/// it was made for another display.
Calibration read_calibration(const std::string& path, const BenchFile& bench);
Calibration parsed_calibration(const std::string& text, const std::string& path, const BenchFile& bench);

/// The file's text: reading it gives equal numbers.
std::string calibration_text(const Calibration& calibration, const BenchFile& bench);

}  // namespace vrda
