/// A device's clock brought to ours.
#pragma once

#include <cstdint>

namespace vrda {

/// What a device stamped arrives later by the way's delay, which varies; the smallest seen is taken for the
/// way itself. Clocks drift: it is forgotten by 0.1 ms a second.
class ClockMap {
 public:
  /// When the device took the sample, s of our clock; never later than its arrival, never earlier than the
  /// answer before. A device clock that steps (back at all, or ahead by more than a second) is met anew. Of
  /// 0, no clock: the arrival.
  double time_s(std::int64_t device_ns, std::int64_t arrival_ns);

 private:
  bool has_offset_ = false;
  std::int64_t offset_ns_ = 0;  ///< ours less the device's
  std::int64_t device_ns_ = 0, arrival_ns_ = 0;
  double time_s_ = 0.0;
};

}  // namespace vrda
