/// The model over a tracked leg while its place is adjusted by eye.
#pragma once

#include <memory>
#include <span>

#include "bench/bench_view.hpp"
#include "guide/task.hpp"

namespace vrda {

/// A joint as the bench shows it.
struct ModelOnBench {
  /// `scaled`: as large as the calibration's subject.
  ModelOnBench(const BenchFile& bench, const Calibration& calibration, MotionModel scaled,
               const std::string& set);
  ModelOnBench(const ModelOnBench&) = delete;
  ModelOnBench& operator=(const ModelOnBench&) = delete;

  double scale;
  MotionModel model;
  Motion motion;
  BenchState state;
  BenchView view;
};

/// A place under way: the task of a part, and its dials as they stand.
struct PlaceTrial {
  CalibrationPart part;
  const Task& task;
  std::span<const double> values;
};

class PlacedModel {
 public:
  /// `model` at its own size, from `file`. Throws InputError where it has not the set.
  PlacedModel(const BenchFile& bench, MotionModel model, const std::string& file, const std::string& set);

  void take(const Sample& sample);

  /// Puts it where `trial` would have it; loads into the renderer what is new. Throws InputError where the
  /// eyes cannot be drawn for.
  void place(const Calibration& calibration, const PlaceTrial& trial, std::int64_t now_ns,
             Renderer& renderer);
  /// Placed before.
  const BenchView& view() const { return shown_->view; }

 private:
  BenchFile bench_;
  MotionModel model_;
  std::string set_;
  std::unique_ptr<ModelOnBench> shown_;
};

}  // namespace vrda
