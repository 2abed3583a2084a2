/// Simulated devices: the board, which is the real firmware behind a pseudo-terminal, and the tracker, which
/// streams messages made by a callback; the server that also sends the joint to other programs.
#pragma once

#include <functional>
#include <memory>

#include "bench/igtl_message.hpp"

namespace vrda::bench {

struct PtyBoardOptions {
  /// Symbolic link to the terminal, the same for each board; empty: no link.
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

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// Servers of OpenIGTLink messages: the simulated tracker, and the joint for other programs.

struct IgtlServerOptions {
  std::string address = "127.0.0.1";  ///< numeric; only this machine can connect by default
  std::uint16_t port = 0;             ///< 0: any free port
};

struct TrackerServerOptions : IgtlServerOptions {
  double rate_hz = 100.0;
  double jitter_ms = 0.0;  ///< each tick is early or late by up to this, at most half a period
  std::uint64_t seed = 1;  ///< of the jitter
  /// Corrupts the bytes of a tick for one client, in the server's thread; may be empty.
  std::function<void(std::vector<std::uint8_t>&)> corrupt;
};

/// Runs in a thread; clients that do not read are disconnected.
class TrackerServer {
 public:
  /// The messages of tick n, due n / rate_hz seconds after the first. Called in the server's thread; must
  /// not throw.
  using MessageSource = std::function<std::vector<IgtlMessage>(std::uint64_t tick)>;

  /// Throws InputError if the address is invalid or cannot be listened on.
  TrackerServer(const TrackerServerOptions& options, MessageSource make_messages);
  ~TrackerServer();

  std::uint16_t port() const;
  int n_clients() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Sends OpenIGTLink messages to every program that connects. Runs in a thread. A client that lags by more
/// than a megabyte is disconnected; what clients send is read and ignored.
class IgtlServer {
 public:
  /// The bytes of the next messages; empty without a message. Called in the server's thread; must not throw.
  using ByteSource = std::function<std::vector<std::uint8_t>()>;

  /// `greeting` is sent once to each client, before anything else. Throws InputError if the address is
  /// invalid or cannot be listened on.
  IgtlServer(const IgtlServerOptions& options, std::vector<std::uint8_t> greeting, ByteSource next);
  ~IgtlServer();

  std::uint16_t port() const;

  /// Calls the source until it is empty, and sends what it gives. From any thread; never blocks or allocates.
  void wake();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace vrda::bench
