#include "calibration/calibration_bench.hpp"

#include <utility>

#include "bench/bench_panel.hpp"
#include "calibration/parts.hpp"
#include "core/error.hpp"
#include "core/units.hpp"
#include "bench/devices.hpp"
#include "view/arguments.hpp"
#include "show/settings_text.hpp"
#include "store/motion_model.hpp"
#include "store/solved_cells.hpp"
#include "calibration/operator.hpp"

namespace vrda::calibration {
namespace {

view::AppearanceOptions plain_look()
{
  view::AppearanceOptions look;
  look.mode = view::DrawMode::smooth;
  look.layers = "none";
  return look;
}

/// Dials in the order of SixNumbers.
bench::PoseParameters numbers_of(const Task& task, std::span<const double> values)
{
  check(values.size() == 6 && task.dials.size() == 6, "a pose task has six dials");
  bench::PoseParameters place;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const auto k = static_cast<std::size_t>(axis);
    const bool is_deg = task.dials[k + 3].unit == "deg";
    place.shift_mm[axis] = values[k];
    place.turn_rad[axis] = is_deg ? rad_from_deg(values[k + 3]) : values[k + 3];
  }
  return place;
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

void AdjustedModel::place(const Calibration& calibration, const PoseTrial& trial, std::int64_t now_ns,
                          view::Renderer& renderer)
{
  if (!shown_ || shown_->scale != calibration.subject_scale) {
    shown_ = std::make_unique<ModelOnBench>(bench_, calibration,
                                            store::scaled_model(model_, calibration.subject_scale), set_);
    renderer.load(shown_->view.scene());
    renderer.load(shown_->view.warp());
  }
  Calibration& tried = shown_->state.values().calibration;
  tried = calibration;
  tried.X_body_model[static_cast<std::size_t>(calibration::role_of(trial.part))] =
      numbers_of(trial.task, trial.values);
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

using Deviation = calibration::VirtualOperator::Deviation;

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
    const bool wants_tracker = !task.tool.empty() || task.kind == TaskKind::model_pose;
    const bool wants_board = task.kind == TaskKind::stop || task.kind == TaskKind::bullseye;
    if (wants_tracker && bench_.tracker) {
      add("tracker", bench::DeviceId::tracker);
      for (const std::string& note : devices_.report(bench::DeviceId::tracker).notes)
        if (note.starts_with(task.tool + ":")) lines.push_back(note);
    }
    if (wants_board && bench_.board) add("board", bench::DeviceId::board);
    return lines;
  }
  std::optional<Deviation> deviation(const CalibrationSession&) const override { return std::nullopt; }
  CalibrationView view(const CalibrationSession& session) const override
  {
    return {calibration::task_lines(session), std::nullopt, {}};
  }

 private:
  const BenchFile& bench_;
  bench::Devices devices_;
};

class VirtualBench final : public CalibrationBench {
 public:
  VirtualBench(const BenchFile& bench, const VirtualTruth& truth, const VirtualNoise& noise)
      : bench_(bench), truth_(truth), operator_(bench, truth, noise)
  {
  }

  void send_samples(CalibrationSession& session, AdjustedModel*) override
  {
    if (session.task() != nullptr) operator_.send_samples(session);
  }
  std::int64_t now_ns() const override { return 0; }
  void zero_stage() override {}
  std::vector<std::string> device_problems(const Task&) const override { return {}; }
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
    seen.lines = calibration::physical_outlines(*session.task(), bench_, truth_);
    for (const DrawnLine& line : calibration::seen_lines(drawn(session), truth_))
      seen.lines.push_back(line);
    for (DrawnLine& line : seen.lines) fit_into_window(line, view::side_of(eyes, line.is_right));
    if (const std::optional<double> reading = operator_.reading(session)) {
      const std::vector<Dial>& dials = session.task()->dials;
      seen.notes.push_back("Reading: " + show::rounded_text(*reading, 2) +
                           (dials.empty() ? "" : " " + dials.front().unit));
    }
    return seen;
  }

 private:
  std::vector<DrawnLine> drawn(const CalibrationSession& session) const
  {
    const CalibrationProgress& progress = session.progress();
    if (session.task()->kind != TaskKind::model_pose) return calibration::task_lines(session);
    return calibration::drawn_model_lines({progress.part, session.values(), session.drawing_calibration()},
                                            bench_, truth_);
  }

  const BenchFile& bench_;
  VirtualTruth truth_;
  VirtualOperator operator_;
};

}  // namespace

std::unique_ptr<CalibrationBench> open_live_bench(const BenchFile& bench)
{
  return std::make_unique<LiveBench>(bench);
}

std::unique_ptr<CalibrationBench> open_virtual_bench(const BenchFile& bench, const VirtualTruth& truth,
                                                     const VirtualNoise& noise)
{
  return std::make_unique<VirtualBench>(bench, truth, noise);
}

}  // namespace vrda::calibration
