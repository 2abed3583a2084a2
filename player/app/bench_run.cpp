#include "app/bench_run.hpp"

#include <algorithm>
#include <chrono>
#include <memory>
#include <ostream>

#include "app/bench_replay.hpp"
#include "app/bench_show.hpp"
#include "app/pace.hpp"
#include "app/stop_signals.hpp"
#include "bench/timing.hpp"
#include "core/error.hpp"
#include "core/units.hpp"
#include "core/whole_file.hpp"

namespace vrda {
namespace {

constexpr std::size_t samples_at_once = 4096;  // beyond it the vector grows
constexpr double report_interval_s = 0.25;     // of the panel's device lines

class BenchRun {
 public:
  BenchRun(const BenchOptions& options, const BenchSetup& setup, const ShowStreams& streams)
      : options_(options),
        setup_(setup),
        streams_(streams),
        show_(options, setup),
        state_(setup.bench, setup.calibration, setup.motion, setup.frame),
        devices_(setup.bench.tracker, setup.bench.board),
        watches_(setup.bench.tracker ? setup.bench.tracker->tools.size() : 0)
  {
    samples_.reserve(samples_at_once);
    if (!options.record.empty()) recorder_ = std::make_unique<Recorder>(options.record, setup.facts);
    show_.panel().timing = &timing_;
  }

  void run()
  {
    Pace pace(setup_.bench.display.refresh_hz);
    while (!is_over_ && !show_.screen().should_close() && !stop_.came_within(std::chrono::milliseconds(0))) {
      pace.wait();
      round();
    }
    finish();
  }

 private:
  void round()
  {
    const std::vector<KeyPress>& keys = show_.screen().keys();
    samples_.clear();
    for (Sample sample; devices_.take(sample);) samples_.push_back(sample);
    const std::int64_t now_ns = devices_.now_ns();
    const double now_s = static_cast<double>(now_ns) * s_per_ns;
    record(now_ns, keys);
    const BenchWishes wishes = take(state_, show_.panel(), keys, samples_);
    const BenchFrame& frame = state_.frame(now_ns);
    update_panel(now_s);
    show_.show(state_, frame, timing_.n_pictures);
    note_times(frame, now_ns);
    warn(show_.take_warning());
    if (wishes.zeroes_stage) {
      show_.tell(
          devices_.zero_stage() ? "the stage is zero here" : "no stage answers: nothing is set to zero",
          now_s);
    }
    if (wishes.writes_calibration) write_calibration(now_s);
    if (wishes.takes_picture) show_.save(state_, frame);
    is_over_ = wishes.quits || (options_.seconds && now_s >= *options_.seconds);
  }

  void warn(const std::string& words) const
  {
    if (!words.empty()) streams_.talk << "vrda-player: " << words << std::endl;
  }

  /// A disk that is full or gone ends the recording, not the bench.
  void record(std::int64_t now_ns, const std::vector<KeyPress>& keys)
  {
    if (!recorder_) return;
    try {
      recorder_->add(now_ns, keys, samples_);
    } catch (const InputError& error) {
      streams_.talk << "vrda-player: " << error.what() << "; the recording ends here\n";
      show_.tell("the recording ended: " + error.facts().found, static_cast<double>(now_ns) * s_per_ns);
      recorder_.reset();
    }
  }

  void update_panel(double now_s)
  {
    show_.forget_message(now_s);
    if (now_s < next_report_s_) return;
    next_report_s_ = now_s + report_interval_s;
    show_.panel().tracker = devices_.report(DeviceId::tracker);
    show_.panel().board = devices_.report(DeviceId::board);
    sum_watches();
  }

  void sum_watches()
  {
    timing_.n_missed = timing_.n_late = 0;
    timing_.jitter_ms = 0.0;
    for (const SampleWatch& watch : watches_) {
      timing_.n_missed += watch.n_missed();
      timing_.n_late += watch.n_late();
      timing_.jitter_ms = std::max(timing_.jitter_ms, watch.jitter_ms());
    }
    timing_.n_lost = devices_.report(DeviceId::tracker).n_lost + devices_.report(DeviceId::board).n_lost;
  }

  void note_times(const BenchFrame& frame, std::int64_t begun_ns)
  {
    const std::int64_t finished_ns = devices_.now_ns();
    const auto ms = [](std::int64_t ns) { return static_cast<double>(ns) * ms_per_ns; };
    timing_.drawing.add(ms(finished_ns - begun_ns));
    if (timing_.n_pictures > 0) timing_.interval.add(ms(finished_ns - finished_ns_));
    finished_ns_ = finished_ns;
    if (frame.newest_arrival_ns > 0) {
      timing_.latency.add(ms(finished_ns - frame.newest_arrival_ns));
    } else {
      ++timing_.n_repeated;
    }
    if (!is_live(frame)) ++timing_.n_unsampled;
    ++timing_.n_pictures;
    timing_.n_samples += samples_.size();
    for (const Sample& sample : samples_) {
      if (sample.kind == SampleKind::place && sample.source < watches_.size())
        watches_[sample.source].add(sample);
    }
  }

  void write_calibration(double now_s)
  {
    if (options_.calibration.empty()) {
      show_.tell("no --calibration FILE was given to write to", now_s);
      return;
    }
    try {
      write_whole(options_.calibration, {calibration_text(state_.values().calibration, setup_.bench)});
      show_.tell("written: " + options_.calibration, now_s);
    } catch (const InputError& error) {
      show_.tell(error.what(), now_s);
    }
  }

  void finish()
  {
    show_.finish();
    if (recorder_) recorder_->close();
    sum_watches();
    if (!options_.timing.empty()) write_timing_file(options_.timing, timing_);
    if (!options_.is_quiet) streams_.talk << timing_text(timing_) << "\n";
  }

  const BenchOptions& options_;
  const BenchSetup& setup_;
  ShowStreams streams_;
  StopSignals stop_;  // before the devices' threads begin, which keep its mask
  BenchShow show_;
  BenchState state_;
  Devices devices_;
  std::unique_ptr<Recorder> recorder_;
  std::vector<Sample> samples_;
  std::vector<SampleWatch> watches_;
  BenchTiming timing_;
  std::int64_t finished_ns_ = 0;
  double next_report_s_ = 0.0;
  bool is_over_ = false;
};

void require_options(const BenchOptions& options)
{
  const auto refuse = [](const char* option, const std::string& found, const char* wanted) {
    throw InputError({option, "", found, wanted});
  };
  if (options.replay.empty()) {
    if (options.from_s != 0.0) refuse("--from", "no --replay", "the recording to begin within");
    if (options.speed) refuse("--speed", "no --replay", "the recording to play");
    if (options.is_headless && !options.seconds)
      refuse("--headless", "no --seconds", "how long to run: nobody sees it");
  } else {
    if (!options.record.empty()) refuse("--record", "--replay", "one of them");
  }
  if (!options.video.empty()) require_video_name(options.video);
}

}  // namespace

void run_bench(const BenchOptions& options, const ShowStreams& streams)
{
  require_options(options);
  if (!options.replay.empty()) {
    replay_bench(options, streams);
    return;
  }
  const BenchSetup setup = read_bench_setup(options);
  if (setup.facts.calibration_text.empty() && !options.is_quiet) {
    streams.talk << (options.calibration.empty() ? "no --calibration"
                                                 : options.calibration + ": not there yet")
                 << ": the nominal one of a bench that was never calibrated\n";
  }
  BenchRun bench(options, setup, streams);
  bench.run();
}

}  // namespace vrda
