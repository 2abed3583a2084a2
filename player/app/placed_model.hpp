/// The model over a tracked leg while its place is adjusted by eye.
#pragma once

#include <memory>
#include <optional>

#include "app/bench_view.hpp"
#include "guide/task.hpp"

namespace vrda {

class PlacedModel {
 public:
  /// `model` at its own size, from `file`. Throws InputError where it has not the set.
  PlacedModel(const BenchFile& bench, MotionModel model, const std::string& file, const std::string& set);

  void take(const Sample& sample);

  /// Puts it where `values` of the dials of `task`, of that part, would have it; loads into the renderer what
  /// is new. Throws InputError where the eyes cannot be drawn for.
  void place(const Calibration& calibration, CalibrationPart part, const Task& task,
             std::span<const double> values, std::int64_t now_ns, Renderer& renderer);
  /// Placed before.
  const BenchView& view() const { return shown_->view; }

 private:
  struct Shown {
    Shown(const BenchFile& bench, const Calibration& calibration, MotionModel scaled, const std::string& set);
    double scale;
    MotionModel model;
    Motion motion;
    BenchState state;
    BenchView view;
  };

  BenchFile bench_;
  MotionModel model_;
  std::string set_;
  std::unique_ptr<Shown> shown_;
};

}  // namespace vrda
