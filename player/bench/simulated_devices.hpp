/// Simulated micro-controller board: the real firmware behind a pseudo-terminal.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "bench/igtl_message.hpp"

namespace vrda::bench {

struct PtyBoardOptions {
  /// Symbolic link to the terminal, which keeps its name when the board is replugged; empty: no link.
  std::string link;
  /// 0 to 1023. This and the next are called in the board's thread.
  std::function<int()> potentiometer;
  /// Stage position in counts of 5 micrometres, with any offset; the board moves there edge by edge.
  std::function<int()> stage_count;
  /// Corrupts bytes on their way to the host; may be empty.
  std::function<void(std::vector<std::uint8_t>&)> corrupt;
};

/// Runs player/firmware in a thread, with two quadrature signals for the encoder.
class PtyBoard {
 public:
  /// Throws InputError if the terminal or the link cannot be created. The link of a board that was killed is
  /// replaced; that of a running board, of this or another process, and any other link or file is not.
  explicit PtyBoard(const PtyBoardOptions& options);
  ~PtyBoard();

  /// The path to open: the link, or the terminal itself.
  std::string path() const;

  /// Closes the terminal; the board's position is lost.
  void unplug();
  /// Opens a new terminal at the same link; the board restarts. Throws as the constructor does.
  void plug();
  /// Sends bytes that were not requested.
  void send_unrequested(const std::vector<std::uint8_t>& bytes);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// Simulated OpenIGTLink tracker: streams messages made by a callback.

struct TrackerServerOptions {
  std::string address = "127.0.0.1";  ///< numeric; only this machine can connect by default
  std::uint16_t port = 0;             ///< 0: any free port
  double rate_hz = 100.0;
  double jitter_ms = 0.0;  ///< each tick is early or late by up to this, at most half a period
  std::uint64_t seed = 1;  ///< of the jitter
  bool waits_for_request =
      false;  ///< sends TDATA and QTDATA only to clients that sent STT_TDATA, at their interval
};

/// Faults for testing a client.
enum class FaultInjection : std::uint8_t {
  truncated_message,  ///< sends half of the next tick's bytes, then continues normally
  garbage,            ///< sends bytes that are not a message before the next tick
  wrong_checksum,     ///< in the first message of the next tick
  close_connections   ///< closes all connections; new ones are accepted
};

/// Runs in a thread; clients that do not read are disconnected.
class TrackerServer {
 public:
  /// The messages of tick n, due n / rate_hz seconds after the first. Called in the server's thread; must
  /// not throw.
  using MessageSource = std::function<std::vector<bench::IgtlMessage>(std::uint64_t tick)>;

  /// Throws InputError if the address is invalid or cannot be listened on.
  TrackerServer(const TrackerServerOptions& options, MessageSource make_messages);
  ~TrackerServer();

  std::uint16_t port() const;
  int n_clients() const;
  void inject_fault(FaultInjection fault);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace vrda::bench
