/// Processor time, s, independent of other load on the machine, and wall-clock time.
#pragma once

#include <time.h>

#include <chrono>

namespace vrda::benchmarks {

inline double seconds_of(clockid_t clock)
{
  timespec now{};
  clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

inline double thread_s()
{
  return seconds_of(CLOCK_THREAD_CPUTIME_ID);
}

/// Of all threads together.
inline double process_s()
{
  return seconds_of(CLOCK_PROCESS_CPUTIME_ID);
}

inline double seconds_since(std::chrono::steady_clock::time_point start)
{
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace vrda::benchmarks
