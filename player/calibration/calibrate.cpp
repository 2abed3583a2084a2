
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <ostream>
#include <thread>
#include <utility>

#include "bench/devices.hpp"
#include "calibration/calibration_mode.hpp"
#include "calibration/marks.hpp"
#include "calibration/parts.hpp"
#include "core/fields_json.hpp"
#include "core/files.hpp"
#include "core/process.hpp"
#include "core/text.hpp"
#include "show/session.hpp"
#include "store/motion_model.hpp"
#include "store/solved_cells.hpp"

namespace vrda::calibration {
namespace {

view::AppearanceOptions plain_look()
{
  view::AppearanceOptions look;
  look.mode = view::DrawMode::smooth;
  look.layers = "none";
  return look;
}

}  // namespace

ModelOnBench::ModelOnBench(const BenchFile& bench, const Calibration& calibration, store::MotionModel scaled,
                           const std::string& set)
    : scale(calibration.subject_scale),
      model(std::move(scaled)),
      motion(model, set),
      state(bench, calibration, motion, store::solver_frame(model, 0)),
      view(model, motion, bench, calibration, plain_look())
{
}

AdjustedModel::AdjustedModel(const BenchFile& bench, store::MotionModel model, const std::string& file,
                             const std::string& set)
    : bench_(bench), model_(std::move(model)), set_(store::chosen_set(model_, file, set))
{
}

void AdjustedModel::take(const bench::Sample& sample)
{
  if (shown_) shown_->state.take(sample);
}

void AdjustedModel::place(const CalibrationSession& session, std::int64_t now_ns, view::Renderer& renderer)
{
  const Calibration& calibration = session.calibration();
  if (!shown_ || shown_->scale != calibration.subject_scale) {
    shown_ = std::make_unique<ModelOnBench>(bench_, calibration,
                                            store::scaled_model(model_, calibration.subject_scale), set_);
    renderer.load(shown_->view.scene());
    renderer.load(shown_->view.warp());
  }
  Calibration& tried = shown_->state.values().calibration;
  tried = calibration;
  tried.X_body_model[static_cast<std::size_t>(session.task()->body.value())] =
      bench::pose_parameters_of(session.values());
  if (shown_->view.take(tried.eyes)) renderer.load(shown_->view.warp());
  shown_->view.place(shown_->state.frame(now_ns), tried);
}

namespace {

/// Scales a displayed line into the eye's window: the optics can display more than the window's pixels.
void fit_into_window(DrawnLine& line, const view::Eye& eye)
{
  const view::ShownBox seen = view::shown_box(eye), window = view::box_of(eye.window);
  const Eigen::Vector2d seen_px = seen.high_px - seen.low_px, window_px = window.high_px - window.low_px;
  constexpr double filled = 0.98;
  const double scale = filled * window_px.cwiseQuotient(seen_px).minCoeff();
  const Eigen::Vector2d from = 0.5 * (seen.low_px + seen.high_px),
                        to = 0.5 * (window.low_px + window.high_px);
  for (Eigen::Vector2d& p : line.points_px) p = to + scale * (p - from);
}

class LiveBench final : public CalibrationBench {
 public:
  explicit LiveBench(const BenchFile& bench) : bench_(bench), devices_(bench.tracker, bench.board) {}

  void send_samples(CalibrationSession& session, AdjustedModel* model) override
  {
    for (bench::Sample sample; devices_.take(sample);) {
      session.take(sample);
      if (model != nullptr) model->take(sample);
    }
  }
  std::int64_t now_ns() const override { return devices_.now_ns(); }
  void zero_stage() override { devices_.zero_stage(); }
  std::vector<std::string> device_problems(const Task& task) const override
  {
    std::vector<std::string> lines;
    const auto add = [&](const char* name, bench::DeviceId device) {
      const bench::DeviceReport report = devices_.report(device);
      if (report.link != bench::LinkState::up) lines.push_back(bench::device_text(name, report));
    };
    const bool wants_tracker = !task.tool.empty() || task.kind->traits().places_model;
    const bool wants_board = task.kind->traits().uses_stage;
    if (wants_tracker && bench_.tracker) {
      add("tracker", bench::DeviceId::tracker);
      for (const std::string& note : devices_.report(bench::DeviceId::tracker).notes)
        if (note.starts_with(task.tool + ":")) lines.push_back(note);
    }
    if (wants_board && bench_.board) add("board", bench::DeviceId::board);
    return lines;
  }
  CalibrationView view(const CalibrationSession& session) const override
  {
    if (session.task() == nullptr) return {};
    const Task& task = *session.task();
    return {task.kind->draw(task, session.values(), session.drawing_calibration()), std::nullopt, {}};
  }

