/// Motion models and traces from files that nobody vouches for.
///
/// HDF5 1.10 crashes on some files made to make it crash: their seal is right and each value looks possible.
/// So HDF5 meets the bytes in a process of its own (store/separate_process.hpp), confined once they are read
/// (store/confinement.hpp), which hands over plain values; these are checked once more here. A crash there is
/// one InputError here.
#pragma once

#include <functional>
#include <string>

#include "store/motion_model.hpp"
#include "store/separate_process.hpp"

namespace vrda {

/// A motion model being read apart, while this process goes on: read_motion_model in two steps. Another
/// thread must not be using HDF5 at the first one.
class ModelReading {
 public:
  explicit ModelReading(const std::string& path);
  ModelReading(const std::string& path, const ProcessLimits& limits);
  /// Waits for it. Once only.
  MotionModel model();

 private:
  std::string path_;
  SeparateWork work_;
};

/// What reading the file at `path` may take: half a gigabyte, or eight times the file's size where that is
/// more.
ProcessLimits reading_limits(const std::string& path);

/// `tell` is called once, with the reason, if the kernel does not confine a reading process; its limits hold
/// nevertheless. Nothing is told until then.
void on_unconfined_reading(std::function<void(const std::string&)> tell);

}  // namespace vrda
