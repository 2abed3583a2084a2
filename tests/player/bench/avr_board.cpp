#include "player/bench/avr_board.hpp"

#include <fcntl.h>
#include <simavr/avr_adc.h>
#include <simavr/avr_ioport.h>
#include <simavr/avr_uart.h>
#include <simavr/sim_avr.h>
#include <simavr/sim_elf.h>
#include <stdlib.h>
#include <termios.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <deque>
#include <filesystem>
#include <mutex>
#include <thread>

#include "core/text.hpp"

namespace vrda::test {
namespace {

constexpr std::uint32_t frequency_hz = 16'000'000;
constexpr std::uint32_t full_scale_mv = 5000, full_scale_counts = 1023;
/// Simulated between two looks at terminal and knob: 1 ms.
constexpr std::uint64_t slice_cycles = frequency_hz / 1000;

}  // namespace

struct AvrBoard::State {
  explicit State(const AvrBoardOptions& given) : options(given)
  {
    elf_firmware_t firmware{};
    check(elf_read_firmware(VRDA_AVR_FIRMWARE, &firmware) == 0, "the firmware's ELF file is there");
    avr = avr_make_mcu_by_name("atmega328p");
    check(avr != nullptr, "simavr knows the micro-controller");
    avr_init(avr);
    avr->frequency = frequency_hz;
    avr->log = LOG_ERROR;
    avr->vcc = avr->avcc = avr->aref = full_scale_mv;
    avr_load_firmware(avr, &firmware);
    std::uint32_t flags = 0;
    avr_ioctl(avr, AVR_IOCTL_UART_GET_FLAGS('0'), &flags);
    flags &= ~static_cast<std::uint32_t>(AVR_UART_FLAG_STDIO | AVR_UART_FLAG_POLL_SLEEP);
    avr_ioctl(avr, AVR_IOCTL_UART_SET_FLAGS('0'), &flags);
    to_uart = avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_INPUT);
    const auto listen = [this](int irq, avr_irq_notify_t call) {
      avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), irq), call, this);
    };
    listen(UART_IRQ_OUTPUT, [](avr_irq_t*, std::uint32_t byte, void* self) { of(self).sent_byte(byte); });
    listen(UART_IRQ_OUT_XON, [](avr_irq_t*, std::uint32_t, void* self) { of(self).has_room = true; });
    listen(UART_IRQ_OUT_XOFF, [](avr_irq_t*, std::uint32_t, void* self) { of(self).has_room = false; });
    signal_a = avr_io_getirq(avr, AVR_IOCTL_IOPORT_GETIRQ('D'), 3);
    signal_b = avr_io_getirq(avr, AVR_IOCTL_IOPORT_GETIRQ('D'), 2);
    knob = avr_io_getirq(avr, AVR_IOCTL_ADC_GETIRQ, ADC_IRQ_ADC0);
    open_terminal();
    count = options.signals.stage_count();
    start_over();
    thread = std::thread([this] { run(); });
  }

  ~State()
  {
    is_ending = true;
    thread.join();
    if (!options.signals.link.empty()) std::filesystem::remove(options.signals.link);
    ::close(far_end);
    ::close(terminal);
    avr_terminate(avr);
  }

  static State& of(void* self) { return *static_cast<State*>(self); }

  void open_terminal()
  {
    terminal = posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    char name[128] = "";
    check(terminal >= 0 && grantpt(terminal) == 0 && unlockpt(terminal) == 0 &&
              ptsname_r(terminal, name, sizeof name) == 0,
          "a pseudo-terminal");
    far_end = open(name, O_RDWR | O_NOCTTY | O_CLOEXEC);
    termios settings{};
    check(far_end >= 0 && tcgetattr(far_end, &settings) == 0, "a terminal");
    cfmakeraw(&settings);
    tcsetattr(far_end, TCSANOW, &settings);
    path = name;
    const std::string& link = options.signals.link;
    if (!link.empty()) {
      std::filesystem::remove(link);
      std::filesystem::create_symlink(name, link);
    }
  }

  /// Resets the micro-controller, whose pins keep their levels.
  void start_over()
  {
    avr_reset(avr);
    waiting.clear();
    frame.clear();
    has_room = true;
    // simavr passes changes only, and a reset clears the pins.
    avr_raise_irq(signal_a, 1 - level_a());
    avr_raise_irq(signal_b, 1 - level_b());
    // simavr pulls an input up when the firmware enables its pull-up, unless it is pulled from outside.
    avr_ioport_external_t pulled{};
    pulled.name = 'D';
    pulled.mask = 0x0C;
    pulled.value = (level_a() << 3 | level_b() << 2) & 0x0F;
    avr_ioctl(avr, AVR_IOCTL_IOPORT_SET_EXTERNAL('D'), &pulled);
    set_signals();
    avr_cycle_timer_register(avr, period(), step, this);
  }

  /// Two square signals: 00, 10, 11, 01, cyclic.
  std::uint32_t level_a() const { return ((count + 1) & 2) != 0 ? 1 : 0; }
  std::uint32_t level_b() const { return (count & 2) != 0 ? 1 : 0; }

  void set_signals()
  {
    avr_raise_irq(signal_a, level_a());
    avr_raise_irq(signal_b, level_b());
  }

  std::uint64_t period() const { return frequency_hz / static_cast<std::uint64_t>(options.counts_a_second); }

  static avr_cycle_count_t step(avr_t*, avr_cycle_count_t when, void* self)
  {
    State& board = of(self);
    const int target = board.target;
    if (board.count != target) {
      board.count += target > board.count ? 1 : -1;
      board.set_signals();
    }
    return when + board.period();
  }

  /// Passes whole frames to the terminal, as the simulated board does.
  void sent_byte(std::uint32_t byte)
  {
    constexpr std::size_t header = 4, checksum = 2;
    frame.push_back(static_cast<std::uint8_t>(byte));
    if (frame.size() < header || frame.size() < header + frame[3] + checksum) return;
    if (options.signals.corrupt) options.signals.corrupt(frame);
    [[maybe_unused]] const ssize_t n = ::write(terminal, frame.data(), frame.size());
    frame.clear();
  }

  void take_bytes()
  {
    std::uint8_t bytes[64];
    const ssize_t n = ::read(terminal, bytes, sizeof bytes);
    if (n > 0) waiting.insert(waiting.end(), bytes, bytes + n);
    for (; has_room && !waiting.empty(); waiting.pop_front()) avr_raise_irq(to_uart, waiting.front());
  }

  void run_slice()
  {
    const std::scoped_lock lock(mutex);
    take_bytes();
    target = options.signals.stage_count() + offset;
    // Rounded up: the converter rounds down.
    const auto counts = static_cast<std::uint32_t>(options.signals.potentiometer());
    avr_raise_irq(knob, (counts * full_scale_mv + full_scale_counts - 1) / full_scale_counts);
    const avr_cycle_count_t end = avr->cycle + slice_cycles;
    int state = cpu_Running;
    while (avr->cycle < end && state != cpu_Done && state != cpu_Crashed) state = avr_run(avr);
    check(state != cpu_Done && state != cpu_Crashed, "the firmware runs");
    ++n_slices;
  }

  void run()
  {
    using namespace std::chrono;
    auto next = steady_clock::now();
    while (!is_ending) {
      run_slice();
      next = std::max(next + milliseconds(1), steady_clock::now() - milliseconds(10));
      if (options.is_paced) std::this_thread::sleep_until(next);
    }
  }

  const AvrBoardOptions options;
  mutable std::mutex mutex;  ///< protects terminal and micro-controller
  avr_t* avr = nullptr;
  avr_irq_t *to_uart = nullptr, *signal_a = nullptr, *signal_b = nullptr, *knob = nullptr;
  int terminal = -1, far_end = -1;
  std::string path;
  int count = 0, target = 0, offset = 0;  ///< offset: of states that were skipped
  bool has_room = true;
  std::deque<std::uint8_t> waiting;
  std::vector<std::uint8_t> frame;
  std::atomic<std::uint64_t> n_slices{0};
  std::atomic<bool> is_ending{false};
  std::thread thread;
};

AvrBoard::AvrBoard(const AvrBoardOptions& options) : state_(std::make_unique<State>(options)) {}

AvrBoard::~AvrBoard() = default;

std::string AvrBoard::path() const
{
  return state_->options.signals.link.empty() ? state_->path : state_->options.signals.link;
}

void AvrBoard::reset()
{
  const std::scoped_lock lock(state_->mutex);
  state_->start_over();
}

void AvrBoard::skip_state()
{
  const std::scoped_lock lock(state_->mutex);
  state_->count += 2;
  state_->offset += 2;
  state_->set_signals();
}

double AvrBoard::simulated_s() const
{
  return static_cast<double>(state_->n_slices) * 1e-3;
}

}  // namespace vrda::test
