// Replay of a bench recording.

#include <algorithm>
#include <cmath>
#include <optional>
#include <ostream>
#include <utility>

#include "bench/bench_show.hpp"
#include "bench/recorded_motion.hpp"
#include "core/error.hpp"
#include "core/units.hpp"
#include "loop/loop.hpp"
#include "settings/settings_text.hpp"

namespace vrda::bench {
namespace {

constexpr double slowest = 0.05, fastest = 100.0;
constexpr double leap_s = 5.0;

/// Seconds since the first picture.
double seconds_of(const std::vector<recording::RecordedFrame>& pictures, std::size_t n)
{
  return static_cast<double>(pictures[n].now_ns - pictures.front().now_ns) * s_per_ns;
}

/// State at any picture of a recording. Seeking backwards replays from the start, because the state depends
/// on all earlier input.
class ReplayState {
 public:
  ReplayState(const BenchSetup& setup, const recording::Recording& recording)
      : setup_(setup), recording_(recording)
  {
    begin();
  }
  /// Frame of picture `n`.
  const BenchFrame& at(std::size_t n)
  {
    if (n + 1 < n_taken_) begin();
    while (n_taken_ <= n) {
      const recording::RecordedFrame& picture = recording_.frames[n_taken_++];
      PanelContent unused;
      apply_input(*state_, unused, picture.keys, picture.samples);
      frame_ = &state_->frame(picture.now_ns);
    }
    return *frame_;
  }
  BenchState& state() { return *state_; }

 private:
  void begin()
  {
    state_.emplace(setup_.bench, setup_.calibration, setup_.motion, setup_.frame);
    n_taken_ = 0;
  }

  const BenchSetup& setup_;
  const recording::Recording& recording_;
  std::optional<BenchState> state_;
  const BenchFrame* frame_ = nullptr;
  std::size_t n_taken_ = 0;
};

/// Plays a recording. Its time continues from the next picture.
class Replay final : public loop::Mode {
 public:
  Replay(const BenchOptions& options, const BenchSetup& setup, const recording::Recording& recording)
      : options_(options),
        pictures_(recording.frames),
        show_(options, setup),
        state_(setup, recording),
        speed_(options.speed.value_or(options.is_headless ? 0.0 : 1.0))
  {
    next_ = index_at(options.from_s);
    until_ = options.seconds ? index_at(options.from_s + *options.seconds) : pictures_.size();
    rebase();
  }

  loop::Sink& sink() { return show_.sink(); }
  std::size_t n_shown() const { return n_shown_; }
  void finish() { show_.finish(); }

  bool is_over() const override { return is_left_ || (options_.is_headless && is_resting()); }

  loop::RoundTime round_time() const override
  {
    constexpr double resting_s = 0.02;
    if (is_resting()) return {resting_s};
    return {speed_ > 0.0 ? std::max(0.0, (seconds_of(pictures_, next_) - at_s_) / speed_) : 0.0};
  }

  void take(const render::InputEvent& event) override
  {
    const std::optional<navigation::KeyPress> press = loop::key_press_of(event);
    if (!press) return;
    const navigation::Key key = press->key;
    if (key == navigation::Key::space) is_paused_ = !is_paused_;
    if (key == navigation::Key::left) leap(-leap_s);
    if (key == navigation::Key::right) leap(leap_s);
    if (key == navigation::key_of('+') || key == navigation::key_of('='))
      speed_ = std::min(fastest, 2.0 * speed_);
    if (key == navigation::key_of('-')) speed_ = std::max(slowest, 0.5 * speed_);
    if (key == navigation::key_of('T')) show_.panel().has_panel = !show_.panel().has_panel;
    is_left_ = is_left_ || key == navigation::Key::escape || key == navigation::key_of('Q');
  }

  void advance(double elapsed_s) override
  {
    if (!is_resting()) at_s_ += speed_ * elapsed_s;
  }

  void draw() override
  {
    if (is_resting()) {
      if (std::exchange(is_dirty_, false) && next_ > 0) draw(next_ - 1);
      return;
    }
    // Tolerance of a wait, which ends within a nanosecond.
    constexpr double rounding_s = 1e-6;
    if (speed_ > 0.0 && seconds_of(pictures_, next_) > at_s_ + rounding_s) return;
    draw(next_++);
    ++n_shown_;
  }

 private:
  bool is_resting() const { return is_paused_ || next_ >= until_; }
  std::size_t index_at(double s) const
  {
    std::size_t n = 0;
    while (n < pictures_.size() && seconds_of(pictures_, n) < s) ++n;
    return n;
  }
  void draw(std::size_t n)
  {
    show_.show(state_.state(), state_.at(n), n, seconds_of(pictures_, n) / options_.speed.value_or(1.0));
  }

  void rebase() { at_s_ = seconds_of(pictures_, std::min(next_, pictures_.size() - 1)); }
  void leap(double s)
  {
    const double from_s = seconds_of(pictures_, std::min(next_, pictures_.size() - 1));
    next_ = std::min(index_at(std::max(0.0, from_s + s)), pictures_.size() - 1);
    is_dirty_ = true;
    rebase();
  }

  const BenchOptions& options_;
  const std::vector<recording::RecordedFrame>& pictures_;
  BenchOutput show_;
  ReplayState state_;
  double speed_ = 1.0;  ///< 0: unpaced
  double at_s_ = 0.0;   ///< position in the recording
  std::size_t next_ = 0, until_ = 0, n_shown_ = 0;
  bool is_paused_ = false, is_left_ = false, is_dirty_ = false;
};

void require_from(const BenchOptions& options, const std::vector<recording::RecordedFrame>& pictures)
{
  const double last_s = seconds_of(pictures, pictures.size() - 1);
  if (options.from_s <= last_s) return;
  // Rounded down, so that the reported end is valid.
  constexpr double tenths = 10.0;
  throw InputError(
      {"--from", "", settings::rounded_text(options.from_s, 1),
       "a second of the recording, 0 to " + settings::rounded_text(std::floor(tenths * last_s) / tenths, 1)});
}

}  // namespace

void replay_bench(const BenchOptions& options, const loop::Streams& streams)
{
  if (options.speed && !(*options.speed >= slowest && *options.speed <= fastest))
    throw InputError({"--speed", "", std::to_string(*options.speed), "0.05 to 100"});
  const recording::Recording recording = recording::read_recording(options.replay);
  if (!recording.dropped_why.empty()) {
    streams.messages << "vrda-player: " << options.replay << ": " << recording.dropped_why << ": "
                     << recording.frames.size() << " pictures read before it\n";
  }
  if (recording.frames.empty())
    throw InputError({options.replay, "", "no pictures", "a recording with at least one picture"});
  require_from(options, recording.frames);
  const BenchSetup setup = recorded_setup(recording, options);
  Replay replay(options, setup, recording);
  loop::StopSignals stop;
  loop::run_loop(replay, replay.sink(), stop);
  replay.finish();
  if (options.is_quiet) return;
  streams.messages << options.replay << ": " << replay.n_shown() << " of " << recording.frames.size()
                   << " pictures shown\n"
                   << prediction_text(recorded_predictions(recording, setup.bench));
}

}  // namespace vrda::bench
