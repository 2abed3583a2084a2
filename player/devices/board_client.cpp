#include "devices/board_client.hpp"

#include <termios.h>

#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/serial_port.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/write.hpp>

#include "devices/backoff.hpp"
#include "devices/board_talk.hpp"

namespace vrda {
namespace {

namespace asio = boost::asio;
using boost::system::error_code;

/// A line that takes not one request for so long is stuck.
constexpr std::int64_t longest_writing_ns = 1'000'000'000;

}  // namespace

struct BoardClient::State {
  State(asio::io_context& io_, const BoardSettings& settings_, Outlet& outlet_)
      : io(io_), settings(settings_), outlet(outlet_), port(io_), timer(io_), backoff(settings_.retry_ms)
  {
  }

  // Closing a line waits for what was not sent.
  ~State()
  {
    if (port.is_open()) tcflush(port.native_handle(), TCIOFLUSH);
  }

  void open()
  {
    outlet.set_link(LinkState::opening, "");
    error_code error;
    port.open(settings.port, error);
    if (!error) port.set_option(asio::serial_port::baud_rate(static_cast<unsigned>(settings.baud)), error);
    if (error) return lose(error.message());
    // What an earlier opening asked for is no answer.
    tcflush(port.native_handle(), TCIOFLUSH);
    ++n_openings;
    is_writing = false;
    n_refused = 0;
    talk.emplace(settings, outlet.clock().now_ns());
    read();
    speak();
  }

  void read()
  {
    port.async_read_some(
        asio::buffer(bytes), [this, opening = n_openings](const error_code& error, std::size_t n) {
          const std::int64_t now_ns = outlet.clock().now_ns();
          if (opening != n_openings) return;
          if (error) return lose(error == asio::error::eof ? "the line has gone" : error.message());
          const bool was_up = talk->phase() == BoardTalk::Phase::up;
          const std::vector<Sample> samples = talk->hear(std::span(bytes).first(n), now_ns);
          if (!was_up && talk->phase() == BoardTalk::Phase::up) {
            backoff.reset();
            outlet.set_link(LinkState::up, "");
          }
          outlet.put(samples);
          outlet.refuse(talk->n_refused() - n_refused, "found noise, wanted frames of the serial protocol");
          n_refused = talk->n_refused();
          if (speak()) read();
        });
  }

  /// Sends what is due, comes again when more is; false where the line was given up.
  bool speak()
  {
    const std::int64_t now_ns = outlet.clock().now_ns();
    if (!is_writing) {
      requests = talk->due(now_ns);
      if (!requests.empty()) write(now_ns);
    } else if (now_ns - writing_since_ns >= longest_writing_ns) {
      lose("the line takes nothing");
      return false;
    }
    if (talk->phase() == BoardTalk::Phase::given_up) {
      const std::string trouble = talk->trouble();  // the talk ends here
      lose(trouble);
      return false;
    }
    timer.expires_at(
        outlet.clock().time_of(is_writing ? writing_since_ns + longest_writing_ns : talk->next_due_ns()));
    timer.async_wait([this, opening = n_openings](const error_code& error) {
      if (!error && opening == n_openings) speak();
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
                        if (error) return lose(error.message());
                        speak();
                      });
  }

  void lose(const std::string& trouble)
  {
    ++n_openings;  // what is on its way belongs to the past
    talk.reset();
    error_code ignored;
    if (port.is_open()) tcflush(port.native_handle(), TCIOFLUSH);
    port.close(ignored);
    outlet.set_link(LinkState::closed, trouble);
    timer.expires_after(std::chrono::duration_cast<asio::steady_timer::duration>(
        std::chrono::duration<double, std::milli>(backoff.next_ms())));
    timer.async_wait([this](const error_code& error) {
      if (!error) open();
    });
  }

  void zero_stage()
  {
    if (!talk || talk->phase() != BoardTalk::Phase::up)
      return outlet.note("the stage was not set to zero: the board is not up");
    talk->zero_stage();
    speak();
  }

  asio::io_context& io;
  const BoardSettings settings;
  Outlet& outlet;
  asio::serial_port port;
  asio::steady_timer timer;  ///< of what is due, or of the pause
  Backoff backoff;
  std::optional<BoardTalk> talk;  ///< while the line is open
  std::uint64_t n_openings = 0;
  std::uint64_t n_refused = 0;  ///< of the talk, told already
  bool is_writing = false;
  std::int64_t writing_since_ns = 0;
  std::string requests;
  std::array<std::uint8_t, 1024> bytes{};
};

BoardClient::BoardClient(asio::io_context& io, const BoardSettings& settings, Outlet& outlet)
    : state_(std::make_unique<State>(io, settings, outlet))
{
  state_->open();
}

BoardClient::~BoardClient() = default;

void BoardClient::zero_stage()
{
  asio::post(state_->io, [state = state_.get()] { state->zero_stage(); });
}

}  // namespace vrda
