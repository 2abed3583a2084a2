/// Output of one device: its samples into the queue, its status report.
#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "bench/devices.hpp"

namespace boost::asio {
class io_context;
}

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

// Connections to the board (serial) and to an OpenIGTLink server, with automatic reconnection. In: bytes.
// Out: samples with their time of arrival, ns of the local clock. A lost or wrong peer is a status of the
// link, not an exception.

/// Exponential back-off: doubles from `first_ms` to 20 times that (0.1 s to 2 s), then stays constant.
class Backoff {
 public:
  explicit Backoff(double first_ms) : first_ms_(first_ms), next_ms_(first_ms) {}

  double next_ms()
  {
    const double now_ms = next_ms_;
    next_ms_ = std::min(2.0 * now_ms, 20.0 * first_ms_);
    return now_ms;
  }

  /// Call when the peer has answered correctly.
  void reset() { next_ms_ = first_ms_; }

 private:
  double first_ms_, next_ms_;
};

/// Runs in the thread of `io`. The link is up once the version was received. A port error, a wrong version
/// or a silent board closes the port; it is reopened with back-off.
class BoardClient {
 public:
  BoardClient(boost::asio::io_context& io, const BoardSettings& settings, DeviceOutput& outlet);
  ~BoardClient();

  /// From any thread.
  void zero_stage();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Runs in the thread of `io`. A corrupt stream, an error or a dead peer (TCP keep-alive, 5 s) closes the
/// connection; it reconnects with back-off, which the first complete message resets.
class TrackerClient {
 public:
  TrackerClient(boost::asio::io_context& io, const TrackerSettings& settings, DeviceOutput& outlet);
  ~TrackerClient();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace vrda::bench
