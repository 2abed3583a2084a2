/// An OpenIGTLink tracker that is none: it sends what a function makes up.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "igtl/message.hpp"

namespace vrda {

struct TrackerServerOptions {
  std::string address = "127.0.0.1";  ///< a number; nothing listens beyond this machine unless it says so
  std::uint16_t port = 0;             ///< 0: a free one
  double rate_hz = 100.0;
  double jitter_ms = 0.0;  ///< each tick comes early or late by up to that, at most half a period
  std::uint64_t seed = 1;  ///< of the jitter
  bool waits_for_request =
      false;  ///< sends TDATA and QTDATA only to those who asked (STT_TDATA), no oftener than they asked for
};

/// What a client has to live with.
enum class Mischief : std::uint8_t {
  half_a_message,  ///< half of the next tick's bytes; then it goes on as if nothing had been
  garbage,         ///< bytes that are no message ahead of the next tick's
  wrong_checksum,  ///< of the next tick's first message
  close            ///< the connections; new ones are taken
};

/// A thread of its own; clients that do not read are dropped.
class TrackerServer {
 public:
  /// The messages of tick n, due n / rate_hz seconds after the first; called in the server's thread, must not
  /// throw.
  using Speak = std::function<std::vector<IgtlMessage>(std::uint64_t tick)>;

  /// Throws InputError where the address is none or cannot be listened on.
  TrackerServer(const TrackerServerOptions& options, Speak speak);
  ~TrackerServer();
  TrackerServer(const TrackerServer&) = delete;
  TrackerServer& operator=(const TrackerServer&) = delete;

  std::uint16_t port() const;
  int n_clients() const;
  void misbehave(Mischief mischief);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace vrda
