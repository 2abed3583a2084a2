#include "bench/clock_map.hpp"

#include "core/units.hpp"

#include <algorithm>

namespace vrda {
namespace {

constexpr std::int64_t clock_step_ns = 1'000'000'000;
constexpr std::int64_t drift_divisor = 10'000;  // 0.1 ms a second

}  // namespace

double ClockMap::time_s(std::int64_t device_ns, std::int64_t arrival_ns)
{
  if (device_ns == 0) {
    time_s_ = std::max(time_s_, static_cast<double>(arrival_ns) * s_per_ns);
    return time_s_;
  }
  const std::int64_t offset_ns = arrival_ns - device_ns;
  const bool is_back = has_offset_ && device_ns < device_ns_;
  const bool is_far_ahead = has_offset_ && offset_ns < offset_ns_ - clock_step_ns;
  if (!has_offset_ || is_back || is_far_ahead) {
    offset_ns_ = offset_ns;
    has_offset_ = true;
  } else {
    const std::int64_t forgotten_ns = (arrival_ns - arrival_ns_) / drift_divisor;
    offset_ns_ = std::min(offset_ns_ + forgotten_ns, offset_ns);
  }
  device_ns_ = device_ns;
  arrival_ns_ = arrival_ns;
  const std::int64_t ours_ns = std::min(device_ns + offset_ns_, arrival_ns);
  time_s_ = std::max(time_s_, static_cast<double>(ours_ns) * s_per_ns);
  return time_s_;
}

}  // namespace vrda
