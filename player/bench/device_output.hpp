/// Output of one device: its samples into the queue, its status report.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <mutex>
#include <string>
#include <vector>

#include "bench/devices.hpp"
#include "bench/sample.hpp"

namespace vrda::bench {

/// ns since construction.
class ArrivalClock {
 public:
  using Time = std::chrono::steady_clock::time_point;
  std::int64_t now_ns() const
  {
    return (std::chrono::steady_clock::now() - begin_) / std::chrono::nanoseconds(1);
  }
  Time time_of(std::int64_t ns) const { return begin_ + std::chrono::nanoseconds(ns); }

 private:
  Time begin_ = std::chrono::steady_clock::now();
};

/// Rate over the last 2 s, in bins of a quarter of a second.
class RateMeter {
 public:
  void count(std::int64_t now_ns);
  double rate_hz(std::int64_t now_ns) const;

 private:
  static constexpr std::int64_t bucket_ns = 250'000'000;
  static constexpr std::size_t n_buckets = 8;
  struct Bucket {
    std::int64_t number = -1;  ///< counted from the clock's start
    std::uint32_t n = 0;
  };
  std::array<Bucket, n_buckets> buckets_{};
  std::int64_t first_ns_ = -1;
};

class DeviceOutput {
 public:
  DeviceOutput(DeviceId device, std::string peer, SampleQueue& queue, const ArrivalClock& clock);

  /// Puts the samples of one message; the loop receives all of them together.
  void put(const std::vector<Sample>& samples);
  /// Also puts a link sample if the state changed. `error_message` is kept until replaced or the link is up.
  void set_link(LinkState link, const std::string& error_message);
  /// Counts rejected input. An empty `error_message` leaves the last one unchanged.
  void count_rejected(std::uint64_t n, const std::string& error_message);
  void set_notes(std::vector<std::string> notes);
  /// Sets `error_message` without counting anything.
  void set_error_message(const std::string& error_message);

  /// Callable from any thread; the others only from the devices' thread.
  DeviceReport report() const;
  const ArrivalClock& clock() const { return clock_; }

 private:
  void put_one(const Sample& sample);

  const DeviceId device_;
  SampleQueue& queue_;
  const ArrivalClock& clock_;
  mutable std::mutex mutex_;
  DeviceReport report_;
  RateMeter rate_;
};

}  // namespace vrda::bench
