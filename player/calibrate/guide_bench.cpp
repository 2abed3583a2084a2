#include "calibrate/guide_bench.hpp"

#include <utility>

#include "bench/bench_panel.hpp"
#include "core/error.hpp"
#include "core/units.hpp"
#include "devices/devices.hpp"
#include "guide/parts.hpp"
#include "settings/settings_text.hpp"
#include "store/scaled_model.hpp"
#include "store/solved_cells.hpp"
#include "view/arguments.hpp"
#include "virtual_bench/operator.hpp"

namespace vrda {
namespace {

LookOptions plain_look()
{
  LookOptions look;
  look.mode = DrawMode::smooth;
  return look;
}

/// Dials in the order of SixNumbers.
SixNumbers numbers_of(const Task& task, std::span<const double> values)
{
  check(values.size() == 6 && task.dials.size() == 6, "a pose task has six dials");
  SixNumbers place;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const auto k = static_cast<std::size_t>(axis);
    const bool is_deg = task.dials[k + 3].unit == "deg";
    place.shift_mm[axis] = values[k];
    place.turn_rad[axis] = is_deg ? rad_from_deg(values[k + 3]) : values[k + 3];
  }
  return place;
}

}  // namespace

ModelOnBench::ModelOnBench(const BenchFile& bench, const Calibration& calibration, MotionModel scaled,
                           const std::string& set)
    : scale(calibration.subject_scale),
      model(std::move(scaled)),
      motion(model, set),
      state(bench, calibration, motion, solver_frame(model, 0)),
      view(model, bench, calibration, plain_look())
{
}

PlacedModel::PlacedModel(const BenchFile& bench, MotionModel model, const std::string& file,
                         const std::string& set)
    : bench_(bench), model_(std::move(model)), set_(chosen_set(model_, file, set))
{
}

void PlacedModel::take(const Sample& sample)
{
  if (shown_) shown_->state.take(sample);
}

void PlacedModel::place(const Calibration& calibration, const PlaceTrial& trial, std::int64_t now_ns,
                        Renderer& renderer)
{
  if (!shown_ || shown_->scale != calibration.subject_scale) {
    shown_ = std::make_unique<ModelOnBench>(bench_, calibration,
                                            scaled_model(model_, calibration.subject_scale), set_);
    renderer.load(shown_->view.scene());
    renderer.load(shown_->view.warp());
  }
  Calibration& tried = shown_->state.values().calibration;
  tried = calibration;
  tried.X_body_model[static_cast<std::size_t>(role_of(trial.part))] = numbers_of(trial.task, trial.values);
  if (shown_->view.take(tried.eyes)) renderer.load(shown_->view.warp());
  shown_->view.place(shown_->state.frame(now_ns), tried);
}

namespace {

/// Scales a displayed line into the eye's window: the optics can display more than the window's pixels.
void fit_into_window(GuideLine& line, const Eye& eye)
{
  const ShownBox seen = shown_box(eye), window = box_of(eye.window);
  const Eigen::Vector2d seen_px = seen.high_px - seen.low_px, window_px = window.high_px - window.low_px;
  constexpr double filled = 0.98;
  const double scale = filled * window_px.cwiseQuotient(seen_px).minCoeff();
  const Eigen::Vector2d from = 0.5 * (seen.low_px + seen.high_px),
                        to = 0.5 * (window.low_px + window.high_px);
  for (Eigen::Vector2d& p : line.points_px) p = to + scale * (p - from);
}

class LiveBench final : public GuideBench {
 public:
  explicit LiveBench(const BenchFile& bench) : bench_(bench), devices_(bench.tracker, bench.board) {}

  void send_samples(GuideSession& session, PlacedModel* model) override
  {
    for (Sample sample; devices_.take(sample);) {
      session.take(sample);
      if (model != nullptr) model->take(sample);
    }
  }
  std::int64_t now_ns() const override { return devices_.now_ns(); }
  void zero_stage() override { devices_.zero_stage(); }
  std::vector<std::string> troubles(const Task& task) const override
  {
    std::vector<std::string> lines;
    const auto add = [&](const char* name, DeviceId device) {
      const DeviceReport report = devices_.report(device);
      if (report.link != LinkState::up) lines.push_back(device_text(name, report));
    };
    const bool wants_tracker = !task.tool.empty() || task.kind == TaskKind::place;
    const bool wants_board = task.kind == TaskKind::stop || task.kind == TaskKind::bullseye;
    if (wants_tracker && bench_.tracker) add("tracker", DeviceId::tracker);
    if (wants_board && bench_.board) add("board", DeviceId::board);
    return lines;
  }
  GuideView view(const GuideSession& session) const override
  {
    return {drawing_of(session), std::nullopt, {}};
  }

 private:
  const BenchFile& bench_;
  Devices devices_;
};

class VirtualBench final : public GuideBench {
 public:
  VirtualBench(const BenchFile& bench, std::uint64_t seed)
      : bench_(bench), truth_(virtual_truth(bench, seed)), operator_(bench, truth_, VirtualNoise{})
  {
  }

  void send_samples(GuideSession& session, PlacedModel*) override
  {
    if (session.task() != nullptr) operator_.send_samples(session);
  }
  std::int64_t now_ns() const override { return 0; }
  void zero_stage() override {}
  std::vector<std::string> troubles(const Task&) const override { return {}; }
  GuideView view(const GuideSession& session) const override
  {
    const EyePair& eyes = truth_.calibration.eyes;
    GuideView seen;
    seen.boxes = {box_of(eyes.left.window), box_of(eyes.right.window)};
    if (session.task() == nullptr) return seen;
    seen.lines = real_things(*session.task(), bench_, truth_);
    for (const GuideLine& line : seen_lines(drawn(session), truth_)) seen.lines.push_back(line);
    for (GuideLine& line : seen.lines) fit_into_window(line, line.is_right ? eyes.right : eyes.left);
    if (const std::optional<double> reading = operator_.reading(session)) {
      const std::vector<Dial>& dials = session.task()->dials;
      seen.notes.push_back("Reading: " + rounded_text(*reading, 2) +
                           (dials.empty() ? "" : " " + dials.front().unit));
    }
    return seen;
  }

 private:
  std::vector<GuideLine> drawn(const GuideSession& session) const
  {
    const GuideProgress& progress = session.progress();
    if (session.task()->kind != TaskKind::place) return drawing_of(session);
    return drawn_points({progress.part, session.values(), session.drawn_by()}, bench_, truth_);
  }

  const BenchFile& bench_;
  VirtualTruth truth_;
  VirtualOperator operator_;
};

}  // namespace

std::unique_ptr<GuideBench> open_live_bench(const BenchFile& bench)
{
  return std::make_unique<LiveBench>(bench);
}

std::unique_ptr<GuideBench> open_virtual_bench(const BenchFile& bench, std::uint64_t seed)
{
  return std::make_unique<VirtualBench>(bench, seed);
}

}  // namespace vrda
