
#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <ostream>
#include <set>
#include <sstream>
#include <utility>

#include "bench/bench_show.hpp"
#include "core/document.hpp"
#include "core/files.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "show/session.hpp"
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
        watches_(setup.bench.tracker->tools.size())
  {
    samples_.reserve(samples_at_once);
    // Written at the end: a wrong name must not cost the times of a whole session.
    if (!options.timing.empty()) require_same_file_type(options.timing, "{");
    if (!options.record.empty()) recorder_ = std::make_unique<Recorder>(options.record, setup.facts);
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
    for (Sample sample; devices_.take(sample);) samples_.push_back(sample);
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
    for (const Sample& sample : samples_) probe_.take(sample);
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
    show_.panel().tracker = devices_.report(DeviceId::tracker);
    show_.panel().board = devices_.report(DeviceId::board);
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
    timing_.n_lost = devices_.report(DeviceId::tracker).n_lost + devices_.report(DeviceId::board).n_lost;
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
    for (const Sample& sample : samples_) {
      if (sample.kind == SampleKind::tool_pose && sample.source < watches_.size())
        watches_[sample.source].add(sample);
    }
    note_camera();
  }

  /// A webcam's stamps are of the steady clock, which this program reads too.
  void note_camera()
  {
    if (!setup_.bench.camera) return;
    const auto newest = std::find_if(samples_.rbegin(), samples_.rend(),
                                     [](const Sample& sample) { return sample.is(ToolVisibility::seen); });
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
  CalibrationFile calibration_file_;
  show::Streams streams_;
  BenchOutput show_;
  BenchState state_;
  ProbeTool probe_;
  Devices devices_;
  std::unique_ptr<JointStream> stream_;
  Trackball trackball_;
  std::optional<Sample> offset_;  ///< the newest one since the last round
  view::GamepadKeys gamepad_;
  std::unique_ptr<Recorder> recorder_;
  std::vector<view::KeyPress> keys_;
  std::vector<Sample> samples_;
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
    if (options.from_s != 0.0) view::refuse_option("--from", "no --replay", "--replay with a recording");
    if (options.speed) view::refuse_option("--speed", "no --replay", "--replay with a recording");
    if (options.is_headless && !options.seconds)
      view::refuse_option("--headless", "no --seconds", "a duration, because there is no window to close");
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
  for (const char c : last) text += printed("%02x", static_cast<unsigned char>(c));
  return text;
}

/// `bench` does not use the marker, nor the probe unless its pose is sent, so their absence must not be
/// reported.
void remove_calibration_tools(BenchFile& bench, bool has_probe)
{
  // They follow the tools of the last role.
  std::vector<std::string>& tools = bench.tracker->tools;
  tools.resize(first_tool_index(bench, static_cast<BodyRole>(n_body_roles)));
  if (has_probe && bench.calibration.is_present &&
      std::ranges::find(tools, bench.calibration.probe) == tools.end())
    tools.push_back(bench.calibration.probe);
}

/// `facts`: without the seal of the model; an empty set is the default one.
BenchSetup build_setup(RecordingFacts facts, bool has_probe)
{
  BenchFile bench = parse_bench_file(facts.bench_text, facts.bench_path);
  remove_calibration_tools(bench, has_probe);
  Calibration calibration = facts.calibration_text.empty()
                                ? nominal_calibration(bench)
                                : parse_calibration(facts.calibration_text, facts.calibration_path, bench);
  const std::string& path = facts.model_path;
  store::MotionModel model = store::scaled_model(store::read_motion_model(path), calibration.subject_scale);
  store::require_grid(model, path, "the bench");
  facts.set = store::chosen_set(model, path, facts.set);
  facts.model_seal = seal_of_file(path);
  store::Motion motion(model, facts.set);
  const SolverFrame frame = store::solver_frame(model, 0);
  return {std::move(model), std::move(motion),      frame,
          std::move(bench), std::move(calibration), std::move(facts)};
}

}  // namespace

BenchSetup read_bench_setup(const BenchOptions& options, MissingCalibration missing)
{
  if (options.bench.empty())
    throw InputError({"--bench", "", "nothing", std::string(wanted_bench) + ", or --replay"});
  RecordingFacts facts;
  facts.bench_path = options.bench;
  facts.bench_text = core::read_document_text(options.bench, wanted_bench);
  facts.calibration_path = options.calibration;
  const bool is_new =
      missing == MissingCalibration::is_nominal && !std::filesystem::exists(options.calibration);
  if (!options.calibration.empty() && !is_new)
    facts.calibration_text =
        core::read_document_text(options.calibration, "a calibration file (schemas/calibration.md)");
  facts.model_path = options.file;
  facts.set = options.set;
  return build_setup(std::move(facts), options.igtl.port.has_value());
}

