/// Command `vrda-player calibrate`: calibrates a bench and a person in steps, with real devices or with
/// simulated ones of which the truth is known. In: bench file, calibration file, for adjustment by eye a
/// motion model. Out: the calibration file (schemas/calibration.md; lengths in mm, angles in degrees),
/// pictures, statistics. Throws InputError for a file or value that cannot be used.
#pragma once

#include <cstdint>
#include <string>

#include "show/loop.hpp"
#include "calibration/statistics.hpp"

namespace vrda::calibration {

using bench::BenchFile;
using bench::BodyRole;
using bench::Calibration;
using bench::CalibrationMark;
using bench::CalibrationPart;
using bench::CalibrationPoint;
using bench::CalibrationRecord;
using bench::CalibrationSettings;
using bench::HeadKind;
using bench::LegKind;
using calibration::CalibrationProgress;
using calibration::CalibrationSession;
using calibration::Dial;
using calibration::DrawnLine;
using calibration::Task;
using calibration::TaskKind;
using calibration::JointError;
using calibration::NumberStatistics;
using calibration::TargetError;
using calibration::VirtualNoise;
using calibration::VirtualOperator;
using calibration::VirtualStatistics;
using calibration::VirtualTruth;

struct CalibrateOptions {
  std::string step;         ///< viewport, ..., all, bench, person; status; solve
  std::string bench;        ///< empty with is_virtual: built-in bench file
  std::string calibration;  ///< empty with is_virtual: not saved
  std::string bench_from;   ///< calibration file of another person; may be empty
  bool is_repeated = false;
  std::string model, set;  ///< for adjustment by eye and for pictures
  bool is_headless = false;
  std::string script;  ///< file with keys
  int samples = 1;     ///< samples per pixel
  bool is_virtual = false;
  std::uint64_t seed = 1;
  std::string head = "stage";  ///< or "tracker", in the built-in bench file
  int n_benches = 0;           ///< number of benches for statistics; 0: one bench with a report
  std::string noise;           ///< of the virtual bench: "touch_mm=5,tracker_deg=0.3"
  std::string pictures;        ///< folder; empty: no pictures
  bool has_json = false;
  bool is_quiet = false;
};

enum class CalibrateEnd {
  finished,
  quit  ///< quit before all requested parts were done; finished tasks are saved
};

/// Default noise with the values of a list NAME=VALUE,...; throws InputError for an unknown name or value.
VirtualNoise noise_of(const std::string& list);

/// Runs the command. Throws InputError for invalid options and files before it starts.
CalibrateEnd calibrate(const CalibrateOptions& options, const show::Streams& streams);

}  // namespace vrda::calibration
