/// Connections to the board (serial) and to an OpenIGTLink server, with automatic reconnection. In: bytes.
/// Out: samples with their time of arrival, ns of the local clock. A lost or wrong peer is a status of the
/// link, not an exception.
#pragma once

#include <algorithm>
#include <memory>

#include "bench/device_output.hpp"

namespace boost::asio {
class io_context;
}

namespace vrda::bench {

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
