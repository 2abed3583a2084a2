/// The connections to the board and to an OpenIGTLink source: made, kept and made again.
#pragma once

#include <algorithm>
#include <memory>

#include "devices/outlet.hpp"

namespace boost::asio {
class io_context;
}

namespace vrda {

/// Doubles from `first_ms` to 20 times that (0.1 s to 2 s), and stays there: a device that returns is met
/// within that time, and one that never does costs next to nothing.
class Backoff {
 public:
  explicit Backoff(double first_ms) : first_ms_(first_ms), next_ms_(first_ms) {}

  double next_ms()
  {
    const double now_ms = next_ms_;
    next_ms_ = std::min(2.0 * now_ms, 20.0 * first_ms_);
    return now_ms;
  }

  /// The peer has shown that it is what was looked for.
  void reset() { next_ms_ = first_ms_; }

 private:
  double first_ms_, next_ms_;
};

/// Runs in the thread of `io`. The line is up when the board has told its version; an error of the line,
/// another version and a board that has fallen silent close it, to be opened anew with growing pauses.
class BoardClient {
 public:
  BoardClient(boost::asio::io_context& io, const BoardSettings& settings, Outlet& outlet);
  ~BoardClient();
  BoardClient(const BoardClient&) = delete;
  BoardClient& operator=(const BoardClient&) = delete;

  /// From any thread.
  void zero_stage();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Runs in the thread of `io`. A broken stream of messages, an error and a silent end of the peer's machine
/// (TCP keep-alive, 5 s) close the connection; it is made anew with growing pauses, which a first whole
/// message makes small again.
class TrackerClient {
 public:
  TrackerClient(boost::asio::io_context& io, const TrackerSettings& settings, Outlet& outlet);
  ~TrackerClient();
  TrackerClient(const TrackerClient&) = delete;
  TrackerClient& operator=(const TrackerClient&) = delete;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace vrda
