#include "calibration/calibrate.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <ostream>
#include <thread>
#include <utility>

#include "calibration/calibration_bench.hpp"
#include "calibration/calibration_mode.hpp"
#include "calibration/calibration_pictures.hpp"
#include "calibration/calibration_report.hpp"
#include "calibration/parts.hpp"
#include "core/error.hpp"
#include "core/publication.hpp"
#include "view/arguments.hpp"

namespace vrda::calibration {
namespace {

/// Fixed date of virtual benches, so that their files are reproducible.
constexpr const char* virtual_date = "2000-01-01";

std::string today()
{
  const std::time_t now = std::time(nullptr);
  std::tm local{};
  localtime_r(&now, &local);
  std::array<char, 16> text{};
  const std::size_t n = std::strftime(text.data(), text.size(), "%Y-%m-%d", &local);
  return {text.data(), n};
}

struct CalibrateSetup {
  BenchFile bench;
  Calibration begun;
  std::vector<CalibrationPart> parts;  ///< requested
  VirtualNoise noise;
  std::optional<calibration::JointCurve> joint;  ///< of --model, for the part functional
};

/// Whether the step only reads or solves an existing file.
bool is_file_step(const CalibrateOptions& options)
{
  return options.step == "status" || options.step == "solve";
}

/// --benches runs complete unattended calibrations and writes only statistics.
void require_benches_options(const CalibrateOptions& options)
{
  if (options.n_benches == 0) return;
  if (options.step != "all" && options.step != bench::name_of(CalibrationPart::functional))
    view::refuse_option("--benches", "\"" + options.step + "\"", "the step all or functional");
  const std::pair<const char*, const std::string*> unused[] = {{"--calibration", &options.calibration},
                                                               {"--script", &options.script},
                                                               {"--pictures", &options.pictures}};
  for (const auto& [name, value] : unused) {
    if (!value->empty())
      view::refuse_option("--benches", std::string(name) + " \"" + *value + "\"",
                                "only one of these options; --benches writes only statistics");
  }
}

void require_options(const CalibrateOptions& options)
{
  if (options.head != "stage" && options.head != "tracker")
    view::refuse_option("--head", "\"" + options.head + "\"", "stage or tracker");
  if (!options.is_virtual) {
    if (options.bench.empty())
      view::refuse_option("--bench", "nothing", "a bench file (schemas/bench.md), or --virtual");
    if (options.n_benches > 0) view::refuse_option("--benches", "no --virtual", "--virtual");
    if (!options.noise.empty()) view::refuse_option("--noise", "no --virtual", "--virtual");
    if (options.head != "stage")
      view::refuse_option("--head", "no --virtual", "--virtual, or `head` in the file of --bench");
    if (!options.pictures.empty() && options.script.empty())
      view::refuse_option("--pictures", "no --virtual and no --script", "one of them");
    if (options.is_headless && options.script.empty() && !is_file_step(options))
      view::refuse_option("--headless", "no --script", "a script of keys, because there is no window");
  } else {
    require_benches_options(options);
    if (!options.pictures.empty() && options.script.empty() && !options.is_headless)
      view::refuse_option("--pictures", "no --headless and no --script", "one of them");
  }
  if (!options.bench_from.empty()) {
    if (is_file_step(options))
      view::refuse_option("--bench-from", "\"" + options.step + "\"",
                                "a calibration step, preferably person");
    if (options.calibration.empty())
      view::refuse_option("--bench-from", "no --calibration",
                                "the file of the person to be calibrated");
  }
  if (options.calibration.empty() && (!options.is_virtual || is_file_step(options)))
    view::refuse_option("--calibration", "nothing", "the calibration file (schemas/calibration.md)");
}

/// Starts a file from the per-bench parts of another person's file, or resumes a file started that way.
Calibration begun_from_other(const CalibrateOptions& options, const BenchFile& bench)
{
  const Calibration other = bench::read_calibration(options.bench_from, bench);
  std::optional<Publication> result = Publication::begin(options.calibration, "vrda-player calibrate");
  if (std::filesystem::exists(options.calibration)) {
    const Calibration begun = bench::read_calibration(options.calibration, bench);
    calibration::require_same_bench_parts(begun, options.calibration, other, options.bench_from);
    return begun;
  }
  const Calibration begun = calibration::start_calibration_from(other, bench, options.bench_from);
  result->publish(bench::calibration_text(begun, bench));
  return begun;
}

/// Each seed is a different bench and person, so the title keeps their calibration files apart.
std::string virtual_title(const CalibrateOptions& options, const std::string& title)
{
  return title + (options.bench.empty() ? "" : ", virtual") + ", seed " + std::to_string(options.seed);
}

CalibrateSetup read_setup(const CalibrateOptions& options)
{
  CalibrateSetup setup;
  const HeadKind head = options.head == "tracker" ? HeadKind::tracker : HeadKind::stage;
  setup.bench = options.bench.empty()
                    ? bench::parse_bench_file(calibration::virtual_bench_text(head), "virtual bench")
                    : bench::read_bench_file(options.bench);
  if (options.is_virtual) {
    setup.bench.title = virtual_title(options, setup.bench.title);
    // Drawn as seen by the eye, on this screen.
    setup.bench.display.reflection = {};
    setup.bench.display.outputs.clear();
  }
  setup.parts = is_file_step(options) ? calibration::parts_of(setup.bench)
                                      : calibration::parts_of_step(options.step, setup.bench);
  setup.noise = noise_of(options.noise);
  const bool is_functional = std::ranges::find(setup.parts, CalibrationPart::functional) != setup.parts.end();
  if (is_functional && !is_file_step(options) && !options.model.empty())
    setup.joint = joint_curve(options.model, options.set);
  const bool is_there = !options.calibration.empty() && std::filesystem::exists(options.calibration);
  if (!is_there && is_file_step(options))
    throw InputError({options.calibration, "", "no file", "an existing calibration file"});
  if (!options.bench_from.empty()) {
    setup.begun = begun_from_other(options, setup.bench);
    return setup;
  }
  setup.begun = is_there ? bench::read_calibration(options.calibration, setup.bench)
                         : bench::nominal_calibration(setup.bench);
  return setup;
}

void write_parts(const CalibrateOptions& options, const CalibrateSetup& setup, const Calibration& calibration,
                 std::ostream& data)
{
  if (options.has_json) {
    write_status_json(data, setup.bench, calibration, setup.parts);
    data << "\n";
  } else if (!options.is_quiet) {
    write_status(data, calibration, setup.parts);
  }
}

bool is_place_adjusted(const CalibrateSetup& setup)
{
  return setup.bench.calibration.is_model_adjusted &&
         std::ranges::any_of(setup.parts, calibration::is_model_part);
}

void require_model(const CalibrateOptions& options, const CalibrateSetup& setup)
{
  if (!is_place_adjusted(setup)) return;
  if (options.is_virtual) {
    // A virtual bench draws leg and model as lines between their points.
    for (const CalibrationPart part : setup.parts) {
      if (!calibration::is_model_part(part) ||
          calibration::points_of(part, setup.bench.calibration).size() > 1)
        continue;
      throw InputError({setup.bench.path,
                        part == CalibrationPart::tibia ? "calibration.tibia_point" : "calibration.point",
                        "fewer than two points, with calibration.model = \"adjust\"",
                        "two or more points, which a virtual bench needs to draw the leg"});
    }
    return;
  }
  if (options.model.empty())
    view::refuse_option("--model", "nothing",
                              "the motion model to be adjusted (calibration.model = \"adjust\")");
}

calibration::CalibrationSessionOptions session_options(const CalibrateOptions& options,
                                                             const CalibrateSetup& setup)
{
  return {setup.parts, options.is_repeated, options.is_virtual ? virtual_date : today(),
          options.calibration.empty() ? "virtual bench" : options.calibration, setup.joint};
}

VirtualTruth truth_of(const CalibrateOptions& options, const CalibrateSetup& setup)
{
  VirtualTruth truth = calibration::virtual_truth(setup.bench, options.seed);
  if (setup.joint) truth.joint = calibration::virtual_joint(truth, *setup.joint, setup.noise);
  return truth;
}

CalibrateEnd end_of(const CalibrationSession& session)
{
  return session.task() == nullptr ? CalibrateEnd::finished : CalibrateEnd::quit;
}

CalibrateEnd run_attended(const CalibrateOptions& options, const CalibrateSetup& setup,
                          const show::Streams& streams)
{
  require_model(options, setup);
  show::StopSignals stop;  // before the device threads start: they inherit the signal mask
  CalibrationSession session(setup.bench, setup.begun, session_options(options, setup));
  CalibrationWriter kept(setup.bench, options.calibration);
  CalibrationMode mode(options, setup.bench, session, kept, streams);
  const std::unique_ptr<CalibrationBench> calibration_bench =
      options.is_virtual ? open_virtual_bench(setup.bench, truth_of(options, setup), setup.noise)
                         : open_live_bench(setup.bench);
  mode.set_bench(*calibration_bench);
  show::run_loop(mode, mode.sink(), stop);
  kept.write(session);
  write_parts(options, setup, session.calibration(), streams.data);
  return end_of(session);
}

/// The simulated operator does every task.
void operate(CalibrationSession& session, VirtualOperator& person, CalibrationWriter& kept,
             std::vector<Task>& tasks_done)
{
  constexpr int most_tasks = 100'000;
  show::StopSignals stop;
  kept.write(session);
  for (int n = 0; session.task() != nullptr && !stop.wait_until({}); ++n) {
    check(n < most_tasks, "a virtual operator finishes");
    tasks_done.push_back(*session.task());
    person.do_task(session);
    kept.write(session);
  }
}

CalibrateEnd run_unattended(const CalibrateOptions& options, const CalibrateSetup& setup,
                            const show::Streams& streams)
{
  const VirtualNoise& noise = setup.noise;
  const VirtualTruth truth = truth_of(options, setup);
  CalibrationSession session(setup.bench, setup.begun, session_options(options, setup));
  CalibrationWriter kept(setup.bench, options.calibration);
  VirtualOperator person(setup.bench, truth, noise);
  std::vector<Task> tasks;
  operate(session, person, kept, tasks);
  const Calibration& found = session.calibration();
  const std::vector<TargetError> before = calibration::target_errors(
      calibration::uncalibrated(setup.bench, truth), setup.bench, truth, noise);
  const std::vector<TargetError> after = calibration::target_errors(found, setup.bench, truth, noise);
  const std::vector<CalibrationPart> missing = missing_parts(found, calibration::parts_of(setup.bench));
  if (options.has_json) {
    streams.data << "{\"seed\": " << options.seed << ", \"calibration\": ";
    write_status_json(streams.data, setup.bench, found, setup.parts);
    streams.data << ", \"targets\": ";
    write_targets_json(streams.data, before, after, missing);
    streams.data << "}\n";
  } else if (!options.is_quiet) {
    write_status(streams.data, found, setup.parts);
    write_targets(streams.data, before, after, missing);
    if (truth.joint && calibration::is_done(found, CalibrationPart::functional))
      write_joint(streams.data, calibration::joint_error(found, truth));
  }
  if (!options.pictures.empty() && session.task() == nullptr) {
    const PictureRequest request{setup.bench, truth, found, tasks};
    for (const std::string& path : write_calibration_pictures(request, options))
      if (!options.is_quiet) streams.messages << path << "\n";
  }
  return end_of(session);
}

void write_benches(const CalibrateOptions& options, const CalibrateSetup& setup, std::ostream& data)
{
  const int n_threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  if (options.step != "all" && !setup.joint)
    view::refuse_option("--model", "nothing",
                              "the motion model that functional places in thigh and shank");
  const VirtualStatistics statistics = calibration::virtual_statistics(
      setup.bench, {options.seed, options.n_benches, n_threads, setup.noise, setup.joint});
  if (options.has_json) {
    write_statistics_json(data, statistics);
    data << "\n";
  } else {
    write_statistics(data, statistics);
  }
}

bool has_screen()
{
  const auto is_set = [](const char* name) {
    const char* const value = std::getenv(name);
    return value != nullptr && *value != '\0';
  };
  return is_set("DISPLAY") || is_set("WAYLAND_DISPLAY");
}

/// A virtual bench without a screen runs unattended unless an operator's file would be written.
bool is_without_screen(const CalibrateOptions& options)
{
  return options.is_virtual && options.script.empty() && options.calibration.empty() && !has_screen();
}

/// Keys come from a script or from a window.
bool has_keys(const CalibrateOptions& options)
{
  return !options.is_virtual || !options.script.empty() || !options.is_headless;
}

}  // namespace

VirtualNoise noise_of(const std::string& list)
{
  VirtualNoise noise;
  const std::pair<const char*, double*> named[] = {
      {"alignment_px", &noise.alignment_px}, {"tracker_mm", &noise.tracker_mm},
      {"tracker_deg", &noise.tracker_deg},   {"touch_mm", &noise.touch_mm},
      {"ruler_mm", &noise.ruler_mm},         {"pupillometer_mm", &noise.pupillometer_mm},
      {"landmark_mm", &noise.landmark_mm},   {"model_mm", &noise.model_mm},
      {"model_deg", &noise.model_deg}};
  if (list.empty()) return noise;
  for (const std::string& item : view::split(list, ',')) {
    const std::size_t at = item.find('=');
    const auto known =
        std::ranges::find_if(named, [&](const auto& each) { return item.substr(0, at) == each.first; });
    double value = -1.0;
    if (at != std::string::npos && known != std::end(named)) {
      const char* const end = item.data() + item.size();
      const auto [stop, error] = std::from_chars(item.data() + at + 1, end, value);
      if (error != std::errc() || stop != end) value = -1.0;
    }
    constexpr double most = 1000.0;
    if (!(value >= 0.0 && value <= most)) {
      std::string names;
      for (const auto& each : named) names += (names.empty() ? "" : ", ") + std::string(each.first);
      view::refuse_option("--noise", "\"" + item + "\"",
                                "NAME=VALUE, 0 to 1000, with a NAME of " + names);
    }
    *known->second = value;
  }
  return noise;
}

CalibrateEnd calibrate(const CalibrateOptions& options, const show::Streams& streams)
{
  require_options(options);
  CalibrateSetup setup = read_setup(options);
  if (options.n_benches > 0) {
    write_benches(options, setup, streams.data);
    return CalibrateEnd::finished;
  }
  if (options.step == "solve") {
    std::optional<Publication> result = Publication::begin(options.calibration, "vrda-player calibrate");
    setup.begun = calibration::solve_again(
        setup.bench, bench::read_calibration(options.calibration, setup.bench), options.calibration);
    result->publish(bench::calibration_text(setup.begun, setup.bench));
  }
  if (is_file_step(options)) {
    write_parts(options, setup, setup.begun, streams.data);
    return CalibrateEnd::finished;
  }
  if (!has_keys(options)) return run_unattended(options, setup, streams);
  if (!is_without_screen(options)) return run_attended(options, setup, streams);
  if (!options.is_quiet) streams.messages << "no screen: runs unattended, as with --headless\n";
  return run_unattended(options, setup, streams);
}

}  // namespace vrda::calibration
