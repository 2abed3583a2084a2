#include "web/session.hpp"

#include <algorithm>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/error.hpp>
#include <boost/asio/ssl/stream.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core/file_posix.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/write.hpp>
#include <boost/beast/websocket/stream.hpp>
#include <filesystem>
#include <sstream>
#include <string_view>
#include <utility>

namespace vrda::web {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = boost::beast::http;
namespace websocket = boost::beast::websocket;
using asio::ip::tcp;
using boost::system::error_code;

namespace {

/// Time limit from accept to the complete request, and from the end of the response to the client's close.
constexpr std::chrono::seconds request_limit{10};
/// Time limit for a client that reads nothing of its response, or answers no ping.
constexpr std::chrono::seconds longest_silence{20};
/// Browsers send less than 2 KB.
constexpr std::uint32_t longest_request_head = 16384;
constexpr std::size_t read_size = 4096, piece_size = 65536;
/// Limit for data after the request; the connection is closed beyond it.
constexpr std::size_t most_drained = 1U << 20U;
/// Bytes in the kernel for a WebSocket, about a second of messages: queued messages arrive late.
constexpr int live_send_buffer = 16384;
/// Largest message from a viewer; viewers send none.
constexpr std::size_t longest_said = 125;

}  // namespace

/// A stream of Beast over a socket, encrypted or not.
class Line {
 public:
  using executor_type = tcp::socket::executor_type;
  using Done = std::function<void(const error_code&, std::size_t)>;

  Line(asio::io_context& io, asio::ssl::context* tls, int handle) : socket_(io)
  {
    error_code ignored;
    // The protocol only matters for opening.
    socket_.assign(tcp::v4(), handle, ignored);
    // An answer is written in pieces: otherwise a short last one waits for an acknowledgement, 45 ms with
    // TLS.
    socket_.set_option(tcp::no_delay(true), ignored);
    if (tls != nullptr) tls_.emplace(socket_, *tls);
  }

  executor_type get_executor() { return socket_.get_executor(); }
  tcp::socket& socket() { return socket_; }
  bool is_encrypted() const { return tls_.has_value(); }

  void async_handshake(Done done)
  {
    tls_->async_handshake(asio::ssl::stream_base::server, WithoutCount{std::move(done)});
  }
  void async_shutdown(Done done) { tls_->async_shutdown(WithoutCount{std::move(done)}); }

  /// As Beast calls them. Handlers are type-erased, and only the first buffer is used, so that both kinds of
  /// streams are compiled once instead of for each step of Beast: half a megabyte of the program.
  template <typename Buffers, typename Handler>
  void async_read_some(const Buffers& buffers, Handler&& handler)
  {
    read_some(first_of<asio::mutable_buffer>(buffers), erased(std::forward<Handler>(handler)));
  }

  template <typename Buffers, typename Handler>
  void async_write_some(const Buffers& buffers, Handler&& handler)
  {
    write_some(first_of<asio::const_buffer>(buffers), erased(std::forward<Handler>(handler)));
  }

  void read_some(const asio::mutable_buffer& buffer, Done done)
  {
    if (tls_) return tls_->async_read_some(buffer, std::move(done));
    socket_.async_read_some(buffer, std::move(done));
  }

  void write_some(const asio::const_buffer& buffer, Done done)
  {
    if (tls_) return tls_->async_write_some(buffer, std::move(done));
    socket_.async_write_some(buffer, std::move(done));
  }

 private:
  struct WithoutCount {
    Done done;
    void operator()(const error_code& error) const { done(error, 0); }
  };

  /// The first buffer that is not empty: operations of "some" may end after it.
  template <typename Buffer, typename Buffers>
  static Buffer first_of(const Buffers& buffers)
  {
    for (auto one = asio::buffer_sequence_begin(buffers); one != asio::buffer_sequence_end(buffers); ++one) {
      const Buffer buffer(*one);
      if (buffer.size() > 0) return buffer;
    }
    return {};
  }

  template <typename Handler>
  static Done erased(Handler&& handler)
  {
    // Beast's handlers cannot be copied.
    const auto kept = std::make_shared<std::decay_t<Handler>>(std::forward<Handler>(handler));
    return [kept](const error_code& error, std::size_t n) { (*kept)(error, n); };
  }

