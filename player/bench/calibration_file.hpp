/// Estimated parameters with their uncertainty.
#pragma once

#include <Eigen/Core>

#include <functional>
#include <map>

#include "bench/bench_file.hpp"
#include "bench/rigid_body.hpp"
#include "core/document.hpp"

namespace vrda::bench {

/// In the units of files and screen: mm, deg, px. A pose has six numbers "table.shift_x" to "table.turn_z"
/// with the conventions of bench/rigid_body.hpp; its covariance is that of the translation and of a small
/// rotation vector about the fixed axes: true = rotation(error) * estimated, which has no singularity.
struct Estimate {
  std::vector<std::string> names;  ///< [n] "left.k1"
  std::vector<std::string> units;  ///< [n] "px"; empty: dimensionless
  Eigen::VectorXd values;          ///< [n]
  Eigen::MatrixXd covariance;      ///< [n, n]
  double dof = 0.0;  ///< degrees of freedom of the estimated noise; infinite: the noise was given
  std::vector<double> residuals;  ///< in the order of the marks
  std::string residual_unit;
  double residual_rms = 0.0;
  std::vector<std::string> remarks;  ///< one line each for the operator
};

/// "12.3 mm"; "12.3" without a unit.
std::string text(double value, int decimals, const std::string& unit);

/// Rounded as in text().
double rounded(double value, int decimals);

/// Throws FitError for an estimate `name`, which may be empty, of a calibration file.
struct FitErrorContext {
  std::string name, file;

  /// `field`: what follows the name.
  [[noreturn]] void fail(const std::string& field, const std::string& found, const std::string& wanted,
                         std::vector<std::size_t> marks = {}) const
  {
    throw FitError({file, name + field, found, wanted}, std::move(marks));
  }
};

/// "name.shift_x" to "name.turn_z"
std::vector<std::string> pose_number_names(const std::string& name);
/// Estimate of a pose, from the covariance of (shift_mm, turn_rad).
Estimate pose_estimate(const std::string& name, const Pose& X,
                       const Eigen::Matrix<double, 6, 6>& covariance_mm_rad);

/// Two-sided 95 % quantile of Student's t; 1.96 for infinite degrees of freedom.
double t_95(double dof);
/// Half the width of the 95 % interval of number `k`.
double half_width_95(const Estimate& estimate, Eigen::Index k);

/// Decimals for two significant digits of `size`.
int decimals_for(double size);
/// "880.2 +- 1.4 px": number `k` with its interval, of which two digits are left.
std::string interval_text(const Estimate& estimate, Eigen::Index k);

/// Appends `part` to `whole` as an independent estimate (block-diagonal covariance, same residual unit). The
/// smaller number of degrees of freedom is kept.
void append(Estimate& whole, const Estimate& part);

/// Stores `residuals` and their root mean square.
void set_residuals(Estimate& estimate, const std::vector<double>& residuals, const std::string& unit);

/// Index of the number `name`, or -1.
Eigen::Index index_of(const Estimate& estimate, const std::string& name);

// The stored data of each part of a calibration: marks as measured, estimate with covariance, date. Units
// are those of schemas/calibration.md: px, mm, degrees.

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
/// Key of the part in files and its name on screen: "viewport".
const char* name_of(CalibrationPart part);
/// Whether it is done once per bench; else once per person.
bool is_per_bench(CalibrationPart part);
/// Key of its record in the calibration file: "per_bench.viewport".
std::string record_key(CalibrationPart part);

/// Names of the estimated numbers that other parts use; may be empty.
std::vector<std::string> shared_estimate_names(CalibrationPart part);

/// Measurement of one finished task; the task kind (calibration/task.hpp) defines the rows.
struct CalibrationMark {
  std::string task;  ///< task name, unique within its part
  std::vector<std::vector<double>> rows;
};

struct CalibrationRecord {
  std::string date;  ///< "2026-11-22", of the last mark
  /// In the order of the part's tasks; the first task without a mark is the next one.
  std::vector<CalibrationMark> marks;
  /// Values of the bench file to which the marks belong (calibration/parts.hpp); may be empty.
  std::vector<double> made_with;
  std::optional<Estimate> estimate;  ///< once solved
  /// The part must be repeated: by --anew, or because a part that it depends on was repeated.
  bool is_outdated = false;
};

// Calibrated values of display, person, tracker and leg.

struct Calibration {
  view::EyePair eyes;
  double image_distance_mm = 800.0;  ///< distance of the virtual images of the screens
  PoseParameters X_tracker_table;
  PoseParameters X_table_eyes;  ///< with the stage at zero; eyes: the midpoint between the eyes
  Eigen::Vector3d stage_direction_table = Eigen::Vector3d::UnitX();  ///< unit; eye motion per mm of stage
  PoseParameters X_headbody_eyes;                                    ///< head tracked by a body
  /// Per role except head: stored vertices (tibia: of the moving object, else of the reference) -> body.
  ByRole<PoseParameters> X_body_model;
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

// Parameters that can be adjusted while the bench runs (thesis 7.2), with unit, range and step.

/// All values that parameters change.
struct BenchValues {
  Calibration calibration;
  double flexion_rad = 0.0, varus_rad = 0.0;  ///< only for a rigid leg
  double prediction_ms = 0.0;
};

struct Parameter {
  std::string name;  ///< "flexion", "left.k1", "tibia.shift_x"
  std::string unit;  ///< empty: dimensionless
  double minimum = 0.0, maximum = 0.0, step = 0.0;
  /// The stored value; empty for the distance between the eyes.
  std::function<double&(BenchValues&)> at = nullptr;
  double scale = 1.0;  ///< units of the stored value in one unit of the parameter
};

/// All parameters, in the order in which keys select them. Constant.
std::span<const Parameter> parameters();
/// Its index; empty without that name.
std::optional<std::size_t> find_parameter(const std::string& name);

/// Whether the parameter has an effect on the bench, e.g. `flexion` only with a rigid leg.
bool is_used(std::size_t parameter, const BenchFile& bench);

/// Value in the unit of the parameter.
double value_of(const BenchValues& values, std::size_t parameter);
/// Sets a parameter; the value is clamped to its range.
void set_value(BenchValues& values, std::size_t parameter, double value);

using CalibrationRecords = std::map<CalibrationPart, CalibrationRecord>;

/// TOML tables for the end of the file; reading them gives equal records.
std::string records_text(const CalibrationRecords& records);

}  // namespace vrda::bench
