
#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>
#include <boost/asio/connect.hpp>
#include <boost/asio/generic/stream_protocol.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/serial_port.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/write.hpp>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <thread>
#include <utility>

#include "bench/protocols.hpp"
#include "core/process.hpp"

namespace vrda::bench {

namespace {

/// One of a periodic series, of which a single one may be dropped.
bool is_reading(const Sample& sample)
{
  if (sample.kind == SampleKind::tool_pose) return sample.is(ToolVisibility::seen);
  return sample.kind != SampleKind::link;
}

}  // namespace

bool SampleQueue::stage(const Sample& sample)
{
  const std::uint64_t n_waiting = n_staged_ - n_taken_.load(std::memory_order_acquire);
  if (n_waiting >= (is_reading(sample) ? capacity - n_reserved : capacity)) return false;
  slots_[n_staged_ % capacity] = sample;
  ++n_staged_;
  return true;
}

bool SampleQueue::take(Sample& sample)
{
  const std::uint64_t n_taken = n_taken_.load(std::memory_order_relaxed);
  if (n_taken == n_put_.load(std::memory_order_acquire)) return false;
  sample = slots_[n_taken % capacity];
  n_taken_.store(n_taken + 1, std::memory_order_release);
  return true;
}

void RateMeter::count(std::int64_t now_ns)
{
  const std::int64_t number = now_ns / bucket_ns;
  Bucket& bucket = buckets_[static_cast<std::size_t>(number) % n_buckets];
  if (bucket.number != number) bucket = {number, 0};
  ++bucket.n;
  if (first_ns_ < 0) first_ns_ = now_ns;
}

double RateMeter::rate_hz(std::int64_t now_ns) const
{
  const std::int64_t number = now_ns / bucket_ns;
  std::uint64_t n = 0;
  for (const Bucket& bucket : buckets_) {
    if (bucket.number > number - static_cast<std::int64_t>(n_buckets)) n += bucket.n;
  }
  if (n == 0) return 0.0;
  // From the oldest bin or the first reading, whichever is later, and at least one bin: a single reading
  // must not give a high rate.
  const std::int64_t begin_ns = (number - static_cast<std::int64_t>(n_buckets) + 1) * bucket_ns;
  const std::int64_t span_ns = std::max(now_ns - std::max(begin_ns, first_ns_), bucket_ns);
  return 1e9 * static_cast<double>(n) / static_cast<double>(span_ns);
}

DeviceOutput::DeviceOutput(DeviceId device, std::string peer, SampleQueue& queue, const ArrivalClock& clock)
    : device_(device), queue_(queue), clock_(clock)
{
  report_.peer = std::move(peer);
}

void DeviceOutput::put_one(const Sample& sample)
{
  if (!queue_.stage(sample)) ++report_.n_lost;
  if (!is_reading(sample)) return;
  ++report_.n_samples;
  rate_.count(sample.arrival_ns);
}

void DeviceOutput::put(const std::vector<Sample>& samples)
{
  if (samples.empty()) return;
  const std::scoped_lock lock(mutex_);
  for (const Sample& sample : samples) put_one(sample);
  queue_.publish();
}

void DeviceOutput::set_link(LinkState link, const std::string& error_message)
{
  const std::scoped_lock lock(mutex_);
  if (link == LinkState::up) {
    ++report_.n_connects;
    report_.error_message.clear();
  } else if (!error_message.empty()) {
    report_.error_message = error_message;
  }
  if (std::exchange(report_.link, link) == link) return;
  Sample sample;
  sample.arrival_ns = clock_.now_ns();
  sample.source = static_cast<std::uint16_t>(device_);
  sample.state = static_cast<std::uint8_t>(link);
  put_one(sample);
  queue_.publish();
}

void DeviceOutput::count_rejected(std::uint64_t n, const std::string& error_message)
{
  if (n == 0) return;
  const std::scoped_lock lock(mutex_);
  report_.n_refused += n;
  if (!error_message.empty()) report_.error_message = error_message;
}

void DeviceOutput::set_notes(std::vector<std::string> notes)
{
  const std::scoped_lock lock(mutex_);
  report_.notes = std::move(notes);
}

void DeviceOutput::set_error_message(const std::string& error_message)
{
  const std::scoped_lock lock(mutex_);
  report_.error_message = error_message;
}

DeviceReport DeviceOutput::report() const
{
  const std::scoped_lock lock(mutex_);
  DeviceReport report = report_;
  report.rate_hz = rate_.rate_hz(clock_.now_ns());
  return report;
}

namespace {

namespace asio = boost::asio;
using boost::system::error_code;

std::chrono::steady_clock::duration of_ms(double ms)
{
  return std::chrono::duration_cast<std::chrono::steady_clock::duration>(
      std::chrono::duration<double, std::milli>(ms));
}

/// Exponential back-off: doubles from `first_ms` to 20 times that (0.1 s to 2 s), then stays constant.
class Backoff {
 public:
  explicit Backoff(double first_ms) : first_ms_(first_ms), next_ms_(first_ms) {}

