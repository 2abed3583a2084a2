/// A watch in a thread of its own: a window never waits for a disk.
#pragma once

#include <chrono>
#include <condition_variable>
#include <exception>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "follow/run_watch.hpp"

namespace vrda {

/// What came since it was last asked for.
struct WatchArrivals {
  bool is_anew = false;  ///< as in WatchNews
  /// The plan of the run that began anew, or the result of one that is finished; else nothing.
  std::shared_ptr<const MotionModel> model;
  std::vector<SeenStep> steps;
  std::vector<std::string> remarks;
  RunPhase phase = RunPhase::waiting;
  int n_done = 0, n_steps = 0;
  bool is_caught_up = false;  ///< with all that there was when it was last looked
};

class WatchThread {
 public:
  /// Looks until the run is finished, `pause` after each time that nothing is left to read.
  WatchThread(RunWatch watch, std::chrono::milliseconds pause);
  ~WatchThread();
  WatchThread(const WatchThread&) = delete;
  WatchThread& operator=(const WatchThread&) = delete;

  /// Never waits for a file. Rethrows, once, what ended the thread.
  WatchArrivals take();

 private:
  void run();
  bool look();

  RunWatch watch_;  // of the thread alone
  std::chrono::milliseconds pause_;
  std::mutex mutex_;  // guards what follows
  std::condition_variable wake_;
  WatchArrivals arrivals_;
  std::exception_ptr failure_;
  bool is_stopped_ = false;
  std::thread thread_;
};

}  // namespace vrda