BenchSetup recorded_setup(RecordingFacts facts, const BenchOptions& options)
{
  if (!options.bench.empty() || !options.calibration.empty()) {
    throw InputError({options.bench.empty() ? "--calibration" : "--bench", "",
                      "a file together with --replay", "no file, because the recording contains it"});
  }
  if (const std::string seal = seal_of_file(options.file); seal != facts.model_seal) {
    throw InputError({options.file, "", "another motion model (" + seal + ")",
                      "the model of the recording, " + facts.model_path + " (" + facts.model_seal + ")"});
  }
  facts.model_path = options.file;
  if (!options.set.empty()) facts.set = options.set;
  return build_setup(std::move(facts), false);
}

// Replay of a bench recording.

namespace {

constexpr double slowest = 0.05, fastest = 100.0;
constexpr double leap_s = 5.0;

/// Plays a recording. Its time continues from the next picture.
class Replay final : public show::Mode {
 public:
  Replay(const BenchOptions& options, const BenchSetup& setup, RecordingReader& recording)
      : options_(options),
        pictures_(recording),
        show_(options, setup),
        state_(setup, recording),
        speed_(options.speed.value_or(options.is_headless ? 0.0 : 1.0))
  {
    next_ = pictures_.index_at(options.from_s);
    until_ = options.seconds ? pictures_.index_at(options.from_s + *options.seconds) : pictures_.n_frames();
    at_s_ = next_s();
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
    if (key == view::key_of('+') || key == view::key_of('=')) speed_ = std::min(fastest, 2.0 * speed_);
    if (key == view::key_of('-')) speed_ = std::max(slowest, 0.5 * speed_);
    if (key == view::key_of('T')) show_.panel().has_panel = !show_.panel().has_panel;
    is_left_ = is_left_ || key == view::key_of('Q');
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

  double next_s() { return pictures_.seconds(std::min(next_, pictures_.n_frames() - 1)); }
  void leap(double s)
  {
    next_ = std::min(pictures_.index_at(std::max(0.0, next_s() + s)), pictures_.n_frames() - 1);
    is_dirty_ = true;
    at_s_ = next_s();
  }

  const BenchOptions& options_;
  RecordingReader& pictures_;
  BenchOutput show_;
  ReplayState state_;
  double speed_ = 1.0;  ///< 0: unpaced
  double at_s_ = 0.0;   ///< position in the recording
  std::size_t next_ = 0, until_ = 0, n_shown_ = 0;
  bool is_paused_ = false, is_left_ = false, is_dirty_ = false;
};

void require_from(const BenchOptions& options, RecordingReader& pictures)
{
  const double last_s = pictures.seconds(pictures.n_frames() - 1);
  if (options.from_s <= last_s) return;
  // Rounded down, so that the reported end is valid.
  constexpr double tenths = 10.0;
  throw InputError(
      {"--from", "", short_decimal(options.from_s, 1),
       "a second of the recording, 0 to " + short_decimal(std::floor(tenths * last_s) / tenths, 1)});
}

}  // namespace

void replay_bench(const BenchOptions& options, const show::Streams& streams)
{
  if (options.speed && !(*options.speed >= slowest && *options.speed <= fastest))
    throw InputError({"--speed", "", std::to_string(*options.speed), "0.05 to 100"});
  RecordingReader recording(options.replay);
  if (!recording.dropped_why().empty()) {
    streams.messages << "vrda-player: " << options.replay << ": " << recording.dropped_why() << ": "
                     << recording.n_frames() << " pictures read before it\n";
  }
  if (recording.n_frames() == 0)
    throw InputError({options.replay, "", "no pictures", "a recording with at least one picture"});
  require_from(options, recording);
  const BenchSetup setup = recorded_setup(recording.facts(), options);
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

namespace {

/// Screens of phones show no more.
constexpr double most_rate_hz = 60.0;

using Json = core::DocumentValue;

}  // namespace

LiveBench::LiveBench(const BenchOptions& options)
    : setup_(read_bench_setup(options)),
      state_(setup_.bench, setup_.calibration, setup_.motion, setup_.frame),
      devices_(setup_.bench.tracker, setup_.bench.board)
{
}

double LiveBench::interval_s() const
{
  return 1.0 / std::min(setup_.bench.display.refresh_hz, most_rate_hz);
}

std::string LiveBench::greeting() const
{
  Json points = Json::array();
  const auto add = [&points](const std::vector<CalibrationPoint>& list, const char* body) {
    for (const CalibrationPoint& point : list) {
      const Eigen::Vector3d& p = point.p_model_mm;
      if (!point.is_target)
        points.push_back({{"name", point.name}, {"body", body}, {"point", {p.x(), p.y(), p.z()}}});
    }
  };
  add(setup_.bench.calibration.points, "reference");
  add(setup_.bench.calibration.tibia_points, "moving");
  const Json greeting{{"kind", "bench"},
                      {"version", 1},
                      {"title", setup_.bench.title},
                      {"set", setup_.facts.set},
                      {"scale", setup_.calibration.subject_scale},
                      {"points", points}};
  return json_text(greeting, -1);
}

std::string LiveBench::next()
{
  for (Sample sample; devices_.take(sample);) state_.take(sample);
  const DeviceReport report = devices_.report(DeviceId::tracker);
  const std::string error_message = report.link == LinkState::up ? "" : device_text("tracker", report);
  return live_message(state_.frame(devices_.now_ns()), ++n_messages_, error_message);
}

std::string live_message(const BenchFrame& frame, std::uint64_t number, const std::string& error_message)
{
  Json placement = Json::array(), marks = Json::array();
  for (Eigen::Index k = 0; k < 12; ++k) placement.push_back(frame.X_tracker_reference.matrix()(k / 4, k % 4));
  const auto mark = [&marks](const std::string& words) {
    if (!words.empty()) marks.push_back(words);
  };
  mark(error_message);
  // The display and its stage do not matter to a browser.
  for (const BodyRole role : {BodyRole::leg, BodyRole::femur, BodyRole::tibia})
    mark(input_status_text(name_of(role), frame.bodies[role]));
  mark(leg_check_text(frame.leg));
  mark(input_status_text("potentiometer", frame.potentiometer));
  const Json message{{"kind", "pose"},
                     {"number", number},
                     {"flexion", deg_from_rad(frame.pose.attitude.flexion_rad)},
                     {"varus", deg_from_rad(frame.pose.attitude.varus_rad)},
                     {"placement", placement},
                     {"marks", marks}};
  return json_text(message, -1);
}

namespace {

constexpr double many = 10.0;  // steps, with Shift
constexpr double usual_prediction_ms = 30.0;

constexpr std::array key_lines{
    view::HelpLine{"Up, Down", "previous, next parameter; with Shift, the next group"},
    view::HelpLine{"Left, Right", "decrease, increase by a step; with Shift by ten"},
    view::HelpLine{"F, V, I", "select flexion, varus (rigid leg), inter-pupillary distance"},
    view::HelpLine{"P", "prediction on and off"},
    view::HelpLine{"E", "filter of the leg's angles on and off"},
    view::HelpLine{"Z", "zero the parallax stage at its stop"},
    view::HelpLine{"Left, right, middle drag", "turn, move, push the joint off the leg; R puts it back"},
    view::HelpLine{"Gamepad", "stick and cross: as the arrow keys; left shoulder: Shift"},
    view::HelpLine{"W", "write the calibration file"},
    view::HelpLine{"T", "panel with devices and timing"},
    view::HelpLine{"S", "screenshot (PNG, in the current folder)"},
    view::HelpLine{"H or ?", "this page"},
    view::HelpLine{"Esc", "close this page"},
    view::HelpLine{"Q", "quit"},
};

/// "left" for "left.k1".
std::string kind_of(std::size_t parameter)
{
  const std::string& name = parameters()[parameter].name;
  return name.substr(0, name.find('.'));
}

void select_by(BenchState& state, bool is_forward, bool is_other_kind)
{
  const std::size_t n = parameters().size();
  const std::size_t step = is_forward ? 1 : n - 1;
  const auto is_passed = [&](std::size_t parameter) {
    const bool is_same_kind = is_other_kind && kind_of(parameter) == kind_of(state.selected());
    return is_same_kind || !is_used(parameter, state.bench());
  };
  std::size_t next = (state.selected() + step) % n;
  while (is_passed(next)) next = (next + step) % n;
  state.select(next);
}

void select_named(BenchState& state, const char* name)
{
  const std::optional<std::size_t> parameter = find_parameter(name);
  if (parameter && is_used(*parameter, state.bench())) state.select(*parameter);
}

void change_by(BenchState& state, double steps)
{
  const std::size_t selected = state.selected();
  const double step = parameters()[selected].step;
  // In multiples of the step, so that opposite key presses restore the value.
  const double value = value_of(state.values(), selected);
  set_value(state.values(), selected, (std::round(value / step * 1e3) / 1e3 + steps) * step);
  state.select(selected);
}

void toggle_prediction(BenchState& state)
{
  double& ms = state.values().prediction_ms;
  const double usual = state.bench().prediction_ms > 0.0 ? state.bench().prediction_ms : usual_prediction_ms;
  ms = ms > 0.0 ? 0.0 : usual;
}

using Press = view::KeyPress;

struct Binding {
  view::Key key = view::Key::none;
  void (*act)(BenchState&, const Press&) = nullptr;
  BenchRequest request = BenchRequest::none;
};

double steps_of(const Press& press)
{
  return press.has_shift ? many : 1.0;
}

constexpr std::array bindings{
    Binding{view::Key::up, [](BenchState& s, const Press& p) { select_by(s, false, p.has_shift); }},
    Binding{view::Key::down, [](BenchState& s, const Press& p) { select_by(s, true, p.has_shift); }},
    Binding{view::Key::left, [](BenchState& s, const Press& p) { change_by(s, -steps_of(p)); }},
    Binding{view::Key::right, [](BenchState& s, const Press& p) { change_by(s, steps_of(p)); }},
    Binding{view::key_of('F'), [](BenchState& s, const Press&) { select_named(s, "flexion"); }},
    Binding{view::key_of('V'), [](BenchState& s, const Press&) { select_named(s, "varus"); }},
    Binding{view::key_of('I'), [](BenchState& s, const Press&) { select_named(s, "eyes.distance_apart"); }},
    Binding{view::key_of('P'), [](BenchState& s, const Press&) { toggle_prediction(s); }},
    Binding{view::key_of('E'), [](BenchState& s, const Press&) { s.set_filter(!s.is_filtered()); }},
    Binding{view::key_of('R'), [](BenchState& s, const Press&) { s.reset_offset(); }},
    Binding{view::key_of('Z'), nullptr, BenchRequest::zero_stage},
    Binding{view::key_of('W'), nullptr, BenchRequest::write_calibration},
    Binding{view::key_of('T'), nullptr, BenchRequest::show_panel},
    Binding{view::key_of('S'), nullptr, BenchRequest::screenshot},
    Binding{view::key_of('H'), nullptr, BenchRequest::show_help},
    Binding{view::key_of('?'), nullptr, BenchRequest::show_help},
    Binding{view::key_of('Q'), nullptr, BenchRequest::quit},
    Binding{view::Key::escape, nullptr, BenchRequest::close_help},
};

}  // namespace

BenchRequest apply_key(BenchState& state, const view::KeyPress& press)
{
  const auto* const binding = std::ranges::find(bindings, press.key, &Binding::key);
  if (binding == bindings.end()) return BenchRequest::none;
  if (binding->act != nullptr) binding->act(state, press);
  return binding->request;
}

std::span<const view::HelpLine> bench_key_lines()
{
  return key_lines;
}

std::string parameter_text(const BenchState& state, std::size_t parameter)
{
  const Parameter& p = parameters()[parameter];
  // Rounded to a hundredth of a step.
  const double grain = p.step / 100.0;
  const double value = std::round(value_of(state.values(), parameter) / grain) * grain;
  const double shown = std::round(value * 1e6) / 1e6;
  return p.name + " " + shortest_decimal(shown) + (p.unit.empty() ? "" : " " + p.unit);
}

namespace {

/// Frames before the end of a skipped part that set what is remembered of the tools: those up to the last
/// frame that had a sample of a tool, or that showed it.
class RememberedFrames {
 public:
  void take(std::size_t k, const std::vector<Sample>& samples)
  {
    for (const Sample& sample : samples) {
      if (sample.kind != SampleKind::tool_pose) continue;
      const std::size_t at = 2 * static_cast<std::size_t>(sample.source);
      if (at >= last_.size()) last_.resize(at + 2);
      last_[at] = k;
      if (sample.is(ToolVisibility::seen)) last_[at + 1] = k;
    }
  }
  bool has(std::size_t k) const
  {
    constexpr std::size_t window = 600;  // 10 s at 60 frames a second: filters have settled
    return std::ranges::any_of(last_, [k](const std::optional<std::size_t>& last) {
      return last && k <= *last && k + window > *last;
    });
  }

 private:
  std::vector<std::optional<std::size_t>> last_;
};

}  // namespace

ReplayState::ReplayState(const BenchSetup& setup, RecordingReader& recording)
    : setup_(setup), recording_(recording)
{
  begin();
}

void ReplayState::begin()
{
  state_.emplace(setup_.bench, setup_.calibration, setup_.motion, setup_.frame);
  n_taken_ = 0;
}

void ReplayState::skip_to(std::size_t n)
{
  RememberedFrames remembered;
  for (std::size_t k = n_taken_; k < n; ++k) remembered.take(k, recording_.frame(k).samples);
  std::vector<Sample> lasting;
  while (n_taken_ < n) {
    if (remembered.has(n_taken_)) {
      take_next();
      continue;
    }
    const RecordedFrame& frame = recording_.frame(n_taken_++);
    lasting.clear();
    std::ranges::copy_if(frame.samples, std::back_inserter(lasting),
                         [](const Sample& sample) { return sample.kind != SampleKind::tool_pose; });
    PanelContent unused;
    apply_input(*state_, unused, frame.keys, lasting);
  }
}

void ReplayState::take_next()
{
  const RecordedFrame& frame = recording_.frame(n_taken_++);
  PanelContent unused;
  apply_input(*state_, unused, frame.keys, frame.samples);
  frame_ = &state_->frame(frame.now_ns);
}

const BenchFrame& ReplayState::at(std::size_t n)
{
  if (n + 1 < n_taken_) begin();
  if (n > n_taken_ + run_up) skip_to(n - run_up);
  while (n_taken_ <= n) take_next();
  return *frame_;
}

namespace {

std::string hundredths(double value)
{
  return short_decimal(value, 2);
}

}  // namespace

void MotionCollector::end_message(BodyRole role)
{
  BodyTracker& tracker = *bodies_[role];
  std::vector<TimedPose>& motion = motions_[role];
  if (!tracker.end_message() || motion.size() == most_poses) return;
  if (motion.empty() || tracker.seen_s() > motion.back().time_s)
    motion.push_back({tracker.seen_s(), tracker.last()});
}

void MotionCollector::take(const RecordedFrame& frame)
{
  for (const Sample& sample : frame.samples) {
    if (sample.kind == SampleKind::tool_pose)
      bodies_.take(sample, [this](BodyRole role) { end_message(role); });
  }
}

bool MotionCollector::is_full() const
{
  return std::ranges::any_of(
      motions_, [](const std::vector<TimedPose>& motion) { return motion.size() == most_poses; });
}

const std::vector<TimedPose>& MotionCollector::motion(BodyRole role)
{
  if (bodies_[role]) end_message(role);
  return motions_[role];
}

std::vector<BodyPrediction> predictions_of(MotionCollector& collector)
{
  std::vector<BodyPrediction> predictions;
  for (const BodyRole role : body_roles) {
    const std::vector<TimedPose>& motion = collector.motion(role);
    if (motion.size() < 2) continue;
    for (const double horizon_ms : {16.0, 33.0, 50.0})
      predictions.push_back({role, horizon_ms, prediction_error(motion, horizon_ms / 1000.0)});
  }
  return predictions;
}

std::string prediction_text(const std::vector<BodyPrediction>& predictions)
{
  std::ostringstream text;
  for (const BodyPrediction& p : predictions) {
    const PredictionError &mm = p.error.shift_mm, &turn = p.error.turn_rad;
    text << name_of(p.role) << " after " << short_decimal(p.horizon_ms, 2) << " ms: held "
         << hundredths(mm.held.rms) << " mm, " << hundredths(deg_from_rad(turn.held.rms))
         << " deg; predicted " << hundredths(mm.predicted.rms) << " mm, "
         << hundredths(deg_from_rad(turn.predicted.rms)) << " deg (root mean square; 95th percentile "
         << hundredths(mm.predicted.percentile_95) << " mm)\n";
  }
  return text.str();
}

}  // namespace vrda::bench
