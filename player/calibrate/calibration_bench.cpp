#include "calibrate/calibration_bench.hpp"

#include <utility>

#include "bench/bench_panel.hpp"
#include "calibration_tasks/parts.hpp"
#include "core/error.hpp"
#include "core/units.hpp"
#include "devices/devices.hpp"
#include "navigation/arguments.hpp"
#include "settings/settings_text.hpp"
#include "store/motion_model.hpp"
#include "store/solved_cells.hpp"
#include "virtual_bench/operator.hpp"

namespace vrda::calibrate {
namespace {

navigation::AppearanceOptions plain_look()
{
  navigation::AppearanceOptions look;
  look.mode = scene::DrawMode::smooth;
  look.layers = "none";
  return look;
}

/// Dials in the order of SixNumbers.
tracking::PoseParameters numbers_of(const Task& task, std::span<const double> values)
{
  check(values.size() == 6 && task.dials.size() == 6, "a pose task has six dials");
  tracking::PoseParameters place;
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
    : bench_(bench), model_(std::move(model)), set_(motion::chosen_set(model_, file, set))
{
}

void AdjustedModel::take(const devices::Sample& sample)
{
  if (shown_) shown_->state.take(sample);
}

void AdjustedModel::place(const Calibration& calibration, const PoseTrial& trial, std::int64_t now_ns,
                          render::Renderer& renderer)
{
  if (!shown_ || shown_->scale != calibration.subject_scale) {
    shown_ = std::make_unique<ModelOnBench>(bench_, calibration,
                                            store::scaled_model(model_, calibration.subject_scale), set_);
    renderer.load(shown_->view.scene());
    renderer.load(shown_->view.warp());
  }
  Calibration& tried = shown_->state.values().calibration;
  tried = calibration;
  tried.X_body_model[static_cast<std::size_t>(calibration_tasks::role_of(trial.part))] =
      numbers_of(trial.task, trial.values);
  if (shown_->view.take(tried.eyes)) renderer.load(shown_->view.warp());
  shown_->view.place(shown_->state.frame(now_ns), tried);
}

namespace {

/// Scales a displayed line into the eye's window: the optics can display more than the window's pixels.
void fit_into_window(DrawnLine& line, const optics::Eye& eye)
{
  const optics::ShownBox seen = optics::shown_box(eye), window = optics::box_of(eye.window);
  const Eigen::Vector2d seen_px = seen.high_px - seen.low_px, window_px = window.high_px - window.low_px;
  constexpr double filled = 0.98;
  const double scale = filled * window_px.cwiseQuotient(seen_px).minCoeff();
  const Eigen::Vector2d from = 0.5 * (seen.low_px + seen.high_px),
                        to = 0.5 * (window.low_px + window.high_px);
  for (Eigen::Vector2d& p : line.points_px) p = to + scale * (p - from);
}

using Deviation = virtual_bench::VirtualOperator::Deviation;

class LiveBench final : public CalibrationBench {
 public:
  explicit LiveBench(const BenchFile& bench) : bench_(bench), devices_(bench.tracker, bench.board) {}

  void send_samples(CalibrationSession& session, AdjustedModel* model) override
  {
    for (devices::Sample sample; devices_.take(sample);) {
      session.take(sample);
      if (model != nullptr) model->take(sample);
    }
  }
  std::int64_t now_ns() const override { return devices_.now_ns(); }
  void zero_stage() override { devices_.zero_stage(); }
  std::vector<std::string> device_problems(const Task& task) const override
  {
    std::vector<std::string> lines;
    const auto add = [&](const char* name, devices::DeviceId device) {
      const devices::DeviceReport report = devices_.report(device);
      if (report.link != devices::LinkState::up) lines.push_back(bench::device_text(name, report));
    };
    const bool wants_tracker = !task.tool.empty() || task.kind == TaskKind::model_pose;
    const bool wants_board = task.kind == TaskKind::stop || task.kind == TaskKind::bullseye;
    if (wants_tracker && bench_.tracker) {
      add("tracker", devices::DeviceId::tracker);
      for (const std::string& note : devices_.report(devices::DeviceId::tracker).notes)
        if (note.starts_with(task.tool + ":")) lines.push_back(note);
    }
    if (wants_board && bench_.board) add("board", devices::DeviceId::board);
    return lines;
  }
  std::optional<Deviation> deviation(const CalibrationSession&) const override { return std::nullopt; }
  CalibrationView view(const CalibrationSession& session) const override
  {
    return {calibration_tasks::task_lines(session), std::nullopt, {}};
  }

 private:
  const BenchFile& bench_;
  devices::Devices devices_;
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
    const optics::EyePair& eyes = truth_.calibration.eyes;
    CalibrationView seen;
    seen.boxes = {optics::box_of(eyes.left.window), optics::box_of(eyes.right.window)};
    if (session.task() == nullptr) return seen;
    seen.lines = virtual_bench::physical_outlines(*session.task(), bench_, truth_);
    for (const DrawnLine& line : virtual_bench::seen_lines(drawn(session), truth_))
      seen.lines.push_back(line);
    for (DrawnLine& line : seen.lines) fit_into_window(line, optics::side_of(eyes, line.is_right));
    if (const std::optional<double> reading = operator_.reading(session)) {
      const std::vector<Dial>& dials = session.task()->dials;
      seen.notes.push_back("Reading: " + settings::rounded_text(*reading, 2) +
                           (dials.empty() ? "" : " " + dials.front().unit));
    }
    return seen;
  }

 private:
  std::vector<DrawnLine> drawn(const CalibrationSession& session) const
  {
    const CalibrationProgress& progress = session.progress();
    if (session.task()->kind != TaskKind::model_pose) return calibration_tasks::task_lines(session);
    return virtual_bench::drawn_model_lines({progress.part, session.values(), session.drawing_calibration()},
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

}  // namespace vrda::calibrate
