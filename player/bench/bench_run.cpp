#include "bench/bench_run.hpp"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <memory>
#include <ostream>
#include <set>
#include <sstream>

#include "bench/bench_show.hpp"
#include "bench/timing.hpp"
#include "bench/trackball.hpp"
#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "core/units.hpp"
#include "core/document.hpp"
#include "show/loop.hpp"
#include "view/arguments.hpp"
#include "view/gamepad.hpp"
#include "store/motion_model.hpp"
#include "store/motion_model_file.hpp"
#include "store/solved_cells.hpp"

namespace vrda::bench {
namespace {

constexpr std::size_t samples_at_once = 4096;  // reserved capacity
constexpr double report_interval_s = 0.25;     // update interval of the panel's device lines

/// Live mode: each round processes keys and samples, records them, draws and measures times.
class BenchRun final : public show::Mode {
 public:
  BenchRun(const BenchOptions& options, const BenchSetup& setup, const show::Streams& streams)
      : options_(options),
        setup_(setup),
        calibration_file_(setup.bench, options.calibration, setup.facts.calibration_text),
        streams_(streams),
        show_(options, setup),
        state_(setup.bench, setup.calibration, setup.motion, setup.frame),
        probe_(setup.bench, setup.calibration),
        devices_(setup.bench.tracker, setup.bench.board),
        trackball_(setup.bench.display, setup.model.rotation_centre_mm),
        watches_(setup.bench.tracker ? setup.bench.tracker->tools.size() : 0)
  {
    samples_.reserve(samples_at_once);
    // Written at the end: a wrong name must not cost the times of a whole session.
    if (!options.timing.empty()) require_same_file_type(options.timing, "{");
    if (!options.record.empty())
      recorder_ = std::make_unique<bench::Recorder>(options.record, setup.facts);
    show_.panel().timing = &timing_;
    if (options.igtl.port) stream_ = std::make_unique<JointStream>(options.igtl, setup.model);
  }

  const JointStream* stream() const { return stream_.get(); }

  show::Sink& sink() { return show_.sink(); }
  bool is_over() const override { return is_over_; }
  show::RoundTime round_time() const override { return {1.0 / setup_.bench.display.refresh_hz, false}; }

  void take(const view::InputEvent& event) override
  {
    if (const std::optional<view::KeyPress> press = show::key_press_of(event)) keys_.push_back(*press);
    if (frame_ == nullptr) return;
    if (const auto offset = trackball_.take(event, state_, *frame_, devices_.now_ns())) offset_ = *offset;
  }

  void advance(double elapsed_s) override
  {
    samples_.clear();
    if (const auto pad = show_.sink().window() == nullptr ? std::nullopt : show_.sink().window()->gamepad()) {
      const std::vector<view::KeyPress>& pressed = gamepad_.keys(*pad, elapsed_s, false);
      keys_.insert(keys_.end(), pressed.begin(), pressed.end());
    }
    if (offset_) samples_.push_back(*std::exchange(offset_, std::nullopt));
    for (bench::Sample sample; devices_.take(sample);) samples_.push_back(sample);
    now_ns_ = devices_.now_ns();
    record();
    requests_ = vrda::bench::apply_input(state_, show_.panel(), keys_, samples_);
    keys_.clear();
    frame_ = &state_.frame(now_ns_);
    send();
    update_panel();
  }

  void draw() override
  {
    show_.show(state_, *frame_, timing_.n_pictures, now_s());
    note_times();
    warn(show_.take_warning());
    if (requests_.zero_stage)
      show_status(devices_.zero_stage() ? "stage zeroed" : "the stage does not answer: not zeroed");
    if (requests_.write_calibration) write_calibration();
    if (requests_.take_screenshot) show_.save_screenshot(state_, *frame_);
    is_over_ = requests_.quit || (options_.seconds && now_s() >= *options_.seconds);
  }

  void finish()
  {
    show_.finish();
    if (recorder_) recorder_->close();
    sum_watches();
    if (!options_.timing.empty()) {
      std::ostringstream text;
      write_timing(text, timing_);
      write_atomically(options_.timing, {text.str()});
    }
    if (!options_.is_quiet) streams_.messages << timing_text(timing_) << "\n";
  }

 private:
  double now_s() const { return static_cast<double>(now_ns_) * s_per_ns; }
  void show_status(const std::string& message) { show_.show_message(message, now_s()); }

  void warn(const std::string& words) const
  {
    if (!words.empty()) streams_.messages << "vrda-player: " << words << std::endl;
  }

  void send()
  {
    if (!stream_) return;
    for (const bench::Sample& sample : samples_) probe_.take(sample);
    stream_->put({*frame_, true, probe_.X_tracker_probe(), probe_.status(now_ns_), utc_now_ns(), 0});
  }

  /// A write error ends the recording, not the bench.
  void record()
  {
    if (!recorder_) return;
    const auto refused = show::catch_input_error([&] { recorder_->add(now_ns_, keys_, samples_); });
    if (!refused) return;
    streams_.messages << "vrda-player: " << refused->what() << "; recording stopped\n";
    show_status("recording stopped: " + refused->facts().found);
    recorder_.reset();
  }