 private:
  const BenchFile& bench_;
  bench::Devices devices_;
};

class VirtualBench final : public CalibrationBench {
 public:
  VirtualBench(const BenchFile& bench, const VirtualTruth& truth, const VirtualNoise& noise)
      : truth_(truth), operator_(bench, truth, noise)
  {
  }

  void send_samples(CalibrationSession& session, AdjustedModel*) override
  {
    if (session.task() != nullptr) operator_.send_samples(session);
  }
  std::optional<Deviation> deviation(const CalibrationSession& session) const override
  {
    return operator_.deviation(session);
  }
  CalibrationView view(const CalibrationSession& session) const override
  {
    const view::EyePair& eyes = truth_.calibration.eyes;
    CalibrationView seen;
    seen.boxes = {view::box_of(eyes.left.window), view::box_of(eyes.right.window)};
    if (session.task() == nullptr) return seen;
    seen.lines = operator_.seen(session);
    for (DrawnLine& line : seen.lines) fit_into_window(line, view::side_of(eyes, line.is_right));
    if (const std::optional<double> reading = operator_.reading(session))
      seen.notes.push_back("Reading: " + bench::text(*reading, 2, session.task()->dials.front().unit));
    return seen;
  }

 private:
  VirtualTruth truth_;
  VirtualOperator operator_;
};

}  // namespace

// Reports of a calibration as text and JSON.

namespace {

using Json = core::DocumentValue;

std::string padded(std::string text, std::size_t width)
{
  text.resize(std::max(width, text.size()), ' ');
  return text;
}

const char* state_of(const CalibrationRecord* record)
{
  if (record == nullptr || (record->marks.empty() && !record->estimate)) return "missing";
  if (!record->estimate) return "begun";
  return record->is_outdated ? "outdated" : "done";
}

void write_part(std::ostream& out, CalibrationPart part, const CalibrationRecord* record)
{
  const std::string state = state_of(record);
  out << padded(bench::name_of(part), 12) << state;
  if (state == "missing") {
    out << (part_object(part).traits().is_optional ? ", optional\n" : "\n");
    return;
  }
  if (state == "begun")
    out << ": " << record->marks.size() << (record->marks.size() == 1 ? " mark so far" : " marks so far");
  if (state == "outdated") out << ": must be repeated";
  out << ", " << record->date << "\n";
  if (!record->estimate) return;
  const Estimate& estimate = *record->estimate;
  for (std::size_t k = 0; k < estimate.names.size(); ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    out << "  " << padded(estimate.names[k], 22) << bench::interval_text(estimate, row) << "\n";
  }
  if (!estimate.residuals.empty()) {
    out << "  residual rms "
        << short_decimal(estimate.residual_rms, bench::decimals_for(estimate.residual_rms)) << " "
        << estimate.residual_unit << " of " << estimate.residuals.size() << "\n";
  }
  for (const std::string& remark : estimate.remarks) out << "  " << remark << "\n";
}

void add_estimate(Json& row, const Estimate& estimate)
{
  Json& numbers = row["numbers"] = Json::array();
  for (std::size_t k = 0; k < estimate.names.size(); ++k) {
    const auto at = static_cast<Eigen::Index>(k);
    numbers.push_back({{"name", estimate.names[k]},
                       {"unit", estimate.units[k]},
                       {"value", json_value(estimate.values[at])},
                       {"half_width_95", json_value(bench::half_width_95(estimate, at))}});
  }
  row["residual_rms"] = json_value(estimate.residual_rms);
  row["residual_unit"] = estimate.residual_unit;
  row["residuals"] = estimate.residuals.size();
  row["remarks"] = estimate.remarks;
}

Json names_json(std::span<const CalibrationPart> parts)
{
  Json names = Json::array();
  for (const CalibrationPart part : parts) names.push_back(bench::name_of(part));
  return names;
}

/// Parts that are not done or outdated.
std::vector<CalibrationPart> missing_parts(const Calibration& calibration,
                                           std::span<const CalibrationPart> parts)
{
  std::vector<CalibrationPart> missing;
  for (const CalibrationPart part : parts) {
    if (!part_object(part).traits().is_optional && !is_done(calibration, part)) missing.push_back(part);
  }
  return missing;
}

/// The state and the results of `parts`, in order.
void write_status(std::ostream& out, const Calibration& calibration, std::span<const CalibrationPart> parts)
{
  for (const CalibrationPart part : parts) write_part(out, part, find_record(calibration, part));
  const std::vector<CalibrationPart> missing = missing_parts(calibration, parts);
  if (!missing.empty()) out << "to be done: " << names_of(missing) << "\n";
}

Json status_json(const BenchFile& bench, const Calibration& calibration,
                 std::span<const CalibrationPart> parts)
{
  Json rows = Json::array();
  for (const CalibrationPart part : parts) {
    const CalibrationRecord* record = find_record(calibration, part);
    Json& row = rows.emplace_back(Json::object());
    row["name"] = bench::name_of(part);
    row["once"] = bench::is_per_bench(part) ? "bench" : "person";
    row["state"] = state_of(record);
    if (record == nullptr) continue;
    row["date"] = record->date;
    row["marks"] = record->marks.size();
    if (record->estimate) add_estimate(row, *record->estimate);
  }
  return {
      {"bench", bench.title}, {"parts", rows}, {"to_be_done", names_json(missing_parts(calibration, parts))}};
}

/// By nearest rank.
Quantiles quantiles_of(std::vector<double> values)
{
  if (values.empty()) return {};
  std::ranges::sort(values);
  const auto at = [&](double share) {
    const double rank = std::ceil(share * static_cast<double>(values.size()));
    return values[static_cast<std::size_t>(std::max(1.0, rank)) - 1];
  };
  return {at(0.5), at(0.9), values.back()};
}

void write_summary(std::ostream& out, const char* name, std::span<const TargetError> errors)
{
  const TargetSummary s = summary_of(errors);
  const auto text = [](double mm, double arc_min) {
    return short_decimal(mm, 2) + " mm (" + short_decimal(arc_min, 1) + "')";
  };
  out << "  " << padded(name, 8) << "median " << text(s.mm.median, s.arc_min.median) << ", 9 of 10 within "
      << text(s.mm.p90, s.arc_min.p90) << ", largest " << text(s.mm.largest, s.arc_min.largest) << "\n";
}

/// `missing`: parts that are not done; if not empty, `after` is not written (JSON: null).
void write_targets(std::ostream& out, std::span<const TargetError> before, std::span<const TargetError> after,
                   std::span<const CalibrationPart> missing)
{
  out << "overlay error at " << before.size() << " targets (mm across the line of sight, arc minutes)\n";
  write_summary(out, "before", before);
  if (missing.empty()) {
    write_summary(out, "after", after);
  } else {
    out << "  " << padded("after", 8) << "unknown until these parts are done: " << names_of(missing) << "\n";
  }
}

Json targets_json(std::span<const TargetError> before, std::span<const TargetError> after,
                  std::span<const CalibrationPart> missing)
{
  return {{"n", before.size()},
          {"before", summary_of(before)},
          {"after", missing.empty() ? Json(summary_of(after)) : Json()},
          {"to_be_done", names_json(missing)}};
}

/// Error of the placements at the joint.
void write_joint(std::ostream& out, const JointError& error)
{
  out << "error at the joint (root mean square of both bones): by landmarks "
      << short_decimal(error.by_landmarks_mm, 2) << " mm, by motion " << short_decimal(error.functional_mm, 2)
      << " mm\n";
}

struct JointSummary {
  std::size_t n = 0;
  Quantiles by_landmarks, functional;
  std::ptrdiff_t n_halved = 0;
};

constexpr auto fields_of(const JointSummary*)
{
  return std::tuple{Field{"n", &JointSummary::n}, Field{"by_landmarks_mm", &JointSummary::by_landmarks},
                    Field{"by_motion_mm", &JointSummary::functional},
                    Field{"halved", &JointSummary::n_halved}};
}

JointSummary summary_of(std::span<const JointError> joints)
{
  std::vector<double> by_landmarks, functional;
  for (const JointError& error : joints) {
    by_landmarks.push_back(error.by_landmarks_mm);
    functional.push_back(error.functional_mm);
  }
  const auto is_halved = [](const JointError& e) { return e.functional_mm <= 0.5 * e.by_landmarks_mm; };
  return {joints.size(), quantiles_of(std::move(by_landmarks)), quantiles_of(std::move(functional)),
          std::ranges::count_if(joints, is_halved)};
}

void write_joints(std::ostream& out, const JointSummary& s)
{
  const auto row = [&](const char* name, const Quantiles& of) {
    out << "  " << padded(name, 16) << "median " << short_decimal(of.median, 2) << " mm, 9 of 10 within "
        << short_decimal(of.p90, 2) << " mm, largest " << short_decimal(of.largest, 2) << " mm\n";
  };
  out << "error at the joint of " << s.n << " legs (root mean square of both bones)\n";
  row("by landmarks", s.by_landmarks);
  row("by motion", s.functional);
  out << "  at least halved in " << s.n_halved << " of " << s.n << "\n";
}

void write_statistics(std::ostream& out, const VirtualStatistics& statistics)
{
  out << statistics.n_benches << " benches; a part was rejected and repeated on " << statistics.n_refused
      << "\n"
      << padded("part", 12) << padded("number", 22) << padded("within 95 %", 14) << padded("rms error", 12)
      << "mean half width\n";
  for (const NumberStatistics& number : statistics.numbers) {
    out << padded(number.part, 12) << padded(number.name, 22)
        << padded(short_decimal(100.0 * number.n_within / number.n, 1) + " %", 14)
        << padded(short_decimal(number.rms_error, bench::decimals_for(number.rms_error)), 12)
        << bench::text(number.mean_half_width, bench::decimals_for(number.mean_half_width), number.unit)
        << "\n";
  }
  if (!statistics.joints.empty()) return write_joints(out, summary_of(statistics.joints));
  write_targets(out, statistics.before, statistics.after, {});
}

Json statistics_json(const VirtualStatistics& statistics)
{
  Json json{{"benches", statistics.n_benches},
            {"refused", statistics.n_refused},
            {"numbers", json_value(statistics.numbers)}};
  if (statistics.joints.empty())
    json["targets"] = targets_json(statistics.before, statistics.after, {});
  else
    json["joint"] = summary_of(statistics.joints);
  return json;
}

}  // namespace

TargetSummary summary_of(std::span<const TargetError> errors)
{
  std::vector<double> mm, arc_min;
  for (const TargetError& error : errors) {
    mm.push_back(error.mm);
    arc_min.push_back(error.arc_min);
  }
  return {quantiles_of(std::move(mm)), quantiles_of(std::move(arc_min))};
}

namespace {

/// Fixed date of virtual benches, so that their files are reproducible.
constexpr const char* virtual_date = "2000-01-01";

std::string today()
{
  const std::time_t now = std::time(nullptr);
  std::tm local{};
  localtime_r(&now, &local);
  return printed("%04d-%02d-%02d", local.tm_year + 1900, local.tm_mon + 1, local.tm_mday);
}

struct CalibrateSetup {
  BenchFile bench;
  Calibration begun;
  std::vector<CalibrationPart> parts;  ///< requested
  VirtualNoise noise;
  std::optional<JointCurve> joint;  ///< of --model, for the part functional
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
      view::refuse_option("--bench-from", "no --calibration", "the file of the person to be calibrated");
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
    require_same_bench_parts(begun, options.calibration, other, options.bench_from);
    return begun;
  }
  const Calibration begun = start_calibration_from(other, bench, options.bench_from);
  result->publish(bench::calibration_text(begun, bench));
  return begun;
}

CalibrateSetup read_setup(const CalibrateOptions& options)
{
  CalibrateSetup setup;
  const HeadKind head = options.head == "tracker" ? HeadKind::tracker : HeadKind::stage;
  setup.bench = options.bench.empty() ? bench::parse_bench_file(virtual_bench_text(head), "virtual bench")
                                      : bench::read_bench_file(options.bench);
  if (options.is_virtual) {
    // Each seed is a different bench and person: their calibration files have different titles.
    setup.bench.title +=
        (options.bench.empty() ? "" : ", virtual") + std::string(", seed ") + std::to_string(options.seed);
    // Drawn as seen by the eye, on this screen.
    setup.bench.display.reflection = {};
    setup.bench.display.outputs.clear();
  }
  setup.parts = is_file_step(options) ? parts_of(setup.bench) : parts_of_step(options.step, setup.bench);
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
    data << json_text(status_json(setup.bench, calibration, setup.parts), -1) << "\n";
  } else if (!options.is_quiet) {
    write_status(data, calibration, setup.parts);
  }
}

