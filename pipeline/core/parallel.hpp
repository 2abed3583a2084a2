/// Runs a function over indices in several threads.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace vrda::inline core {

/// `make()` returns the function of one thread. Each index in [0, n) is passed to one of them, once; the
/// function must write to the results of that index only. After an exception no further index
/// is begun; it is rethrown when all threads have ended.
template <typename Make>
void for_each_index(std::size_t n, int n_threads, const Make& make)
{
  std::atomic<std::size_t> next = 0;
  std::exception_ptr failure;
  std::mutex failure_mutex;
  const auto work = [&] {
    try {
      auto function = make();
      for (std::size_t k = next++; k < n; k = next++) function(k);
    } catch (...) {
      next = n;
      const std::lock_guard lock(failure_mutex);
      if (!failure) failure = std::current_exception();
    }
  };
  {
    std::vector<std::jthread> workers;
    for (int k = 1; k < std::min(n_threads, static_cast<int>(n)); ++k) workers.emplace_back(work);
    work();
  }
  if (failure) std::rethrow_exception(failure);
}

}  // namespace vrda::inline core