  void update_panel()
  {
    show_.expire_message(now_s());
    if (now_s() < next_report_s_) return;
    next_report_s_ = now_s() + report_interval_s;
    show_.panel().tracker = devices_.report(bench::DeviceId::tracker);
    show_.panel().board = devices_.report(bench::DeviceId::board);
    for (const std::string& note : show_.panel().tracker.notes) {
      if (noted_.insert(note).second) warn("tracker: " + note);
    }
    sum_watches();
  }

  void sum_watches()
  {
    timing_.n_missed = timing_.n_late = 0;
    timing_.jitter_ms = 0.0;
    for (const StreamStatistics& watch : watches_) {
      timing_.n_missed += watch.n_missed();
      timing_.n_late += watch.n_late();
      timing_.jitter_ms = std::max(timing_.jitter_ms, watch.jitter_ms());
    }
    timing_.n_lost =
        devices_.report(bench::DeviceId::tracker).n_lost + devices_.report(bench::DeviceId::board).n_lost;
  }

  void note_times()
  {
    const std::int64_t finished_ns = devices_.now_ns();
    const auto ms = [](std::int64_t ns) { return static_cast<double>(ns) * ms_per_ns; };
    timing_.drawing.add(ms(finished_ns - now_ns_));
    if (timing_.n_pictures > 0) timing_.interval.add(ms(finished_ns - finished_ns_));
    finished_ns_ = finished_ns;
    if (frame_->newest_arrival_ns > 0) {
      timing_.latency.add(ms(finished_ns - frame_->newest_arrival_ns));
    } else {
      ++timing_.n_without_sample;
    }
    if (!is_live(*frame_)) ++timing_.n_not_live;
    ++timing_.n_pictures;
    timing_.n_samples += samples_.size();
    for (const bench::Sample& sample : samples_) {
      if (sample.kind == bench::SampleKind::tool_pose && sample.source < watches_.size())
        watches_[sample.source].add(sample);
    }
    note_camera();
  }

  /// A webcam's stamps are of the steady clock, which this program reads too.
  void note_camera()
  {
    if (!setup_.bench.camera) return;
    const auto newest = std::find_if(samples_.rbegin(), samples_.rend(), [](const bench::Sample& sample) {
      return sample.is(bench::ToolVisibility::seen);
    });
    if (newest == samples_.rend()) return;
    const std::int64_t steady_ns =
        std::chrono::steady_clock::now().time_since_epoch() / std::chrono::nanoseconds(1);
    timing_.camera.add(static_cast<double>(steady_ns - newest->device_ns) * ms_per_ns);
  }

  void write_calibration()
  {
    if (options_.calibration.empty()) return show_status("not written: no --calibration FILE");
    const auto refused =
        show::catch_input_error([&] { calibration_file_.write(state_.values().calibration); });
    show_status(refused ? refused->what() : "written: " + options_.calibration);
  }

