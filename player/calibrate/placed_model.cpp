#include "calibrate/placed_model.hpp"

#include <utility>

#include "core/error.hpp"
#include "core/units.hpp"
#include "guide/parts.hpp"
#include "store/scaled_model.hpp"
#include "store/solved_cells.hpp"
#include "view/arguments.hpp"

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
  check(values.size() == 6 && task.dials.size() == 6, "a place has six dials");
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

}  // namespace vrda
