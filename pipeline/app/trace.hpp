/// Every motion of every search in one CSV file, step by step (`vrda run --trace`).
#pragma once

#include <fstream>
#include <functional>
#include <mutex>
#include <string>

#include "solve/stability_search.hpp"

namespace vrda {

class Trace {
 public:
  /// Throws InputError when the file cannot be written.
  explicit Trace(const std::string& path);

  /// Throws InputError when something could not be written.
  void close();

  /// Runs `solve` with a watch and appends its motions once it ends. From any thread; steps stay whole.
  StepRecord follow(const Attitude& attitude, const std::function<StepRecord(const Watch&)>& solve);

 private:
  std::string path_;
  std::ofstream file_;
  std::mutex mutex_;
};

}  // namespace vrda
