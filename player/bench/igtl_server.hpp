/// Sends OpenIGTLink messages to every program that connects.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace vrda::bench {

struct IgtlServerOptions {
  std::string address = "127.0.0.1";  ///< numeric; only this machine can connect by default
  std::uint16_t port = 0;             ///< 0: any free port
  std::string name = "--igtl";        ///< of the address and port in errors
};

/// Runs in a thread. A client that lags by more than a megabyte is disconnected; what clients send is read
/// and ignored.
class IgtlServer {
 public:
  /// The bytes of the next messages; empty without a message. Called in the server's thread; must not throw.
  using ByteSource = std::function<std::vector<std::uint8_t>()>;

  /// `greeting` is sent once to each client, before anything else. Throws InputError if the address is
  /// invalid or cannot be listened on.
  IgtlServer(const IgtlServerOptions& options, std::vector<std::uint8_t> greeting, ByteSource next);
  ~IgtlServer();

  std::uint16_t port() const;
  int n_clients() const;

  /// Calls the source until it is empty, and sends what it gives. From any thread; never blocks or allocates.
  void wake();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace vrda::bench