void require_model(const CalibrateOptions& options, const CalibrateSetup& setup)
{
  if (!setup.bench.calibration.is_model_adjusted || std::ranges::none_of(setup.parts, is_model_part)) return;
  if (options.is_virtual) {
    // A virtual bench draws leg and model as lines between their points.
    for (const CalibrationPart part : setup.parts) {
      if (!is_model_part(part) || points_of(role_of(part), setup.bench.calibration).size() > 1) continue;
      throw InputError({setup.bench.path, part_object(part).traits().bench_key,
                        "fewer than two points, with calibration.model = \"adjust\"",
                        "two or more points, which a virtual bench needs to draw the leg"});
    }
    return;
  }
  if (options.model.empty())
    view::refuse_option("--model", "nothing",
                        "the motion model to be adjusted (calibration.model = \"adjust\")");
}

CalibrationSessionOptions session_options(const CalibrateOptions& options, const CalibrateSetup& setup)
{
  return {setup.parts, options.is_repeated, options.is_virtual ? virtual_date : today(),
          options.calibration.empty() ? "virtual bench" : options.calibration, setup.joint};
}

VirtualTruth truth_of(const CalibrateOptions& options, const CalibrateSetup& setup)
{
  VirtualTruth truth = virtual_truth(setup.bench, options.seed);
  if (setup.joint) truth.joint = virtual_joint(truth, *setup.joint, setup.noise);
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
  std::unique_ptr<CalibrationBench> calibration_bench;
  if (options.is_virtual) {
    calibration_bench = std::make_unique<VirtualBench>(setup.bench, truth_of(options, setup), setup.noise);
  } else {
    calibration_bench = std::make_unique<LiveBench>(setup.bench);
  }
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
  const std::vector<TargetError> before =
      target_errors(uncalibrated(setup.bench, truth), setup.bench, truth, noise);
  const std::vector<TargetError> after = target_errors(found, setup.bench, truth, noise);
  const std::vector<CalibrationPart> missing = missing_parts(found, parts_of(setup.bench));
  if (options.has_json) {
    const Json json{{"seed", options.seed},
                    {"calibration", status_json(setup.bench, found, setup.parts)},
                    {"targets", targets_json(before, after, missing)}};
    streams.data << json_text(json, -1) << "\n";
  } else if (!options.is_quiet) {
    write_status(streams.data, found, setup.parts);
    write_targets(streams.data, before, after, missing);
    if (truth.joint && is_done(found, CalibrationPart::functional))
      write_joint(streams.data, joint_error(found, truth));
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
  const int n_threads = usable_processors();
  if (options.step != "all" && !setup.joint)
    view::refuse_option("--model", "nothing", "the motion model that functional places in thigh and shank");
  const VirtualStatistics statistics =
      virtual_statistics(setup.bench, {options.seed, options.n_benches, n_threads, setup.noise, setup.joint});
  if (options.has_json) {
    data << json_text(statistics_json(statistics), -1) << "\n";
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
    const std::vector<std::string> words = view::split(item, '=');
    const auto known = std::ranges::find_if(named, [&](const auto& each) { return words[0] == each.first; });
    const bool is_pair = words.size() == 2 && known != std::end(named);
    const double value = is_pair ? view::parsed_number(words[1]).value_or(-1.0) : -1.0;
    constexpr double most = 1000.0;
    if (!(value >= 0.0 && value <= most)) {
      std::vector<std::string> names;
      for (const auto& each : named) names.emplace_back(each.first);
      view::refuse_option("--noise", "\"" + item + "\"",
                          "NAME=VALUE, 0 to 1000, with a NAME of " + joined(names));
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
    setup.begun = solve_again(setup.bench, bench::read_calibration(options.calibration, setup.bench),
                              options.calibration);
    result->publish(bench::calibration_text(setup.begun, setup.bench));
  }
  if (is_file_step(options)) {
    write_parts(options, setup, setup.begun, streams.data);
    return CalibrateEnd::finished;
  }
  const bool has_script = !options.script.empty();
  const bool has_keys = !options.is_virtual || has_script || !options.is_headless;
  if (!has_keys) return run_unattended(options, setup, streams);
  // A virtual bench without a screen runs unattended unless an operator's file would be written.
  const bool needs_screen = !options.is_virtual || has_script || !options.calibration.empty();
  if (needs_screen || has_screen()) return run_attended(options, setup, streams);
  if (!options.is_quiet) streams.messages << "no screen: runs unattended, as with --headless\n";
  return run_unattended(options, setup, streams);
}

}  // namespace vrda::calibration
