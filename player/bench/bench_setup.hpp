/// What `bench` starts from, read and checked.
#pragma once

#include "bench/bench_run.hpp"
#include "motion/poses.hpp"
#include "recording/recording.hpp"
#include "setup/calibration.hpp"
#include "store/motion_model.hpp"

namespace vrda {

struct BenchSetup {
  MotionModel model;
  Motion motion;
  SolverFrame frame;  ///< of the model's first flexion
  BenchFile bench;
  Calibration calibration;
  RecordingFacts facts;  ///< to record with
};

/// From the files that the options name. Throws InputError.
BenchSetup read_bench_setup(const BenchOptions& options);

/// As `recording` was made, but for the motion model, which is read again and has to be the same file.
BenchSetup setup_of(const Recording& recording, const BenchOptions& options);

}  // namespace vrda
