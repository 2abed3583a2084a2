#include "bench/pty_board.hpp"

#include <fcntl.h>
#include <poll.h>
#include <stdlib.h>
#include <sys/eventfd.h>
#include <sys/file.h>
#include <termios.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <mutex>
#include <thread>

#include "core/error.hpp"

extern "C" {
#include "bench/board.h"
#include "bench/quadrature.h"
}

namespace vrda::bench {
namespace {

/// Poll period of the encoder: the stage cannot be moved by the counter's range of 16 cm in that time.
constexpr int poll_ms = 5;

/// Closes its descriptor.
class Handle {
 public:
  explicit Handle(int number = -1) : number_(number) {}
  ~Handle() { close(); }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  int number() const { return number_; }
  void reset(int number)
  {
    close();
    number_ = number;
  }
  void close()
  {
    if (number_ >= 0) ::close(number_);
    number_ = -1;
  }

 private:
  int number_;
};

InputError terminal_error(const std::string& field, const std::string& wanted)
{
  return InputError({"simulated board", field, std::strerror(errno), wanted});
}

/// Whether a running board holds the terminal: it keeps it locked, and a killed one's number may be
/// another's.
bool is_held(const std::string& terminal)
{
  const Handle there(open(terminal.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  return there.number() >= 0 && flock(there.number(), LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
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

}  // namespace

struct PtyBoard::State {
  explicit State(const PtyBoardOptions& options_)
      : options(options_), wake(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK))
  {
    check(options.potentiometer && options.stage_count,
          "PtyBoardOptions: potentiometer and stage_count are required");
    plug();
    thread = std::thread([this] { run(); });
  }

  ~State()
  {
    is_ending = true;
    wake_up();
    thread.join();
    unplug();
  }

  void wake_up()
  {
    const std::uint64_t one = 1;
    [[maybe_unused]] const ssize_t n = ::write(wake.number(), &one, sizeof one);
  }

  void plug()
  {
    const std::scoped_lock lock(mutex);
    terminal.reset(posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
    char name[128] = "";
    if (terminal.number() < 0 || grantpt(terminal.number()) != 0 || unlockpt(terminal.number()) != 0 ||
        ptsname_r(terminal.number(), name, sizeof name) != 0)
      throw terminal_error("terminal", "a pseudo-terminal of this machine");
    // Kept open, so that a client closing it causes no hang-up; raw mode from the first byte.
    far_end.reset(open(name, O_RDWR | O_NOCTTY | O_CLOEXEC));
    termios settings{};
    if (far_end.number() < 0 || tcgetattr(far_end.number(), &settings) != 0)
      throw terminal_error(name, "a pseudo-terminal");
    if (flock(far_end.number(), LOCK_EX | LOCK_NB) != 0) throw terminal_error(name, "a terminal of its own");
    cfmakeraw(&settings);
    tcsetattr(far_end.number(), TCSANOW, &settings);
    path = name;
    if (!options.link.empty()) make_link(options.link, name);
    count = options.stage_count();
    quadrature_start(&signals, signal_a(), signal_b());
    board_start(&firmware, &hardware);
    wake_up();
  }

  void unplug()
  {
    const std::scoped_lock lock(mutex);
    if (terminal.number() < 0) return;
    // The user may have replaced the link. While the terminal is open, its name is no other's.
    std::error_code ignored;
    if (!options.link.empty() && std::filesystem::read_symlink(options.link, ignored) == path)
      std::filesystem::remove(options.link, ignored);
    far_end.close();
    terminal.close();
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
      pollfd waiting[2] = {{wake.number(), POLLIN, 0}, {-1, POLLIN, 0}};
      {
        const std::scoped_lock lock(mutex);
        waiting[1].fd = terminal.number();  // poll() ignores negative descriptors
        if (terminal.number() >= 0) {
          move_stage();
          board_loop(&firmware);
        }
      }
      poll(waiting, 2, poll_ms);
      std::uint64_t ignored = 0;
      [[maybe_unused]] const ssize_t n = ::read(wake.number(), &ignored, sizeof ignored);
    }
  }

  /// Bytes that the terminal does not accept are lost, as on a real serial line.
  void send(std::vector<std::uint8_t> bytes) const
  {
    if (options.corrupt) options.corrupt(bytes);
    if (terminal.number() < 0) return;
    [[maybe_unused]] const ssize_t n = ::write(terminal.number(), bytes.data(), bytes.size());
  }

  static State& of(void* self) { return *static_cast<State*>(self); }

  static int receive(void* self)
  {
    std::uint8_t byte = 0;
    return ::read(of(self).terminal.number(), &byte, 1) == 1 ? byte : -1;
  }

  const PtyBoardOptions options;
  std::mutex mutex;  ///< protects the terminal and the firmware
  Handle wake, terminal, far_end;
  std::string path;
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
  const std::scoped_lock lock(state_->mutex);
  return state_->options.link.empty() ? state_->path : state_->options.link;
}

void PtyBoard::unplug()
{
  state_->unplug();
}

void PtyBoard::plug()
{
  state_->unplug();
  state_->plug();
}

void PtyBoard::send_unrequested(const std::vector<std::uint8_t>& bytes)
{
  const std::scoped_lock lock(state_->mutex);
  state_->send(bytes);
}

}  // namespace vrda::bench