  /// Calls `open` after the next pause.
  template <typename Open>
  void wait(asio::steady_timer& timer, Open open)
  {
    timer.expires_after(of_ms(std::exchange(next_ms_, std::min(2.0 * next_ms_, 20.0 * first_ms_))));
    timer.async_wait([open](const error_code& error) {
      if (!error) open();
    });
  }

  /// Call when the peer has answered correctly.
  void reset() { next_ms_ = first_ms_; }

 private:
  double first_ms_, next_ms_;
};

/// A port that accepts no byte for this long is blocked.
constexpr std::int64_t write_timeout_ns = 1'000'000'000;

/// Connection to the board. The link is up once the version was received. A port error, a wrong version or a
/// silent board closes the port; it is reopened with back-off.
struct BoardClient {
  BoardClient(asio::io_context& io_, const BoardSettings& settings_, DeviceOutput& outlet_)
      : io(io_), settings(settings_), outlet(outlet_), port(io_), timer(io_), backoff(settings_.retry_ms)
  {
    open();
  }

  // Closing a port waits for unsent bytes, so they are discarded first.
  ~BoardClient()
  {
    if (port.is_open()) tcflush(port.native_handle(), TCIOFLUSH);
  }

  void open()
  {
    outlet.set_link(LinkState::opening, "");
    error_code error;
    port.open(settings.port, error);
    if (!error) port.set_option(asio::serial_port::baud_rate(static_cast<unsigned>(settings.baud)), error);
    if (error) return reconnect(error.message());
    // Discards answers to requests of an earlier session.
    tcflush(port.native_handle(), TCIOFLUSH);
    ++n_openings;
    is_writing = false;
    n_refused = 0;
    protocol.emplace(settings, outlet.clock().now_ns());
    read();
    send_due();
  }

  void read()
  {
    port.async_read_some(
        asio::buffer(bytes), [this, opening = n_openings](const error_code& error, std::size_t n) {
          const std::int64_t now_ns = outlet.clock().now_ns();
          if (opening != n_openings) return;
          if (error) return reconnect(error == asio::error::eof ? "closed by the device" : error.message());
          const bool was_up = protocol->phase() == BoardProtocol::Phase::up;
          const std::vector<Sample> samples = protocol->receive(std::span(bytes).first(n), now_ns);
          if (!was_up && protocol->phase() == BoardProtocol::Phase::up) {
            backoff.reset();
            outlet.set_link(LinkState::up, "");
          }
          outlet.put(samples);
          outlet.count_rejected(protocol->n_refused() - n_refused,
                                "found noise, wanted frames of the serial protocol");
          n_refused = protocol->n_refused();
          if (send_due()) read();
        });
  }

  /// Sends due requests and re-arms the timer; false if the port was closed.
  bool send_due()
  {
    const std::int64_t now_ns = outlet.clock().now_ns();
    if (!is_writing) {
      requests = protocol->due(now_ns);
      if (!requests.empty()) write(now_ns);
    } else if (now_ns - writing_since_ns >= write_timeout_ns) {
      reconnect("the port accepts no data");
      return false;
    }
    if (protocol->phase() == BoardProtocol::Phase::failed) {
      const std::string error_message = protocol->error_message();  // reconnect() destroys the protocol state
      reconnect(error_message);
      return false;
    }
    timer.expires_at(
        outlet.clock().time_of(is_writing ? writing_since_ns + write_timeout_ns : protocol->next_due_ns()));
    timer.async_wait([this, opening = n_openings](const error_code& error) {
      if (!error && opening == n_openings) send_due();
    });
    return true;
  }

  void write(std::int64_t now_ns)
  {
    is_writing = true;
    writing_since_ns = now_ns;
    asio::async_write(port, asio::buffer(requests),
                      [this, opening = n_openings](const error_code& error, std::size_t) {
                        if (opening != n_openings) return;
                        is_writing = false;
                        if (error) return reconnect(error.message());
                        send_due();
                      });
  }

