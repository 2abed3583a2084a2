/// One connection of the web server: reads a request and sends one response, or becomes a WebSocket that
/// receives every new message of the bench. Each step has a time limit, and a client that reads slowly misses
/// messages instead of delaying them.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>

#include "web/response.hpp"

namespace boost::asio {
class io_context;
namespace ssl {
class context;
}
}  // namespace boost::asio

namespace vrda::web {

/// `pending`: before the response, TLS handshake included.
enum class SessionKind { pending, answering, live, ended };

using LiveMessage = std::shared_ptr<const std::string>;

/// What the server decides for the sessions.
struct SessionRules {
  std::string model;  ///< path, for Content::model
  /// The response, with the size of the model file if it can be opened.
  std::function<Response(const Request&, std::optional<std::uint64_t> model_size)> respond;
  std::function<LiveMessage()> greeting;  ///< first message of a WebSocket
};

class Session {
 public:
  using Clock = std::chrono::steady_clock;

  virtual ~Session() = default;
  virtual void end() = 0;
  virtual SessionKind kind() const = 0;
  /// Time of the client's last read; before the response, of the connection.
  virtual Clock::time_point waits_since() const = 0;
  /// Sends a message to a live session. While an earlier one is under way, only the latest is kept.
  virtual void offer(const LiveMessage& message) = 0;
};

/// Starts the session of an accepted socket `handle`. `tls`: nullptr for a plain connection; else it must
/// outlive the session, as must `io` and `rules`. The pending operations keep the session alive.
std::shared_ptr<Session> start_session(boost::asio::io_context& io, boost::asio::ssl::context* tls,
                                       int handle, const SessionRules& rules);

}  // namespace vrda::web
