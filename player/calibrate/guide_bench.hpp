/// What stands before an operator: a bench with its devices, or one that exists in numbers, and the model
/// that is placed by eye.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "bench/bench_show.hpp"
#include "guide/drawing.hpp"
#include "guide/session.hpp"
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

/// What the window shows of a task, in its pixels.
struct GuideView {
  std::vector<GuideLine> lines;
  std::optional<std::array<ShownBox, 2>> boxes;  ///< where each eye's lines end; nothing: nowhere
  std::vector<std::string> notes;                ///< what a ruler says
};

class GuideBench {
 public:
  virtual ~GuideBench() = default;
  /// What the devices said since the last call.
  virtual void send_samples(GuideSession& session, PlacedModel* model) = 0;
  /// ns of the samples' clock.
  virtual std::int64_t now_ns() const = 0;
  virtual void zero_stage() = 0;
  /// Of devices that the task at hand waits for; empty: all answer.
  virtual std::vector<std::string> troubles(const Task& task) const = 0;
  /// Of the task at hand.
  virtual GuideView view(const GuideSession& session) const = 0;
};

/// Tracker and board of the bench file.
std::unique_ptr<GuideBench> open_live_bench(const BenchFile& bench);
/// The virtual bench of that seed, seen as its person sees it.
std::unique_ptr<GuideBench> open_virtual_bench(const BenchFile& bench, std::uint64_t seed);

}  // namespace vrda