  void reconnect(const std::string& error_message)
  {
    ++n_openings;  // invalidates pending handlers
    protocol.reset();
    error_code ignored;
    if (port.is_open()) tcflush(port.native_handle(), TCIOFLUSH);
    port.close(ignored);
    outlet.set_link(LinkState::closed, error_message);
    backoff.wait(timer, [this] { open(); });
  }

  /// From any thread.
  void zero_stage()
  {
    asio::post(io, [this] { zero_now(); });
  }

  void zero_now()
  {
    if (!protocol || protocol->phase() != BoardProtocol::Phase::up)
      return outlet.set_error_message("stage not zeroed: the board is not connected");
    protocol->zero_stage();
    send_due();
  }

  asio::io_context& io;
  const BoardSettings settings;
  DeviceOutput& outlet;
  asio::serial_port port;
  asio::steady_timer timer;  ///< of the next request, or of the back-off
  Backoff backoff;
  std::optional<BoardProtocol> protocol;  ///< while the port is open
  std::uint64_t n_openings = 0;
  std::uint64_t n_refused = 0;  ///< of the protocol, already reported
  bool is_writing = false;
  std::int64_t writing_since_ns = 0;
  std::string requests;
  std::array<std::uint8_t, 1024> bytes{};
};

using asio::ip::tcp;
using Endpoints = tcp::resolver::results_type;

/// Local networks answer in milliseconds; a host that is off never answers.
constexpr std::chrono::seconds connect_timeout{2};

/// TCP keep-alive: first probe after 2 s of silence, closed 3 s later.
void keep_alive(tcp::socket& socket)
{
  struct Option {
    int level, name, value;
  };
  for (const Option& option : {Option{IPPROTO_TCP, TCP_NODELAY, 1}, Option{SOL_SOCKET, SO_KEEPALIVE, 1},
                               Option{IPPROTO_TCP, TCP_KEEPIDLE, 2}, Option{IPPROTO_TCP, TCP_KEEPINTVL, 1},
                               Option{IPPROTO_TCP, TCP_KEEPCNT, 3}})
    setsockopt(socket.native_handle(), option.level, option.name, &option.value, sizeof option.value);
}

/// A program whose standard output is one end of a socket pair. The destructor ends and reaps it; it holds
/// nothing that must be saved.
class ChildProgram {
 public:
  /// `socket()` is -1 if it cannot be started; `error()` is then errno.
  explicit ChildProgram(const std::vector<std::string>& command)
  {
    std::array<int, 2> ends{-1, -1};
    if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) {
      error_ = errno;
      return;
    }
    // Beside this program if it is there.
    const std::string beside = std::filesystem::path(own_program()).parent_path() / command.front();
    std::vector<std::string> words = command;
    if (access(beside.c_str(), X_OK) == 0) words.front() = beside;
    const StartedProcess started = start_process(words, {.out = ends[1]});
    pid_ = started.pid;
    error_ = started.error;
    ::close(ends[1]);
    if (error_ == 0) {
      socket_ = ends[0];
    } else {
      ::close(ends[0]);
    }
  }
  ~ChildProgram()
  {
    if (pid_ < 0) return;
    kill(pid_, SIGKILL);
    wait_for_process(pid_);
  }
  ChildProgram(const ChildProgram&) = delete;
  ChildProgram& operator=(const ChildProgram&) = delete;

  int socket() const { return socket_; }
  int error() const { return error_; }

 private:
  pid_t pid_ = -1;
  int socket_ = -1, error_ = 0;
};

/// TCP self-connect: a socket that connects to an unused local port can get that port as its own.
bool is_self(const tcp::socket& socket)
{
  error_code ignored;
  return socket.local_endpoint(ignored) == socket.remote_endpoint(ignored);
}

/// Connection to a tracker. A corrupt stream, an error or a dead peer (TCP keep-alive, 5 s) closes it; it
/// is reopened with back-off, which the first complete message resets.
struct TrackerClient {
  TrackerClient(asio::io_context& io, const TrackerSettings& settings_, DeviceOutput& outlet_)
      : settings(settings_),
        outlet(outlet_),
        socket(io),
        connecting(io),
        resolver(io),
        timer(io),
        watch(io),
        protocol(settings_, outlet_.clock().now_ns()),
        backoff(settings_.retry_ms)
  {
    open();
    watch_tools();
  }

  void open()
  {
    if (settings.program.empty()) {
      resolve();
    } else {
      start_program();
    }
  }

