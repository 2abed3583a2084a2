#include "show/loop.hpp"

#include <algorithm>
#include <cstdint>

#include "core/console.hpp"

namespace vrda::show {

StopSignals::StopSignals()
{
  sigemptyset(&signals_);
  for (const int signal : stop_signals()) sigaddset(&signals_, signal);
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

std::optional<view::KeyPress> key_press_of(const view::InputEvent& event)
{
  if (event.kind != view::InputKind::key_press || event.key == view::Key::none) return std::nullopt;
  const bool is_question = event.key == view::key_of('/') && event.has_shift;
  return view::KeyPress{is_question ? view::key_of('?') : event.key, event.has_shift, event.has_control};
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
    for (const view::InputEvent& event : sink.events(is_by_input ? std::max(0.0, left.count()) : 0.0))
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

}  // namespace vrda::show