  tcp::socket socket_;
  std::optional<asio::ssl::stream<tcp::socket&>> tls_;
};

/// What Beast does at the end of a WebSocket: its close frame was sent, so the connection may end.
void beast_close_socket(Line& line)
{
  error_code ignored;
  line.socket().close(ignored);
}

void teardown(beast::role_type, Line& line, error_code& error)
{
  line.socket().close(error);
}

template <typename Handler>
void async_teardown(beast::role_type, Line& line, Handler&& handler)
{
  error_code error;
  line.socket().close(error);
  asio::post(line.get_executor(), beast::bind_front_handler(std::forward<Handler>(handler), error));
}

namespace {

std::string head_of(const Response& response)
{
  http::response<http::empty_body> message;
  message.result(response.status);
  for (const auto& [name, value] : response.fields) message.set(name, value);
  std::ostringstream head;
  head << message.base();
  return head.str();
}

std::optional<Request> request_of(const http::request<http::empty_body>& message)
{
  if (message.count(http::field::host) != 1) return std::nullopt;
  Request request;
  request.method = message.method_string().to_string();
  request.target = message.target().to_string();
  request.host = message[http::field::host].to_string();
  request.range = message[http::field::range].to_string();
  request.origin = message[http::field::origin].to_string();
  request.is_upgrade = websocket::is_upgrade(message);
  return request;
}

/// Detects malformed requests for which Beast waits for more data: a line ending with LF alone, a short first
/// line.
bool is_malformed(std::string_view unread)
{
  for (std::size_t k = 0; k < unread.size(); ++k) {
    if (unread[k] == '\n' && (k == 0 || unread[k - 1] != '\r')) return true;
  }
  return unread.find("\r\n\r\n") != std::string_view::npos;
}

/// Reads one request, sends one response, waits for the client's close; or streams.
class Connection final : public Session, public std::enable_shared_from_this<Connection> {
 public:
  Connection(asio::io_context& io, asio::ssl::context* tls, int handle, const SessionRules& rules)
      : line_(io, tls, handle), timer_(io), rules_(rules)
  {
    parser_.header_limit(longest_request_head);
    parser_.body_limit(boost::none);  // no body is read
  }

  void start()
  {
    limit(request_limit);
    if (!line_.is_encrypted()) return read();
    line_.async_handshake([this, self = shared_from_this()](const error_code& error, std::size_t) {
      if (phase_ != Phase::requesting) return;
      if (error) return end();
      is_greeted_ = true;
      read();
    });
  }

  void end() override
  {
    if (phase_ == Phase::ended) return;
    phase_ = Phase::ended;
    timer_.cancel();
    error_code ignored;
    line_.socket().close(ignored);
  }

  SessionKind kind() const override
  {
    switch (phase_) {
      case Phase::requesting:
        return SessionKind::pending;
      case Phase::live:
        return SessionKind::live;
      case Phase::ended:
        return SessionKind::ended;
      case Phase::answering:
        return SessionKind::answering;
      case Phase::draining:
        break;
    }
    // As before the response: the client has received its response.
    return SessionKind::pending;
  }

  Clock::time_point waits_since() const override { return waits_since_; }

  void offer(const LiveMessage& message) override
  {
    if (phase_ != Phase::live || !is_open_for_messages_) return;
    if (is_writing_) {
      next_ = message;
      return;
    }
    write(message);
  }

 private:
  enum class Phase { requesting, answering, draining, live, ended };

  void limit(Clock::duration time)
  {
    timer_.expires_after(time);
    timer_.async_wait([this, self = shared_from_this()](const error_code& error) {
      // Ignore an expiry that was already queued when the next limit was set.
      if (error || timer_.expiry() > Clock::now()) return;
      const bool can_answer = phase_ == Phase::requesting && (is_greeted_ || !line_.is_encrypted());
      if (can_answer) return answer(request_timeout());
      end();
    });
  }

  void read()
  {
    line_.read_some(buffer_.prepare(read_size), [this, self = shared_from_this()](const error_code& error,
                                                                                  std::size_t n) {
      if (phase_ != Phase::requesting) return;
      const bool is_at_end = error == asio::error::eof || error == asio::ssl::error::stream_truncated;
      if (error && !is_at_end) return end();
      buffer_.commit(n);
      parse(is_at_end);
    });
  }

  void parse(bool is_at_end)
  {
    error_code error;
    buffer_.consume(parser_.put(buffer_.data(), error));
    if (parser_.is_header_done()) {
      const std::optional<Request> request = request_of(parser_.get());
      return answer(request ? respond(*request) : bad_request());
    }
    if (is_at_end && !parser_.got_some()) return end();
    const std::string_view unread(static_cast<const char*>(buffer_.data().data()), buffer_.size());
    if (is_at_end || error != http::error::need_more || is_malformed(unread)) return answer(bad_request());
    read();
  }

  /// For the present state of the model file, which stays open for the response.
  Response respond(const Request& request)
  {
    error_code error;
    std::error_code no_file;
    std::optional<std::uint64_t> size;
    if (std::filesystem::is_regular_file(rules_.model, no_file))
      model_.open(rules_.model.c_str(), beast::file_mode::scan, error);
    if (model_.is_open()) size = model_.size(error);
    return rules_.respond(request, size);
  }

