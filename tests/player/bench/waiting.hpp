/// Waiting for devices in tests.
#pragma once

#include <thread>

#include "bench/devices.hpp"

namespace vrda::test {

/// Only to stop hanging tests: no test depends on speed.
constexpr std::chrono::seconds hang_guard{60};

/// Polls until the condition holds; false after the guard time.
template <class Condition>
bool wait_until(Condition condition)
{
  const auto end = std::chrono::steady_clock::now() + hang_guard;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return true;
}

/// Takes samples into `seen` until one matches; false after the guard time.
template <class Fits>
bool take_until(bench::Devices& devices, std::vector<bench::Sample>& seen, Fits fits)
{
  return wait_until([&] {
    for (bench::Sample sample; devices.take(sample);) {
      seen.push_back(sample);
      if (fits(sample)) return true;
    }
    return false;
  });
}

inline bool is_link(const bench::Sample& sample, bench::DeviceId device, bench::LinkState state)
{
  return sample.kind == bench::SampleKind::link && sample.source == static_cast<std::uint16_t>(device) &&
         sample.state == static_cast<std::uint8_t>(state);
}

}  // namespace vrda::test
