/// The connection to an OpenIGTLink source: made, kept and made again.
#pragma once

#include <memory>

#include "devices/outlet.hpp"

namespace boost::asio {
class io_context;
}

namespace vrda {

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
