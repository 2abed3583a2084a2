#include "bench/simulated_devices.hpp"

#include <fcntl.h>
#include <poll.h>
#include <stdlib.h>
#include <sys/eventfd.h>
#include <sys/file.h>
#include <termios.h>
#include <unistd.h>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/write.hpp>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <thread>

#include "bench/board.h"
#include "bench/simulation.hpp"
#include "core/files.hpp"

namespace vrda::bench {
namespace {

/// Poll period of the encoder: the stage cannot be moved by the counter's range of 16 cm in that time.
constexpr int poll_ms = 5;

InputError terminal_error(const std::string& field, const std::string& wanted)
{
  return InputError({"simulated board", field, std::strerror(errno), wanted});
}

/// Whether a running board holds the terminal: it keeps it locked, and a killed one's number may be
/// another's.
bool is_held(const std::string& terminal)
{
  const OpenFile there(open(terminal.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  return there.is_open() && flock(there.get(), LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
}

/// Replaces the link that a killed board left, atomically, so that the path always exists.
void make_link(const std::string& link, const std::string& target)
{
  namespace fs = std::filesystem;
  std::error_code error;
  const fs::file_status there = fs::symlink_status(link, error);
  const std::string link_target = fs::is_symlink(there) ? fs::read_symlink(link, error).string() : "";
  if (fs::exists(there) && link_target.rfind("/dev/pts/", 0) != 0)
    throw InputError({"simulated board", link, link_target.empty() ? "a file" : "a link to " + link_target,
                      "a free path, or a link into /dev/pts, for the link to the terminal"});
  // The number of a killed board's terminal may be this one's.
  if (!link_target.empty() && link_target != target && is_held(link_target))
    throw InputError({"simulated board", link, "the link of a running simulation",
                      "another [board] port, or the end of that simulation"});
  const std::string temporary = link + ".new";
  fs::remove(temporary, error);
  fs::create_symlink(target, temporary, error);
  if (!error) fs::rename(temporary, link, error);
  if (error)
    throw InputError(
        {"simulated board", link, error.message(), "a path where a link to the terminal can be created"});
}

/// The name of the far end of a new pseudo-terminal.
std::string opened_name(const OpenFile& terminal)
{
  char name[128] = "";
  if (!terminal.is_open() || grantpt(terminal.get()) != 0 || unlockpt(terminal.get()) != 0 ||
      ptsname_r(terminal.get(), name, sizeof name) != 0)
    throw terminal_error("terminal", "a pseudo-terminal of this machine");
  return name;
}

}  // namespace

struct PtyBoard::State {
  explicit State(const PtyBoardOptions& options_)
      : options(options_),
        wake(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)),
        terminal(posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)),
        path(opened_name(terminal)),
        far_end(open(path.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC))
  {
    check(options.potentiometer && options.stage_count,
          "PtyBoardOptions: potentiometer and stage_count are required");
    termios settings{};
    if (!far_end.is_open() || tcgetattr(far_end.get(), &settings) != 0)
      throw terminal_error(path, "a pseudo-terminal");
    if (flock(far_end.get(), LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK)
      throw terminal_error(path, "a terminal of its own");
    cfmakeraw(&settings);
    tcsetattr(far_end.get(), TCSANOW, &settings);
    if (!options.link.empty()) make_link(options.link, path);
    count = options.stage_count();
    quadrature_start(&signals, signal_a(), signal_b());
    board_start(&firmware, &hardware);
    thread = std::thread([this] { run(); });
  }

  ~State()
  {
    is_ending = true;
    const std::uint64_t one = 1;
    [[maybe_unused]] const ssize_t n = ::write(wake.get(), &one, sizeof one);
    thread.join();
    // The user may have replaced the link. While the terminal is open, its name is no other's.
    std::error_code ignored;
    if (!options.link.empty() && std::filesystem::read_symlink(options.link, ignored) == path)
      std::filesystem::remove(options.link, ignored);
  }

  /// Quadrature signals of a count: 00, 10, 11, 01, cyclic.
  bool signal_a() const { return ((count + 1) & 2) != 0; }
  bool signal_b() const { return (count & 2) != 0; }

  void move_stage()
  {
    const int target = options.stage_count();
    while (count != target) {
      count += target > count ? 1 : -1;
      quadrature_edge(&signals, signal_a(), signal_b());
      // A jump of stage_count() may exceed the 16-bit counter: it is read often enough on the way.
      if (count % 10'000 == 0) board_poll(&firmware);
    }
  }

  void run()
  {
    while (!is_ending) {
      move_stage();
      board_loop(&firmware);
      pollfd waiting[2] = {{wake.get(), POLLIN, 0}, {terminal.get(), POLLIN, 0}};
      poll(waiting, 2, poll_ms);
    }
  }

  /// Bytes that the terminal does not accept are lost, as on a real serial line.
  void send(std::vector<std::uint8_t> bytes) const
  {
    if (options.corrupt) options.corrupt(bytes);
    [[maybe_unused]] const ssize_t n = ::write(terminal.get(), bytes.data(), bytes.size());
  }

  static State& of(void* self) { return *static_cast<State*>(self); }

  static int receive(void* self)
  {
    std::uint8_t byte = 0;
    return ::read(of(self).terminal.get(), &byte, 1) == 1 ? byte : -1;
  }

  const PtyBoardOptions options;
  OpenFile wake, terminal;
  std::string path;
  OpenFile far_end;  ///< kept open, so that a client closing it causes no hang-up
  int count = 0;
  quadrature signals{};
  hal hardware{this,
               receive,
               [](void* self, const std::uint8_t* bytes, std::uint8_t n) {
                 of(self).send({bytes, bytes + n});
               },
               [](void* self) { return static_cast<std::uint16_t>(of(self).options.potentiometer()); },
               [](void* self) { return quadrature_read_and_reset_counter(&of(self).signals); },
               [](void* self) { return quadrature_read_and_reset_lost(&of(self).signals); }};
  board firmware{};
  std::atomic<bool> is_ending{false};
  std::thread thread;
};

PtyBoard::PtyBoard(const PtyBoardOptions& options) : state_(std::make_unique<State>(options)) {}

PtyBoard::~PtyBoard() = default;

std::string PtyBoard::path() const
{
  return state_->options.link.empty() ? state_->path : state_->options.link;
}

// Servers of OpenIGTLink messages: the simulated tracker, and the joint for other programs.

namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;
using Bytes = std::vector<std::uint8_t>;

/// Some seconds of messages; a client that lags by more is disconnected.
constexpr std::size_t most_pending_bytes = 1 << 20;

/// What a session does with what its client sends.
enum class Requests { answered, ignored };

/// One client connection. Reads its requests and writes messages one after the other. Kept alive by its
/// pending handlers.
class Session : public std::enable_shared_from_this<Session> {
 public:
  /// `greeting` is sent first and does not count as lag.
  Session(tcp::socket socket, Requests requests, const Bytes& greeting)
      : socket_(std::move(socket)),
        requests_(requests),
        pending_(greeting),
        most_pending_(most_pending_bytes + greeting.size())
  {
    error_code ignored;
    socket_.set_option(tcp::no_delay(true), ignored);
  }

  bool is_done() const { return is_done_; }
  /// The highest one that the client has sent, as PlusServer does it: version 2 states what is visible.
  int header_version() const { return header_version_; }

  void end()
  {
    error_code ignored;
    socket_.close(ignored);
    is_done_ = true;
  }

  void send(const Bytes& bytes)
  {
    if (pending_.size() + bytes.size() > most_pending_) return end();
    pending_.insert(pending_.end(), bytes.begin(), bytes.end());
    if (writing_.empty()) write();
  }

  /// Starts to send the greeting and to read.
  void start()
  {
    write();
    read();
  }

 private:
  void read()
  {
    socket_.async_read_some(asio::buffer(read_),
                            [this, self = shared_from_this()](const error_code& error, std::size_t n) {
                              if (error) return end();
                              if (requests_ == Requests::answered) stream_.add(std::span(read_).first(n));
                              while (const std::optional<IgtlMessage> request = stream_.next())
                                answer(*request);
                              if (stream_.is_broken()) return end();
                              read();
                            });
  }

  void answer(const IgtlMessage& request)
  {
    header_version_ = std::max(header_version_, request.header_version);
    if (request.kind != IgtlKind::start_tdata && request.kind != IgtlKind::stop_tdata) return;
    IgtlMessage answer;
    answer.kind = IgtlKind::tdata_started;
    answer.device = request.device;
    answer.code = 0;
    send(bytes_of(answer));
  }

  void write()
  {
    if (pending_.empty() || is_done_) return;
    writing_.swap(pending_);
    asio::async_write(socket_, asio::buffer(writing_),
                      [this, self = shared_from_this()](const error_code& error, std::size_t) {
                        writing_.clear();
                        if (error) return end();
                        write();
                      });
  }

  tcp::socket socket_;
  bool is_done_ = false;
  std::array<std::uint8_t, 1024> read_{};
  Requests requests_;
  IgtlStream stream_;
  Bytes pending_, writing_;
  std::size_t most_pending_;
  int header_version_ = 1;
};

/// Listens on a numeric address. `name`: of the server, for errors.
void listen_on(tcp::acceptor& acceptor, const std::string& name, const IgtlServerOptions& options)
{
  error_code error;
  const asio::ip::address address = asio::ip::make_address(options.address, error);
  if (error) throw InputError({name, "address", options.address, "a numeric address of this machine"});
  const tcp::endpoint endpoint(address, options.port);
  acceptor.open(endpoint.protocol(), error);
  // Allows the port to be reused while old connections are in TIME_WAIT.
  if (!error) acceptor.set_option(tcp::acceptor::reuse_address(true), error);
  if (!error) acceptor.bind(endpoint, error);
  if (!error) acceptor.listen(asio::socket_base::max_listen_connections, error);
  if (error)
    throw InputError({name, "port",
                      options.address + ":" + std::to_string(options.port) + ": " + error.message(),
                      "an address of this machine and a free port from 1024 to 65535, or 0"});
}

/// Listens, and keeps the sessions of its clients. The owner starts the thread when it is complete, and stops
/// it before its own members end.
class Clients {
 public:
  /// `greeting`: for each client, before anything else.
  Clients(const std::string& name, const IgtlServerOptions& options, Requests requests, Bytes greeting = {})
      : requests_(requests), greeting_(std::move(greeting))
  {
    listen_on(acceptor_, name, options);
    error_code error;
    port_ = acceptor_.local_endpoint(error).port();
    accept();
  }

  void start()
  {
    thread_ = std::thread([this] { io.run(); });
  }

  void stop()
  {
    io.stop();
    thread_.join();
  }

  void remove_ended()
  {
    std::erase_if(sessions, [](const std::shared_ptr<Session>& session) { return session->is_done(); });
    n_clients_ = static_cast<int>(sessions.size());
  }

  std::uint16_t port() const { return port_; }
  int n_clients() const { return n_clients_; }

  asio::io_context io{1};
  std::vector<std::shared_ptr<Session>> sessions;

 private:
  void accept()
  {
    acceptor_.async_accept([this](const error_code& error, tcp::socket socket) {
      if (!error) {
        sessions.push_back(std::make_shared<Session>(std::move(socket), requests_, greeting_));
        sessions.back()->start();
        n_clients_ = static_cast<int>(sessions.size());
      }
      accept();
    });
  }

  const Requests requests_;
  const Bytes greeting_;
  tcp::acceptor acceptor_{io};
  std::atomic<int> n_clients_{0};
  std::uint16_t port_ = 0;
  std::thread thread_;
};

}  // namespace

struct TrackerServer::State {
  State(const TrackerServerOptions& options_, MessageSource make_messages_)
      : options(options_),
        make_messages(std::move(make_messages_)),
        clients("tracker server", options_, Requests::answered),
        timer(clients.io)
  {
    check(options.rate_hz > 0.0 && options.jitter_ms >= 0.0 && options.jitter_ms <= 500.0 / options.rate_hz,
          "rate_hz must be positive and jitter_ms at most half a period");
    begin = std::chrono::steady_clock::now();
    wait();
    clients.start();
  }

  ~State() { clients.stop(); }

  /// Tick times are computed from the start, so they do not drift.
  void wait()
  {
    const double part = RandomSequence(options.seed, RandomPurpose::tracker_jitter, tick).uniform();
    const double due_ms =
        1e3 * static_cast<double>(tick) / options.rate_hz + options.jitter_ms * (2.0 * part - 1.0);
    timer.expires_at(begin + std::chrono::duration_cast<std::chrono::steady_clock::duration>(
                                 std::chrono::duration<double, std::milli>(due_ms)));
    timer.async_wait([this](const error_code& error) {
      if (error) return;
      send_tick();
      ++tick;
      wait();
    });
  }

  void send_tick()
  {
    const std::vector<IgtlMessage> messages = make_messages(tick);
    for (const std::shared_ptr<Session>& session : clients.sessions) {
      Bytes bytes = bytes_for(messages, session->header_version());
      if (options.corrupt) options.corrupt(bytes);
      session->send(bytes);
    }
    clients.remove_ended();
  }

  static Bytes bytes_for(std::vector<IgtlMessage> messages, int header_version)
  {
    Bytes bytes;
    for (IgtlMessage& message : messages) {
      message.header_version = std::max(message.header_version, header_version);
      const Bytes more = bytes_of(message);
      bytes.insert(bytes.end(), more.begin(), more.end());
    }
    return bytes;
  }

  const TrackerServerOptions options;
  const MessageSource make_messages;
  Clients clients;
  asio::steady_timer timer;
  std::chrono::steady_clock::time_point begin;
  std::uint64_t tick = 0;
};

TrackerServer::TrackerServer(const TrackerServerOptions& options, MessageSource make_messages)
    : state_(std::make_unique<State>(options, std::move(make_messages)))
{
}

TrackerServer::~TrackerServer() = default;

std::uint16_t TrackerServer::port() const
{
  return state_->clients.port();
}

int TrackerServer::n_clients() const
{
  return state_->clients.n_clients();
}

struct IgtlServer::State {
  State(const IgtlServerOptions& options, Bytes greeting, ByteSource next_)
      : next(std::move(next_)),
        clients("--igtl", options, Requests::ignored, std::move(greeting)),
        event(clients.io, eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK))
  {
    wait();
    clients.start();
  }

  ~State() { clients.stop(); }

  void wait()
  {
    event.async_wait(asio::posix::stream_descriptor::wait_read, [this](const error_code& error) {
      if (error) return;
      std::uint64_t n_woken = 0;
      // Resets the event; a failed read leaves it set, and the source is called again.
      if (read(event.native_handle(), &n_woken, sizeof n_woken) < 0) n_woken = 0;
      for (Bytes bytes = next(); !bytes.empty(); bytes = next()) {
        for (const std::shared_ptr<Session>& session : clients.sessions) session->send(bytes);
      }
      clients.remove_ended();
      wait();
    });
  }

  const ByteSource next;
  Clients clients;
  asio::posix::stream_descriptor event;
};

IgtlServer::IgtlServer(const IgtlServerOptions& options, std::vector<std::uint8_t> greeting, ByteSource next)
    : state_(std::make_unique<State>(options, std::move(greeting), std::move(next)))
{
}

IgtlServer::~IgtlServer() = default;

std::uint16_t IgtlServer::port() const
{
  return state_->clients.port();
}

void IgtlServer::wake()
{
  const std::uint64_t one = 1;
  // Fails only if the counter is full: the server is then awake.
  [[maybe_unused]] const ssize_t n = write(state_->event.native_handle(), &one, sizeof one);
}

}  // namespace vrda::bench
