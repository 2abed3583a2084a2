/// Samples from the devices' thread to the loop, without locks.
#pragma once

#include <atomic>
#include <cstdint>
#include <vector>

#include "devices/sample.hpp"

namespace vrda {

/// One thread puts, one takes. A loop that does not take loses the newest readings, never the news of links
/// and of tools that are no longer seen: the last slots are kept for these.
class SampleQueue {
 public:
  /// 16 tools at 100 Hz fill it in 2.5 s; 320 KB.
  static constexpr std::size_t capacity = 4096;
  static constexpr std::size_t n_reserved = 64;

  SampleQueue() : slots_(capacity) {}

  /// Puts it in behind the others; it is taken from publish() on, so that what came in one message is taken
  /// at once or not at all. False where it is full.
  bool stage(const Sample& sample);
  void publish();
  /// Both for one sample.
  bool put(const Sample& sample);
  /// False where it is empty. Neither blocks nor allocates.
  bool take(Sample& sample);

 private:
  std::vector<Sample> slots_;
  std::uint64_t n_staged_ = 0;  ///< of the thread that puts
  std::atomic<std::uint64_t> n_put_{0}, n_taken_{0};
};

}  // namespace vrda
