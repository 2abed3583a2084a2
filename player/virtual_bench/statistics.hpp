/// How good a calibration is where the truth is known, and how honest its intervals are.
#pragma once

#include "virtual_bench/operator.hpp"

namespace vrda {

/// Found less true of every number of the part's estimate, in its units; of a place as Estimate says.
Eigen::VectorXd errors_of(const Estimate& estimate, CalibrationPart part, const BenchFile& bench,
                          const VirtualTruth& truth);

/// The overlay's error at one target for one eye: where its picture is seen against where it is.
struct TargetError {
  double mm = 0.0;  ///< across the sight, at the target's distance
  double arc_min = 0.0;
};
/// 20 points of a working volume of 160 x 240 x 120 mm about the knee, both eyes: 40 errors. The leg is where
/// the tracker, with its noise, says; `index` draws another noise.
std::vector<TargetError> target_errors(const Calibration& found, const BenchFile& bench,
                                       const VirtualTruth& truth, const VirtualNoise& noise,
                                       std::uint64_t index = 0);

/// As before calibration: nominal eyes, and where they are by a tape (10 mm, whole degrees); table, stage,
/// leg and size as they truly are, or the numbers would be metres and say nothing of the display.
Calibration uncalibrated(const BenchFile& bench, const VirtualTruth& truth);

struct NumberStatistics {
  std::string part, name, unit;
  int n = 0, n_within = 0;       ///< of the 95 % intervals
  double rms_error = 0.0;        ///< of found less true
  double mean_half_width = 0.0;  ///< of the intervals
};

struct VirtualStatistics {
  int n_benches = 0, n_refused = 0;  ///< refused: some marks were asked for again
  std::vector<NumberStatistics> numbers;
  std::vector<TargetError> before,
      after;  ///< every target error, by uncalibrated() and by the one found
};

/// Runs the whole procedure of `bench` on benches first_seed, first_seed + 1, ...; one thread each core, the
/// same for any number of threads.
VirtualStatistics virtual_statistics(const BenchFile& bench, const VirtualNoise& noise,
                                     std::uint64_t first_seed, int n_benches, int n_threads);

}  // namespace vrda