  void start_program()
  {
    outlet.set_link(LinkState::opening, "");
    child.emplace(settings.program);
    if (child->socket() < 0)
      return reconnect(settings.program.front() + ": " + std::strerror(child->error()));
    error_code error;
    socket.assign(asio::generic::stream_protocol(AF_UNIX, 0), child->socket(), error);
    if (error) return reconnect(error.message());
    begin_reading();
  }

  void begin_reading()
  {
    stream = IgtlStream();
    protocol.begin_connection();
    is_reading = true;
    has_received = false;
    said.clear();
    // A program is up once it has sent something: a missing camera ends it before.
    if (!child) outlet.set_link(LinkState::up, "");
    read();
  }

  void resolve()
  {
    outlet.set_link(LinkState::opening, "");
    is_connecting = true;
    timer.expires_after(connect_timeout);
    timer.async_wait([this](const error_code& error) {
      if (error || !is_connecting) return;
      resolver.cancel();
      close();
    });
    // A numeric address needs no resolver, which would start a thread.
    error_code is_name;
    const asio::ip::address address = asio::ip::make_address(settings.host, is_name);
    const std::string port = std::to_string(settings.port);
    if (!is_name)
      return connect(Endpoints::create(tcp::endpoint(address, settings.port), settings.host, port));
    resolver.async_resolve(settings.host, port, [this](const error_code& error, const Endpoints& endpoints) {
      if (error)
        return reconnect(error == asio::error::operation_aborted ? "no address within 2 s" : error.message());
      connect(endpoints);
    });
  }

  void connect(const Endpoints& endpoints)
  {
    asio::async_connect(connecting, endpoints, [this](const error_code& error, const tcp::endpoint&) {
      if (error == asio::error::operation_aborted || (!error && !connecting.is_open()))
        return reconnect("no connection within 2 s");
      if (error || is_self(connecting)) return reconnect(error ? error.message() : "Connection refused");
      is_connecting = false;
      timer.cancel();
      keep_alive(connecting);
      socket = std::move(connecting);
      connecting = tcp::socket(socket.get_executor());
      begin_reading();
      ask();
    });
  }

  /// A STATUS of header version 2 first. PlusServer answers each client in the highest header version that
  /// the client has sent, version 1 until then (PlusLib, src/PlusServer/vtkPlusOpenIGTLinkServer.cxx,
  /// DataReceiverThread: SetClientHeaderVersion), and only version 2 states which tools are hidden. A STATUS
  /// has no other effect there ("used as a keep-alive"), nor has it in OpenIGTLink.
  void ask()
  {
    request.clear();
    const auto add = [this](const IgtlMessage& message) {
      const std::vector<std::uint8_t> more = bytes_of(message);
      request.insert(request.end(), more.begin(), more.end());
    };
    IgtlMessage message;
    message.kind = IgtlKind::status;
    message.header_version = 2;
    message.device = "vrda-player";
    if (asks_for_version_2) add(message);
    message = {};
    message.kind = IgtlKind::start_tdata;
    message.interval_ms = std::max(1, static_cast<int>(std::lround(settings.tdata_interval_ms)));
    if (settings.tdata_interval_ms > 0.0) add(message);
    // A failed write also shows up as a read error.
    if (!request.empty())
      asio::async_write(socket, asio::buffer(request), [](const error_code&, std::size_t) {});
  }

  void read()
  {
    socket.async_read_some(asio::buffer(bytes), [this](const error_code& error, std::size_t n) {
      const std::int64_t now_ns = outlet.clock().now_ns();
      if (error) return reconnect(end_text(error));
      stream.add(std::span(bytes).first(n));
      while (const std::optional<IgtlMessage> message = stream.next()) take(*message, now_ns);
      outlet.count_rejected(stream.n_malformed() - n_malformed,
                            "found a message of the wrong size for its type");
      n_malformed = stream.n_malformed();
      set_notes();
      if (!stream.is_broken()) return read();
      outlet.count_rejected(1, stream.error_message());
      reconnect(stream.error_message());
    });
  }

  void set_notes()
  {
    std::vector<std::string> notes = protocol.notes();
    if (stream.n_unchecked() > 0)
      notes.emplace_back("messages have the checksum 0: damaged ones are not recognised");
    outlet.set_notes(std::move(notes));
  }

  /// What a program said last explains its end.
  std::string end_text(const error_code& error) const
  {
    if (child && !said.empty()) return said;
    return error == asio::error::eof ? "closed by the peer" : error.message();
  }

