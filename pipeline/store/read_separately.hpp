/// Motion models and traces from untrusted files.
///
/// HDF5 1.10 crashes on some crafted files with a valid seal and plausible values. So HDF5 parses the bytes
/// in a separate process (store/separate_process.hpp), confined after reading them (store/confinement.hpp).
/// It returns serialized values, which are checked again here. A crash of that process is an InputError.
#pragma once

#include <functional>
#include <string>

#include "store/motion_model.hpp"
#include "store/separate_process.hpp"

namespace vrda::store {

/// Asynchronous read_motion_model: the constructor starts the separate process, model() waits for its result.
/// No other thread may use HDF5 during construction.
class SeparateModelRead {
 public:
  explicit SeparateModelRead(const std::string& path);
  SeparateModelRead(const std::string& path, const ProcessLimits& limits);
  /// Waits for the process and returns its model. May be called once.
  MotionModel model();

 private:
  std::string path_;
  SeparateProcess work_;
};

/// Limits for reading the file at `path`: memory of 512 MB or eight times the file's size if that is more.
ProcessLimits reading_limits(const std::string& path);

/// `report` is called once, with the reason, if the kernel rejects the confinement of a reading process; its
/// limits still apply. Without a callback nothing is reported.
void on_unconfined_read(std::function<void(const std::string&)> report);

}  // namespace vrda::store
