/// One device's way to the loop: its samples into the queue, its report to whoever asks.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <mutex>
#include <string>
#include <vector>

#include "devices/devices.hpp"
#include "devices/sample.hpp"

namespace vrda {

/// ns since it was made.
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

/// Readings of the last 2 s, counted by quarters of a second.
class RateMeter {
 public:
  void count(std::int64_t now_ns);
  double rate_hz(std::int64_t now_ns) const;

 private:
  static constexpr std::int64_t bucket_ns = 250'000'000;
  static constexpr std::size_t n_buckets = 8;
  struct Bucket {
    std::int64_t number = -1;  ///< counted from the clock's begin
    std::uint32_t n = 0;
  };
  std::array<Bucket, n_buckets> buckets_{};
  std::int64_t first_ns_ = -1;
};

class Outlet {
 public:
  Outlet(DeviceId device, std::string peer, SampleQueue& queue, const ArrivalClock& clock);

  /// Of one message: the loop takes all of them at once.
  void put(const std::vector<Sample>& samples);
  /// A sample of it too where it is news. `trouble` stands until the next one; a link that is up has none.
  void set_link(LinkState link, const std::string& trouble);
  /// `trouble` may be empty: what is refused is no harm.
  void refuse(std::uint64_t n, const std::string& trouble);
  /// Something to say that costs nothing.
  void note(const std::string& trouble);

  /// From any thread; the others from the devices' thread alone.
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

}  // namespace vrda
