#include "loop/loop.hpp"

#include <algorithm>

namespace vrda {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double longest_s = 10.0;  // a machine that slept is not time that was seen

Clock::duration duration_of(double s)
{
  return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(s));
}

/// When rounds begin.
class Rounds {
 public:
  /// Waits for the next round, and takes what happened until then; false: a signal came.
  bool next(Mode& mode, Sink& sink, StopSignals& stop)
  {
    const RoundTime time = mode.round_time();
    const bool is_by_input = time.is_ended_by_input && sink.window() != nullptr;
    const Clock::duration period = duration_of(time.s);
    due_ += period;
    if (due_ + period < Clock::now()) due_ = Clock::now();
    if (stop.came_by(is_by_input ? Clock::now() : due_)) return false;
    const std::chrono::duration<double> left = due_ - Clock::now();
    for (const InputEvent& event : sink.events(is_by_input ? std::max(0.0, left.count()) : 0.0))
      mode.take(event);
    if (is_by_input) due_ = Clock::now();
    return true;
  }
  /// Since the round before.
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

std::optional<InputError> attempt(const std::function<void()>& work)
{
  try {
    work();
    return std::nullopt;
  } catch (const InputError& error) {
    return error;
  }
}

}  // namespace vrda
