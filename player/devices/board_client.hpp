/// The serial line to the micro-controller: opened, kept and opened again.
#pragma once

#include <memory>

#include "devices/outlet.hpp"

namespace boost::asio {
class io_context;
}

namespace vrda {

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

}  // namespace vrda
