// The only file that includes Boost.Beast, whose headers compile slowly.
#include "web/server.hpp"

#include <spawn.h>
#include <stdlib.h>
#include <unistd.h>

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core/file_posix.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/write.hpp>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <functional>
#include <memory>
#include <ostream>
#include <sstream>
#include <string_view>

#include "core/error.hpp"
#include "store/motion_model_file.hpp"
#include "web/response.hpp"

extern char** environ;

namespace vrda::web {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = boost::beast::http;
using asio::ip::tcp;
using boost::system::error_code;
using Clock = std::chrono::steady_clock;

/// Time limit from accept to the complete request, and from the end of the response to the client's close.
constexpr std::chrono::seconds request_limit{10};
/// Time limit for a client that reads nothing of its response.
constexpr std::chrono::seconds longest_silence{20};
constexpr std::chrono::milliseconds accept_pause{100};
/// Limit for pending requests, and separately for responses in progress; a browser opens six connections.
constexpr std::size_t most_sessions = 32;
/// Browsers send less than 2 KB.
constexpr std::uint32_t longest_request_head = 16384;
constexpr std::size_t read_size = 4096, piece_size = 65536;
/// Limit for data after the request; the connection is closed beyond it.
constexpr std::size_t most_drained = 1U << 20U;

struct Answer {
  Response response;
  beast::file_posix model;  ///< positioned at the first byte if the response sends the model
};

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
  return Request{message.method_string().to_string(), message.target().to_string(),
                 message[http::field::host].to_string(), message[http::field::range].to_string()};
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

/// One connection: reads one request, sends one response, waits for the client's close; each with a time
/// limit. Kept alive by its pending operations.
class Session : public std::enable_shared_from_this<Session> {
 public:
  using Answering = std::function<Answer(const Request&)>;

  Session(tcp::socket socket, Answering answering)
      : socket_(std::move(socket)), timer_(socket_.get_executor()), answering_(std::move(answering))
  {
    parser_.header_limit(longest_request_head);
    parser_.body_limit(boost::none);  // no body is read
  }

  void start()
  {
    limit(request_limit);
    read();
  }

  void end()
  {
    phase_ = Phase::ended;
    timer_.cancel();
    error_code ignored;
    socket_.close(ignored);
  }

  bool is_open() const { return phase_ != Phase::ended; }
  bool is_answering() const { return phase_ == Phase::answering; }

  /// Time of the client's last read of the response; before the response, of the connection.
  Clock::time_point waits_since() const { return waits_since_; }

 private:
  enum class Phase { requesting, answering, draining, ended };

  void limit(Clock::duration time)
  {
    timer_.expires_after(time);
    timer_.async_wait([this, self = shared_from_this()](const error_code& error) {
      // Ignore an expiry that was already queued when the next limit was set.
      if (error || timer_.expiry() > Clock::now()) return;
      if (phase_ == Phase::requesting) return answer({request_timeout(), {}});
      end();
    });
  }

  void read()
  {
    socket_.async_read_some(buffer_.prepare(read_size),
                            [this, self = shared_from_this()](const error_code& error, std::size_t n) {
                              if (phase_ != Phase::requesting) return;
                              if (error && error != asio::error::eof) return end();
                              buffer_.commit(n);
                              parse(error == asio::error::eof);
                            });
  }

  void parse(bool is_at_end)
  {
    error_code error;
    buffer_.consume(parser_.put(buffer_.data(), error));
    if (parser_.is_header_done()) {
      const std::optional<Request> request = request_of(parser_.get());
      return answer(request ? answering_(*request) : Answer{bad_request(), {}});
    }
    if (is_at_end && !parser_.got_some()) return end();
    const std::string_view unread(static_cast<const char*>(buffer_.data().data()), buffer_.size());
    if (is_at_end || error != http::error::need_more || is_malformed(unread))
      return answer({bad_request(), {}});
    read();
  }

  void answer(Answer answer)
  {
    phase_ = Phase::answering;
    waits_since_ = Clock::now();
    error_code ignored;
    socket_.cancel(ignored);  // a pending read
    answer_ = std::move(answer);
    piece_ = head_of(answer_.response);
    unsent_ = piece_;
    send();
  }

