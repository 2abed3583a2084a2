#include "loop/loop.hpp"

#include <algorithm>
#include <cstdint>

namespace vrda::loop {

StopSignals::StopSignals()
{
  sigemptyset(&signals_);
  sigaddset(&signals_, SIGINT);
  sigaddset(&signals_, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &signals_, &before_);
}

// Consumes pending signals, so that unblocking them does not end the program.
StopSignals::~StopSignals()
{
  const timespec none{};
  while (sigtimedwait(&signals_, nullptr, &none) > 0) {
  }
  pthread_sigmask(SIG_SETMASK, &before_, nullptr);
}

bool StopSignals::wait_until(std::chrono::steady_clock::time_point due)
{
  if (has_come_) return true;
  const std::chrono::nanoseconds left = due - std::chrono::steady_clock::now();
  const std::int64_t ns = std::max<std::int64_t>(0, left.count());
  const timespec wait{ns / 1'000'000'000, ns % 1'000'000'000};
  has_come_ = sigtimedwait(&signals_, nullptr, &wait) > 0;
  return has_come_;
}

navigation::Key key_of_window(int key, bool has_shift)
{
  constexpr int keypad_minus = 333, keypad_plus = 334, last_f = render::key_f1 + 5, f11 = render::key_f1 + 10;
  if (key >= render::key_f1 && key <= last_f)
    return static_cast<navigation::Key>(static_cast<int>(navigation::Key::f1) + key - render::key_f1);
  switch (key) {
    case render::key_escape:
      return navigation::Key::escape;
    case render::key_enter:
    case render::key_keypad_enter:
      return navigation::Key::enter;
    case render::key_backspace:
      return navigation::Key::backspace;
    case render::key_up:
      return navigation::Key::up;
    case render::key_down:
      return navigation::Key::down;
    case render::key_left:
      return navigation::Key::left;
    case render::key_right:
      return navigation::Key::right;
    case render::key_page_up:
      return navigation::Key::page_up;
    case render::key_page_down:
      return navigation::Key::page_down;
    case render::key_home:
      return navigation::Key::home;
    case render::key_end:
      return navigation::Key::end;
    case f11:
      return navigation::Key::f11;
    case keypad_minus:
      return navigation::key_of('-');
    case keypad_plus:
      return navigation::key_of('+');
    case '/':
      return navigation::key_of(has_shift ? '?' : '/');
    default:
      return key > ' ' - 1 && key < 127 ? static_cast<navigation::Key>(key) : navigation::Key::none;
  }
}

std::optional<navigation::KeyPress> key_press_of(const render::InputEvent& event)
{
  if (event.kind != render::InputKind::key_press) return std::nullopt;
  const navigation::Key key = key_of_window(event.key, event.has_shift);
  if (key == navigation::Key::none) return std::nullopt;
  return navigation::KeyPress{key, event.has_shift, event.has_control};
}

navigation::Button button_of(render::MouseButton button)
{
  switch (button) {
    case render::MouseButton::left:
      return navigation::Button::left;
    case render::MouseButton::middle:
      return navigation::Button::middle;
    case render::MouseButton::right:
      return navigation::Button::right;
  }
  return navigation::Button::left;
}

namespace {

using Clock = std::chrono::steady_clock;

constexpr double longest_s = 10.0;  // limits the elapsed time after the machine was suspended

Clock::duration duration_of(double s)
{
  return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(s));
}

/// Timing of rounds.
class Rounds {
 public:
  /// Waits for the next round and passes the events to the mode; returns false after a stop signal.
  bool next(Mode& mode, Sink& sink, StopSignals& stop)
  {
    const RoundTime time = mode.round_time();
    const bool is_by_input = time.is_ended_by_input && sink.window() != nullptr;
    const Clock::duration period = duration_of(time.s);
    due_ += period;
    if (due_ + period < Clock::now()) due_ = Clock::now();
    if (stop.wait_until(is_by_input ? Clock::now() : due_)) return false;
    const std::chrono::duration<double> left = due_ - Clock::now();
    for (const render::InputEvent& event : sink.events(is_by_input ? std::max(0.0, left.count()) : 0.0))
      mode.take(event);
    if (is_by_input) due_ = Clock::now();
    return true;
  }
  /// Time since the previous round.
  double elapsed_s()
  {
    const std::chrono::duration<double> elapsed = Clock::now() - began_;
    began_ = Clock::now();
    return std::min(elapsed.count(), longest_s);
  }

 private:
  Clock::time_point began_ = Clock::now(), due_ = began_;
};

}  // namespace

void run_loop(Mode& mode, Sink& sink, StopSignals& stop)
{
  Rounds rounds;
  while (!mode.is_over() && !sink.is_closed() && rounds.next(mode, sink, stop)) {
    mode.advance(rounds.elapsed_s());
    mode.draw();
  }
}

std::optional<InputError> catch_input_error(const std::function<void()>& work)
{
  try {
    work();
    return std::nullopt;
  } catch (const InputError& error) {
    return error;
  }
}

}  // namespace vrda::loop