  void answer(Response response)
  {
    waits_since_ = Clock::now();
    if (response.content == Content::live) return go_live();
    phase_ = Phase::answering;
    error_code ignored;
    // A pending read.
    line_.socket().cancel(ignored);
    response_ = std::move(response);
    if (response_.content == Content::model) model_.seek(response_.first_byte, ignored);
    piece_ = head_of(response_);
    unsent_ = piece_;
    send();
  }

  /// The next piece of the content; empty at the end, or if the file was truncated.
  std::string_view next_piece()
  {
    const std::size_t wanted = std::min<std::uint64_t>(piece_size, response_.n_bytes - n_taken_);
    if (response_.content == Content::model) {
      error_code ignored;
      piece_.resize(wanted);
      piece_.resize(model_.read(piece_.data(), wanted, ignored));
    } else {
      const std::string_view whole = response_.content == Content::page ? compressed_page() : response_.text;
      piece_ = whole.substr(n_taken_, wanted);
    }
    n_taken_ += piece_.size();
    return piece_;
  }

  void send()
  {
    if (unsent_.empty()) unsent_ = next_piece();
    if (unsent_.empty()) return finish();
    limit(longest_silence);
    line_.write_some(asio::buffer(unsent_),
                     [this, self = shared_from_this()](const error_code& error, std::size_t n) {
                       if (error) return end();
                       waits_since_ = Clock::now();
                       unsent_.remove_prefix(n);
                       send();
                     });
  }

  void finish()
  {
    phase_ = Phase::draining;
    limit(request_limit);
    // The end of the encrypted stream, then that of the socket.
    if (line_.is_encrypted())
      return line_.async_shutdown(
          [this, self = shared_from_this()](const error_code&, std::size_t) { end(); });
    error_code ignored;
    line_.socket().shutdown(tcp::socket::shutdown_send, ignored);
    drain();
  }

  /// Reads remaining data: closing a socket with unread data resets the connection and discards the response.
  void drain()
  {
    piece_.resize(read_size);
    line_.read_some(asio::buffer(piece_),
                    [this, self = shared_from_this()](const error_code& error, std::size_t n) {
                      n_drained_ += n;
                      if (error || n_drained_ > most_drained) return end();
                      drain();
                    });
  }

  void go_live()
  {
    phase_ = Phase::live;
    timer_.cancel();
    error_code ignored;
    line_.socket().set_option(asio::socket_base::send_buffer_size(live_send_buffer), ignored);
    socket_.emplace(line_);
    socket_->set_option(websocket::stream_base::timeout{request_limit, longest_silence, true});
    socket_->read_message_max(longest_said);
    socket_->text(true);
    socket_->auto_fragment(false);
    socket_->async_accept(parser_.get(), [this, self = shared_from_this()](const error_code& error) {
      if (error) return end();
      is_open_for_messages_ = true;
      waits_since_ = Clock::now();
      listen();
      if (const LiveMessage greeting = rules_.greeting()) offer(greeting);
    });
  }

  /// Reads pings and the close; a message of the viewer ends the session.
  void listen()
  {
    socket_->async_read(buffer_,
                        [this, self = shared_from_this()](const error_code&, std::size_t) { end(); });
  }

  void write(const LiveMessage& message)
  {
    is_writing_ = true;
    limit(longest_silence);
    socket_->async_write(asio::buffer(*message),
                         [this, message, self = shared_from_this()](const error_code& error, std::size_t) {
                           is_writing_ = false;
                           if (error) return end();
                           if (phase_ != Phase::live) return;
                           timer_.cancel();
                           waits_since_ = Clock::now();
                           if (const LiveMessage next = std::exchange(next_, nullptr)) write(next);
                         });
  }

  Line line_;
  asio::steady_timer timer_;
  const SessionRules& rules_;
  Phase phase_ = Phase::requesting;
  bool is_greeted_ = false;  ///< the TLS handshake is done
  Clock::time_point waits_since_ = Clock::now();
  beast::flat_buffer buffer_;
  http::request_parser<http::empty_body> parser_;
  Response response_;
  beast::file_posix model_;
  std::string piece_;          ///< piece of the response, or buffer for draining
  std::string_view unsent_;    ///< part of piece_
  std::uint64_t n_taken_ = 0;  ///< bytes of the content copied to pieces
  std::size_t n_drained_ = 0;
  std::optional<websocket::stream<Line&, false>> socket_;
  bool is_open_for_messages_ = false, is_writing_ = false;
  LiveMessage next_;
};

}  // namespace

std::shared_ptr<Session> start_session(asio::io_context& io, asio::ssl::context* tls, int handle,
                                       const SessionRules& rules)
{
  const auto session = std::make_shared<Connection>(io, tls, handle, rules);
  session->start();
  return session;
}

}  // namespace vrda::web