  const BenchOptions& options_;
  const BenchSetup& setup_;
  bench::CalibrationFile calibration_file_;
  show::Streams streams_;
  BenchOutput show_;
  BenchState state_;
  ProbeTool probe_;
  bench::Devices devices_;
  std::unique_ptr<JointStream> stream_;
  Trackball trackball_;
  std::optional<bench::Sample> offset_;  ///< the newest one since the last round
  view::GamepadKeys gamepad_;
  std::unique_ptr<bench::Recorder> recorder_;
  std::vector<view::KeyPress> keys_;
  std::vector<bench::Sample> samples_;
  // Current round.
  std::int64_t now_ns_ = 0;
  BenchRequests requests_;
  const BenchFrame* frame_ = nullptr;
  std::vector<StreamStatistics> watches_;
  BenchTiming timing_;
  std::int64_t finished_ns_ = 0;
  double next_report_s_ = 0.0;
  std::set<std::string> noted_;  ///< notes of the tracker, each said once
  bool is_over_ = false;
};

void require_options(const BenchOptions& options)
{
  if (options.replay.empty()) {
    if (options.from_s != 0.0)
      view::refuse_option("--from", "no --replay", "--replay with a recording");
    if (options.speed) view::refuse_option("--speed", "no --replay", "--replay with a recording");
    if (options.is_headless && !options.seconds)
      view::refuse_option("--headless", "no --seconds",
                                "a duration, because there is no window to close");
  } else {
    if (!options.record.empty()) view::refuse_option("--record", "--replay", "one of them");
    if (options.igtl.port) view::refuse_option("--igtl", "--replay", "one of them");
  }
  if (!options.video.empty()) show::require_video_name(options.video);
}

}  // namespace

void run_bench(const BenchOptions& options, const show::Streams& streams)
{
  require_options(options);
  if (!options.replay.empty()) {
    replay_bench(options, streams);
    return;
  }
  const BenchSetup setup = read_bench_setup(options, MissingCalibration::is_nominal);
  if (setup.facts.calibration_text.empty() && !options.is_quiet) {
    streams.messages << (options.calibration.empty() ? "no --calibration"
                                                     : options.calibration + ": does not exist")
                     << ": the nominal calibration is used\n";
  }
  show::StopSignals stop;  // before the device threads start: they inherit the signal mask
  BenchRun bench(options, setup, streams);
  if (bench.stream() != nullptr && !options.is_quiet)
    streams.messages << "OpenIGTLink at " << options.igtl.address << ":" << bench.stream()->port()
                     << std::endl;
  show::run_loop(bench, bench.sink(), stop);
  bench.finish();
}

namespace {

constexpr const char* wanted_bench = "a bench file (schemas/bench.md)";

/// Identifies a model file by its length and its last bytes, which contain the checksum of the file.
std::string seal_of_file(const std::string& path)
{
  constexpr std::streamoff seal_bytes = 16;
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  const std::streamoff n = file ? static_cast<std::streamoff>(file.tellg()) : 0;
  std::string last(static_cast<std::size_t>(std::min(n, seal_bytes)), '\0');
  file.seekg(n - static_cast<std::streamoff>(last.size()));
  file.read(last.data(), static_cast<std::streamsize>(last.size()));
  if (!file) throw InputError({path, "", "an unreadable file", "a motion model"});
  std::string text = std::to_string(n) + " ";
  for (const char c : last) {
    constexpr const char* digits = "0123456789abcdef";
    const auto byte = static_cast<unsigned char>(c);
    text += {digits[byte >> 4], digits[byte & 15]};
  }
  return text;
}

/// `bench` does not use the marker, nor the probe unless its pose is sent, so their absence must not be
/// reported.
void remove_calibration_tools(bench::BenchFile& bench, bool has_probe)
{
  if (!bench.tracker) return;
  // They follow the tools of the last role.
  std::vector<std::string>& tools = bench.tracker->tools;
  tools.resize(
      bench::first_tool_index(bench, static_cast<bench::BodyRole>(bench::n_body_roles)));
  if (has_probe && bench.calibration.is_present &&
      std::ranges::find(tools, bench.calibration.probe) == tools.end())
    tools.push_back(bench.calibration.probe);
}

struct Texts {
  std::string bench_path, bench, calibration_path, calibration;
};

struct ModelChoice {
  std::string path, set;
};

BenchSetup build_setup(const Texts& texts, const ModelChoice& choice, bool has_probe)
{
  const std::string& model_path = choice.path;
  bench::BenchFile bench = bench::parse_bench_file(texts.bench, texts.bench_path);
  remove_calibration_tools(bench, has_probe);
  bench::Calibration calibration =
      texts.calibration.empty()
          ? bench::nominal_calibration(bench)
          : bench::parse_calibration(texts.calibration, texts.calibration_path, bench);
  store::MotionModel model =
      store::scaled_model(store::read_motion_model(model_path), calibration.subject_scale);
  store::require_grid(model, model_path, "the bench");
  const std::string chosen = store::chosen_set(model, model_path, choice.set);
  store::Motion motion(model, chosen);
  const SolverFrame frame = store::solver_frame(model, 0);
  bench::RecordingFacts facts{
      texts.bench_path,         texts.bench, texts.calibration_path, texts.calibration, model_path,
      seal_of_file(model_path), chosen};
  return {std::move(model), std::move(motion),      frame,
          std::move(bench), std::move(calibration), std::move(facts)};
}

}  // namespace

BenchSetup read_bench_setup(const BenchOptions& options, MissingCalibration missing)
{
  if (options.bench.empty())
    throw InputError({"--bench", "", "nothing", std::string(wanted_bench) + ", or --replay"});
  Texts texts;
  texts.bench_path = options.bench;
  texts.bench = core::read_document_text(options.bench, wanted_bench);
  texts.calibration_path = options.calibration;
  const bool is_new =
      missing == MissingCalibration::is_nominal && !std::filesystem::exists(options.calibration);
  if (!options.calibration.empty() && !is_new)
    texts.calibration =
        core::read_document_text(options.calibration, "a calibration file (schemas/calibration.md)");
  return build_setup(texts, {options.file, options.set}, options.igtl.port.has_value());
}

BenchSetup recorded_setup(const bench::Recording& recording, const BenchOptions& options)
{
  const bench::RecordingFacts& facts = recording.facts;
  if (!options.bench.empty() || !options.calibration.empty()) {
    throw InputError({options.bench.empty() ? "--calibration" : "--bench", "",
                      "a file together with --replay", "no file, because the recording contains it"});
  }
  if (const std::string seal = seal_of_file(options.file); seal != facts.model_seal) {
    throw InputError({options.file, "", "another motion model (" + seal + ")",
                      "the model of the recording, " + facts.model_path + " (" + facts.model_seal + ")"});
  }
  const std::string set = options.set.empty() ? facts.set : options.set;
  return build_setup({facts.bench_path, facts.bench_text, facts.calibration_path, facts.calibration_text},
                     {options.file, set}, false);
}

}  // namespace vrda::bench
