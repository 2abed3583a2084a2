/// Runs a function over the frames of a sequence in several threads.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace vrda::repair {

/// `make()` returns the function of one thread; it is called with each frame once and must write to that
/// frame only. Rethrows the first exception.
template <typename Make>
void for_each_frame(std::size_t n_frames, int n_threads, const Make& make)
{
  std::atomic<std::size_t> next = 0;
  std::exception_ptr failure;
  std::mutex failure_mutex;
  const auto work = [&] {
    try {
      auto function = make();
      for (std::size_t k = next++; k < n_frames; k = next++) function(k);
    } catch (...) {
      const std::lock_guard lock(failure_mutex);
      if (!failure) failure = std::current_exception();
    }
  };
  std::vector<std::jthread> workers;
  for (int k = 1; k < std::min(n_threads, static_cast<int>(n_frames)); ++k) workers.emplace_back(work);
  work();
  workers.clear();
  if (failure) std::rethrow_exception(failure);
}

}  // namespace vrda::repair