  void take(const IgtlMessage& message, std::int64_t now_ns)
  {
    has_received = true;
    said = child && message.kind == IgtlKind::status ? message.text : error_text_of(message);
    if (child && said.empty() && !is_child_up) {
      is_child_up = true;
      outlet.set_link(LinkState::up, "");
    }
    // A program that reports an error is started again with growing pauses.
    if (!child || said.empty()) backoff.reset();
    outlet.put(protocol.receive(message, now_ns));
    if (!said.empty()) outlet.set_error_message(said);
  }

  void close()
  {
    error_code ignored;
    socket.close(ignored);
    connecting.close(ignored);
    child.reset();
    is_child_up = false;
  }

  void reconnect(const std::string& error_message)
  {
    is_connecting = false;
    // A server that ends the connection without a message may not know version 2: the next connection sends
    // no request.
    if (std::exchange(is_reading, false)) asks_for_version_2 = has_received || !asks_for_version_2;
    n_malformed = 0;
    const std::string why = error_message;  // close() may end its owner
    close();
    outlet.set_link(LinkState::closed, why);
    backoff.wait(timer, [this] { open(); });
  }

  /// Checks four times per `stale_after_ms`, so a stale tool is reported at most a quarter late.
  void watch_tools()
  {
    watch.expires_after(of_ms(std::max(settings.stale_after_ms / 4.0, 1.0)));
    watch.async_wait([this](const error_code& error) {
      if (error) return;
      outlet.put(protocol.stale_samples(outlet.clock().now_ns()));
      watch_tools();
    });
  }

  const TrackerSettings settings;
  DeviceOutput& outlet;
  asio::generic::stream_protocol::socket socket;  ///< of the server or the program
  tcp::socket connecting;
  std::optional<ChildProgram> child;
  bool is_child_up = false;
  std::string said;  ///< error of the last message
  tcp::resolver resolver;
  asio::steady_timer timer;  ///< of the connect timeout, or of the back-off
  asio::steady_timer watch;
  bool is_connecting = false;
  bool is_reading = false, has_received = false;  ///< connected; a message came since
  bool asks_for_version_2 = true;
  TrackerProtocol protocol;
  Backoff backoff;
  IgtlStream stream;
  std::uint64_t n_malformed = 0;  ///< of the stream, already reported
  std::vector<std::uint8_t> request;
  std::array<std::uint8_t, 16384> bytes{};
};

std::string peer_of(const TrackerSettings& settings)
{
  if (!settings.program.empty()) return settings.program.front();
  const bool is_ipv6 = settings.host.find(':') != std::string::npos;
  return (is_ipv6 ? "[" + settings.host + "]" : settings.host) + ":" + std::to_string(settings.port);
}

}  // namespace

struct Devices::State {
  State(const std::optional<TrackerSettings>& tracker_, const std::optional<BoardSettings>& board_)
      : tracker_outlet(DeviceId::tracker, tracker_ ? peer_of(*tracker_) : "", queue, clock),
        board_outlet(DeviceId::board, board_ ? board_->port : "", queue, clock)
  {
    if (tracker_) tracker.emplace(io, *tracker_, tracker_outlet);
    if (board_) board.emplace(io, *board_, board_outlet);
    has_stage = board_ && board_->has_stage;
    thread = std::thread([this] { io.run(); });
  }

  ~State()
  {
    io.stop();
    thread.join();
  }

  ArrivalClock clock;
  SampleQueue queue;
  DeviceOutput tracker_outlet, board_outlet;
  boost::asio::io_context io{1};  // outlives the clients, whose handlers it holds
  std::optional<TrackerClient> tracker;
  std::optional<BoardClient> board;
  bool has_stage = false;
  std::thread thread;
};

Devices::Devices(const std::optional<TrackerSettings>& tracker_settings,
                 const std::optional<BoardSettings>& board_settings)
    : state_(std::make_unique<State>(tracker_settings, board_settings))
{
}

Devices::~Devices() = default;

bool Devices::take(Sample& sample)
{
  return state_->queue.take(sample);
}

std::int64_t Devices::now_ns() const
{
  return state_->clock.now_ns();
}

bool Devices::zero_stage()
{
  if (!state_->has_stage || state_->board_outlet.report().link != LinkState::up) return false;
  state_->board->zero_stage();
  return true;
}

DeviceReport Devices::report(DeviceId device) const
{
  return device == DeviceId::tracker ? state_->tracker_outlet.report() : state_->board_outlet.report();
}

}  // namespace vrda::bench
