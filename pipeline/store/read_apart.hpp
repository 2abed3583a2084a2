/// Motion models and traces from files that nobody vouches for.
///
/// HDF5 1.10 crashes on some files made to make it crash: their seal is right and each value looks possible.
/// So HDF5 meets the file in a process of its own (store/separate_process.hpp), which hands over plain
/// values; these are checked once more here. A crash there is one InputError here.
#pragma once

#include <string>

#include "store/motion_model.hpp"
#include "store/separate_process.hpp"
#include "store/trace.hpp"

namespace vrda {

/// A motion model being read apart, while this process goes on.
class ModelReading {
 public:
  explicit ModelReading(const std::string& path, const ProcessLimits& limits = {});
  /// Waits for it. Once only.
  MotionModel model();

 private:
  std::string path_;
  SeparateWork work_;
};

/// As read_motion_model and read_trace, with the same errors, within limits. Another thread must not be using
/// HDF5 meanwhile.
MotionModel read_motion_model_apart(const std::string& path, const ProcessLimits& limits = {});
Trace read_trace_apart(const std::string& path, const ProcessLimits& limits = {});

}  // namespace vrda
