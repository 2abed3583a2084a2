/// Accuracy of calibrations against ground truth, and coverage of their confidence intervals.
#pragma once

#include "calibration/virtual_bench.hpp"
#include "core/fields.hpp"

namespace vrda::calibration {

/// Found minus true value of every parameter of the estimate, in its units; poses as in Estimate.
Eigen::VectorXd errors_of(const Estimate& estimate, const VirtualTruth& truth);

/// Overlay error at one target for one eye: where its image is seen against its true direction.
struct TargetError {
  double mm = 0.0;  ///< perpendicular to the line of sight, at the target's distance
  double arc_min = 0.0;
};
/// 20 points of a working volume of 160 x 240 x 120 mm about the knee, both eyes: 40 errors. The leg's pose
/// has tracker noise; `index` selects the noise.
std::vector<TargetError> target_errors(const Calibration& found, const BenchFile& bench,
                                       const VirtualTruth& truth, const VirtualNoise& noise,
                                       std::uint64_t index = 0);

/// State before calibration: nominal eyes at tape-measured positions (10 mm, whole degrees). Table, stage,
/// leg and size are exact; otherwise errors would be metres and unrelated to the display.
Calibration uncalibrated(const BenchFile& bench, const VirtualTruth& truth);

struct NumberStatistics {
  std::string part, name, unit;
  int n = 0, n_within = 0;       ///< of the 95 % intervals containing the truth
  double rms_error = 0.0;        ///< of found minus true values
  double mean_half_width = 0.0;  ///< of the intervals
};
constexpr auto fields_of(const NumberStatistics*)
{
  return std::tuple{Field{"part", &NumberStatistics::part},
                    Field{"name", &NumberStatistics::name},
                    Field{"unit", &NumberStatistics::unit},
                    Field{"n", &NumberStatistics::n},
                    Field{"within", &NumberStatistics::n_within},
                    Field{"rms_error", &NumberStatistics::rms_error},
                    Field{"mean_half_width_95", &NumberStatistics::mean_half_width}};
}

/// Overlay error of both bones at the joint (joint_error_mm, root mean square).
struct JointError {
  double by_landmarks_mm = 0.0, functional_mm = 0.0;
};
/// Requires the truth's joint and a calibration with the part functional.
JointError joint_error(const Calibration& found, const VirtualTruth& truth);

struct VirtualStatistics {
  int n_benches = 0, n_refused = 0;  ///< n_refused: benches where some marks had to be repeated
  std::vector<NumberStatistics> numbers;
  std::vector<TargetError> before,
      after;  ///< all target errors, by uncalibrated() and by the found calibration; empty for a joint
  std::vector<JointError> joints;  ///< of each bench; empty without a joint
};

struct VirtualRun {
  std::uint64_t first_seed = 1;
  int n_benches = 0, n_threads = 1;
  VirtualNoise noise = {};
  /// Motion of the model, unscaled: only the part functional and its dependencies are done.
  std::optional<JointCurve> joint = std::nullopt;
};

/// Runs the whole procedure of `bench` on the benches first_seed, first_seed + 1, ...; the result is the
/// same for any number of threads.
VirtualStatistics virtual_statistics(const BenchFile& bench, const VirtualRun& run);

}  // namespace vrda::calibration
