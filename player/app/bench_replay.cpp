#include "app/bench_replay.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <ostream>
#include <sstream>
#include <thread>

#include "app/bench_show.hpp"
#include "app/stop_signals.hpp"
#include "bench/recorded_motion.hpp"
#include "core/error.hpp"
#include "core/units.hpp"
#include "core/whole_file.hpp"
#include "settings/settings_text.hpp"

namespace vrda {
namespace {

constexpr double slowest = 0.05, fastest = 100.0;
constexpr double leap_s = 5.0;

/// Since the first picture.
double seconds_of(const std::vector<RecordedPicture>& pictures, std::size_t n)
{
  return static_cast<double>(pictures[n].now_ns - pictures.front().now_ns) * s_per_ns;
}

/// The state at any picture of a recording. Going back begins anew: the state follows from all that came
/// before.
class ReplayState {
 public:
  ReplayState(const BenchSetup& setup, const Recording& recording) : setup_(setup), recording_(recording)
  {
    begin();
  }
  /// As it was when picture `n` was shown.
  const BenchFrame& at(std::size_t n)
  {
    if (n + 1 < n_taken_) begin();
    while (n_taken_ <= n) {
      const RecordedPicture& picture = recording_.pictures[n_taken_++];
      PanelContent unused;
      take(*state_, unused, picture.keys, picture.samples);
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
  const Recording& recording_;
  std::optional<BenchState> state_;
  const BenchFrame* frame_ = nullptr;
  std::size_t n_taken_ = 0;
};

class Replay {
 public:
  Replay(const BenchOptions& options, const BenchSetup& setup, const Recording& recording)
      : options_(options),
        pictures_(recording.pictures),
        show_(options, setup),
        state_(setup, recording),
        speed_(options.speed.value_or(options.is_headless ? 0.0 : 1.0))
  {
    next_ = index_at(options.from_s);
    until_ = options.seconds ? index_at(options.from_s + *options.seconds) : pictures_.size();
  }

  std::size_t run()
  {
    std::size_t n_shown = 0;
    rebase();
    while (!is_over_ && !show_.screen().should_close() && !stop_.came_within(std::chrono::milliseconds(0))) {
      take_keys();
      if (is_paused_ || next_ >= until_) {
        if (options_.is_headless) break;
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
        if (is_dirty_ && next_ > 0) draw(next_ - 1);
        is_dirty_ = false;
        continue;
      }
      wait_for(next_);
      draw(next_++);
      ++n_shown;
    }
    show_.finish();
    return n_shown;
  }

 private:
  using Clock = std::chrono::steady_clock;

  std::size_t index_at(double s) const
  {
    std::size_t n = 0;
    while (n < pictures_.size() && seconds_of(pictures_, n) < s) ++n;
    return n;
  }
  void draw(std::size_t n) { show_.show(state_.state(), state_.at(n), n); }

  /// Time goes on from the next picture.
  void rebase()
  {
    began_ = Clock::now();
    began_at_s_ = next_ < pictures_.size() ? seconds_of(pictures_, next_) : 0.0;
  }
  void wait_for(std::size_t n)
  {
    if (speed_ <= 0.0) return;
    const std::chrono::duration<double> due((seconds_of(pictures_, n) - began_at_s_) / speed_);
    std::this_thread::sleep_until(began_ + std::chrono::duration_cast<Clock::duration>(due));
  }
  void leap(double s)
  {
    const double at_s =
        next_ < pictures_.size() ? seconds_of(pictures_, next_) : seconds_of(pictures_, pictures_.size() - 1);
    next_ = std::min(index_at(std::max(0.0, at_s + s)), pictures_.size() - 1);
    is_dirty_ = true;
    rebase();
  }
  void take_keys()
  {
    for (const KeyPress& press : show_.screen().keys()) {
      if (press.key == Key::space) is_paused_ = !is_paused_;
      if (press.key == Key::left) leap(-leap_s);
      if (press.key == Key::right) leap(leap_s);
      if (press.key == key_of('+') || press.key == key_of('=')) speed_ = std::min(fastest, 2.0 * speed_);
      if (press.key == key_of('-')) speed_ = std::max(slowest, 0.5 * speed_);
      if (press.key == key_of('T')) show_.panel().has_panel = !show_.panel().has_panel;
      is_over_ = is_over_ || press.key == Key::escape || press.key == key_of('Q');
      rebase();
    }
  }

  const BenchOptions& options_;
  const std::vector<RecordedPicture>& pictures_;
  StopSignals stop_;
  BenchShow show_;
  ReplayState state_;
  double speed_ = 1.0;  ///< 0: as fast as it goes
  std::size_t next_ = 0, until_ = 0;
  bool is_paused_ = false, is_over_ = false, is_dirty_ = false;
  Clock::time_point began_;
  double began_at_s_ = 0.0;
};

void require_from(const BenchOptions& options, const std::vector<RecordedPicture>& pictures)
{
  const double last_s = seconds_of(pictures, pictures.size() - 1);
  if (options.from_s <= last_s) return;
  // Rounded down: what the message wants is there.
  constexpr double tenths = 10.0;
  throw InputError(
      {"--from", "", rounded_text(options.from_s, 1),
       "a second of the recording, 0 to " + rounded_text(std::floor(tenths * last_s) / tenths, 1)});
}

}  // namespace

void replay_bench(const BenchOptions& options, const ShowStreams& streams)
{
  if (options.speed && !(*options.speed >= slowest && *options.speed <= fastest))
    throw InputError({"--speed", "", std::to_string(*options.speed), "0.05 to 100"});
  const Recording recording = read_recording(options.replay);
  if (!recording.dropped_why.empty()) {
    streams.talk << "vrda-player: " << options.replay << ": " << recording.dropped_why
                 << ": read up to there, " << recording.pictures.size() << " pictures\n";
  }
  if (recording.pictures.empty())
    throw InputError({options.replay, "", "no picture", "a recording of at least one"});
  require_from(options, recording.pictures);
  const BenchSetup setup = setup_of(recording, options);
  Replay replay(options, setup, recording);
  const std::size_t n_shown = replay.run();
  if (options.is_quiet) return;
  streams.talk << options.replay << ": " << n_shown << " of " << recording.pictures.size()
               << " pictures shown\n"
               << prediction_text(recorded_predictions(recording, setup.bench));
}

void write_timing_file(const std::string& path, const BenchTiming& timing)
{
  std::ostringstream text;
  write_timing(text, timing);
  write_whole(path, {text.str()});
}

}  // namespace vrda
