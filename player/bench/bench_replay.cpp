// Replay of a bench recording.

#include <algorithm>
#include <cmath>
#include <optional>
#include <ostream>
#include <utility>

#include "bench/bench_show.hpp"
#include "bench/recorded_motion.hpp"
#include "bench/replay_state.hpp"
#include "core/error.hpp"
#include "core/units.hpp"
#include "show/loop.hpp"
#include "show/settings_text.hpp"

namespace vrda::bench {
namespace {

constexpr double slowest = 0.05, fastest = 100.0;
constexpr double leap_s = 5.0;

/// Plays a recording. Its time continues from the next picture.
class Replay final : public show::Mode {
 public:
  Replay(const BenchOptions& options, const BenchSetup& setup, bench::RecordingReader& recording)
      : options_(options),
        pictures_(recording),
        show_(options, setup),
        state_(setup, recording),
        speed_(options.speed.value_or(options.is_headless ? 0.0 : 1.0))
  {
    next_ = pictures_.index_at(options.from_s);
    until_ = options.seconds ? pictures_.index_at(options.from_s + *options.seconds) : pictures_.n_frames();
    rebase();
  }

  show::Sink& sink() { return show_.sink(); }
  std::size_t n_shown() const { return n_shown_; }
  void finish() { show_.finish(); }

  bool is_over() const override { return is_left_ || (options_.is_headless && is_resting()); }

  show::RoundTime round_time() const override
  {
    constexpr double resting_s = 0.02;
    if (is_resting()) return {resting_s};
    return {speed_ > 0.0 ? std::max(0.0, (pictures_.seconds(next_) - at_s_) / speed_) : 0.0};
  }

  void take(const view::InputEvent& event) override
  {
    const std::optional<view::KeyPress> press = show::key_press_of(event);
    if (!press) return;
    const view::Key key = press->key;
    if (key == view::Key::space) is_paused_ = !is_paused_;
    if (key == view::Key::left) leap(-leap_s);
    if (key == view::Key::right) leap(leap_s);
    if (key == view::key_of('+') || key == view::key_of('='))
      speed_ = std::min(fastest, 2.0 * speed_);
    if (key == view::key_of('-')) speed_ = std::max(slowest, 0.5 * speed_);
    if (key == view::key_of('T')) show_.panel().has_panel = !show_.panel().has_panel;
    is_left_ = is_left_ || key == view::Key::escape || key == view::key_of('Q');
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
    if (speed_ > 0.0 && pictures_.seconds(next_) > at_s_ + rounding_s) return;
    draw(next_++);
    ++n_shown_;
  }

 private:
  bool is_resting() const { return is_paused_ || next_ >= until_; }
  void draw(std::size_t n)
  {
    show_.show(state_.state(), state_.at(n), n, pictures_.seconds(n) / options_.speed.value_or(1.0));
  }

  void rebase() { at_s_ = pictures_.seconds(std::min(next_, pictures_.n_frames() - 1)); }
  void leap(double s)
  {
    const double from_s = pictures_.seconds(std::min(next_, pictures_.n_frames() - 1));
    next_ = std::min(pictures_.index_at(std::max(0.0, from_s + s)), pictures_.n_frames() - 1);
    is_dirty_ = true;
    rebase();
  }

  const BenchOptions& options_;
  bench::RecordingReader& pictures_;
  BenchOutput show_;
  ReplayState state_;
  double speed_ = 1.0;  ///< 0: unpaced
  double at_s_ = 0.0;   ///< position in the recording
  std::size_t next_ = 0, until_ = 0, n_shown_ = 0;
  bool is_paused_ = false, is_left_ = false, is_dirty_ = false;
};

void require_from(const BenchOptions& options, bench::RecordingReader& pictures)
{
  const double last_s = pictures.seconds(pictures.n_frames() - 1);
  if (options.from_s <= last_s) return;
  // Rounded down, so that the reported end is valid.
  constexpr double tenths = 10.0;
  throw InputError(
      {"--from", "", show::rounded_text(options.from_s, 1),
       "a second of the recording, 0 to " + show::rounded_text(std::floor(tenths * last_s) / tenths, 1)});
}

}  // namespace

void replay_bench(const BenchOptions& options, const show::Streams& streams)
{
  if (options.speed && !(*options.speed >= slowest && *options.speed <= fastest))
    throw InputError({"--speed", "", std::to_string(*options.speed), "0.05 to 100"});
  bench::RecordingReader recording(options.replay);
  if (!recording.dropped_why().empty()) {
    streams.messages << "vrda-player: " << options.replay << ": " << recording.dropped_why() << ": "
                     << recording.n_frames() << " pictures read before it\n";
  }
  if (recording.n_frames() == 0)
    throw InputError({options.replay, "", "no pictures", "a recording with at least one picture"});
  require_from(options, recording);
  const BenchSetup setup = recorded_setup(bench::Recording{recording.facts(), {}, 0, {}}, options);
  Replay replay(options, setup, recording);
  show::StopSignals stop;
  show::run_loop(replay, replay.sink(), stop);
  replay.finish();
  if (options.is_quiet) return;
  MotionCollector collector(setup.bench);
  for (std::size_t k = 0; k < recording.n_frames() && !collector.is_full(); ++k)
    collector.take(recording.frame(k));
  streams.messages << options.replay << ": " << replay.n_shown() << " of " << recording.n_frames()
                   << " pictures shown\n"
                   << prediction_text(predictions_of(collector));
}

}  // namespace vrda::bench