  /// The next piece of the content; empty at the end, or if the file was truncated.
  std::string_view next_piece()
  {
    const Response& response = answer_.response;
    const std::size_t wanted = std::min<std::uint64_t>(piece_size, response.n_bytes - n_taken_);
    if (response.content == Content::model) {
      error_code ignored;
      piece_.resize(wanted);
      piece_.resize(answer_.model.read(piece_.data(), wanted, ignored));
    } else {
      const std::string_view whole = response.content == Content::page ? compressed_page() : response.text;
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
    socket_.async_write_some(asio::buffer(unsent_),
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
    error_code ignored;
    socket_.shutdown(tcp::socket::shutdown_send, ignored);
    limit(request_limit);
    drain();
  }

  /// Reads remaining data: closing a socket with unread data resets the connection and discards the response.
  void drain()
  {
    piece_.resize(read_size);
    socket_.async_read_some(asio::buffer(piece_),
                            [this, self = shared_from_this()](const error_code& error, std::size_t n) {
                              n_drained_ += n;
                              if (error || n_drained_ > most_drained) return end();
                              drain();
                            });
  }

  tcp::socket socket_;
  asio::steady_timer timer_;
  Answering answering_;
  Phase phase_ = Phase::requesting;
  Clock::time_point waits_since_ = Clock::now();
  beast::flat_buffer buffer_;
  http::request_parser<http::empty_body> parser_;
  Answer answer_;
  std::string piece_;          ///< piece of the response, or buffer for draining
  std::string_view unsent_;    ///< part of piece_
  std::uint64_t n_taken_ = 0;  ///< bytes of the content copied to pieces
  std::size_t n_drained_ = 0;
};

class Server {
 public:
  explicit Server(const WebOptions& options) : file_(options.file)
  {
    const tcp::endpoint endpoint(asio::ip::address_v4::loopback(), static_cast<std::uint16_t>(options.port));
    error_code error;
    acceptor_.open(endpoint.protocol(), error);
    if (!error) acceptor_.set_option(tcp::acceptor::reuse_address(true), error);
    if (!error) acceptor_.bind(endpoint, error);
    if (!error) acceptor_.listen(tcp::acceptor::max_listen_connections, error);
    if (error)
      throw InputError({"--port", "", std::to_string(options.port) + ": " + error.message(),
                        "an unused port from 1024 to 65535, or 0 for any free port"});
    site_.port = acceptor_.local_endpoint().port();
    site_.token = random_token();
    site_.page_size = compressed_page().size();
    site_.model_name = file_.filename().string();
  }

  std::string address() const
  {
    return "http://127.0.0.1:" + std::to_string(site_.port) + "/" + site_.token + "/";
  }

  /// Runs until SIGINT or SIGTERM.
  void run()
  {
    signals_.async_wait([this](const error_code&, int) { io_.stop(); });
    accept();
    io_.run();
  }

 private:
  void accept()
  {
    acceptor_.async_accept([this](const error_code& error, tcp::socket socket) {
      if (error) return accept_later();
      const auto session = std::make_shared<Session>(
          std::move(socket), [this](const Request& request) { return answer_to(request); });
      make_room(false);
      sessions_.push_back(session);
      session->start();
      accept();
    });
  }

  /// Retries after a pause if no file descriptor is available.
  void accept_later()
  {
    pause_.expires_after(accept_pause);
    pause_.async_wait([this](const error_code&) { accept(); });
  }

  /// The response for the present state of the model file.
  Answer answer_to(const Request& request)
  {
    Answer answer;
    Site site = site_;
    std::error_code no_file;
    error_code error;
    if (std::filesystem::is_regular_file(file_, no_file))
      answer.model.open(file_.c_str(), beast::file_mode::scan, error);
    if (answer.model.is_open()) site.model_size = answer.model.size(error);
    answer.response = response_to(request, site);
    // Text responses are short and do not count towards the limit.
    if (answer.response.content != Content::text) make_room(true);
    if (answer.response.content == Content::model) answer.model.seek(answer.response.first_byte, error);
    return answer;
  }

  /// Makes room for one more session of a kind: at the limit ends the session idle for the longest time.
  void make_room(bool is_answering)
  {
    std::vector<std::shared_ptr<Session>> rivals;
    std::erase_if(sessions_, [&](const std::weak_ptr<Session>& one) {
      const std::shared_ptr<Session> session = one.lock();
      if (!session || !session->is_open()) return true;
      if (session->is_answering() == is_answering) rivals.push_back(session);
      return false;
    });
    if (rivals.size() < most_sessions) return;
    const auto since = [](const auto& session) { return session->waits_since(); };
    (*std::ranges::min_element(rivals, {}, since))->end();
  }

  std::filesystem::path file_;
  Site site_;
  std::vector<std::weak_ptr<Session>> sessions_;
  asio::io_context io_{1};
  asio::signal_set signals_{io_, SIGINT, SIGTERM};
  tcp::acceptor acceptor_{io_};
  asio::steady_timer pause_{io_};
};

}  // namespace

void serve_web(const WebOptions& options, std::ostream& data, std::ostream& talk)
{
  // Reports an invalid file before the page is opened.
  store::require_grid(store::read_motion_model(options.file), options.file, "vrda-player web");
  Server server(options);
  const std::string address = server.address();
  data << address << std::endl;
  if (!options.is_quiet)
    talk << options.file << ": open the address above in a browser; Ctrl-C quits" << std::endl;
  std::optional<BrowserLaunch> visit;
  if (options.opens_browser) visit.emplace(address);
  if (visit && !visit->is_started()) talk << "no browser found: open " << address << std::endl;
  server.run();
}

BrowserLaunch::BrowserLaunch(const std::string& address)
{
  constexpr std::string_view ending = ".html";
  std::error_code error;
  file_ = (std::filesystem::temp_directory_path(error) / "vrda-player-XXXXXX").string() + std::string(ending);
  const int descriptor = mkstemps(file_.data(), static_cast<int>(ending.size()));
  if (descriptor < 0) {
    file_.clear();
    return;
  }
  const std::string page =
      "<!DOCTYPE html><meta charset=\"utf-8\"><title>VRDA player</title>"
      "<meta http-equiv=\"refresh\" content=\"0; url=" +
      address + "\">\n";
  const bool is_written = write(descriptor, page.data(), page.size()) == static_cast<ssize_t>(page.size());
  if (close(descriptor) != 0 || !is_written) return;
  std::string program = "xdg-open";
  char* arguments[] = {program.data(), file_.data(), nullptr};
  pid_t pid = 0;
  has_begun_ = posix_spawnp(&pid, program.c_str(), nullptr, nullptr, arguments, environ) == 0;
}

BrowserLaunch::~BrowserLaunch()
{
  unlink(file_.c_str());
}

}  // namespace vrda::web
