/// The bench of a calibration session (real devices or simulated ones), and the motion model whose pose is
/// adjusted by eye. Poses take points of the second-named body to the first, mm; dial values have the units
/// of their task.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "bench/bench_show.hpp"
#include "calibration/calibrate.hpp"
#include "calibration/joint_curve.hpp"
#include "calibration/operator.hpp"

namespace vrda::calibration {

/// A model with motion, state and view as in the mode `bench`.
struct ModelOnBench {
  /// `scaled`: model in the size of the calibration's subject.
  ModelOnBench(const BenchFile& bench, const Calibration& calibration, store::MotionModel scaled,
               const std::string& set);
  ModelOnBench(const ModelOnBench&) = delete;
  ModelOnBench& operator=(const ModelOnBench&) = delete;

  double scale;
  store::MotionModel model;
  store::Motion motion;
  bench::BenchState state;
  bench::BenchView view;
};

/// A model pose being adjusted: part, task and current dial values.
struct PoseTrial {
  CalibrationPart part;
  const Task& task;
  std::span<const double> values;
};

/// Model drawn at the pose being adjusted.
class AdjustedModel {
 public:
  /// `model`: unscaled, from `file`. Throws InputError if it does not contain the set.
  AdjustedModel(const BenchFile& bench, store::MotionModel model, const std::string& file,
                const std::string& set);

  void take(const bench::Sample& sample);

  /// Places the model at `trial` and loads changes into the renderer. Throws InputError for unusable eyes.
  void place(const Calibration& calibration, const PoseTrial& trial, std::int64_t now_ns,
             view::Renderer& renderer);
  /// Requires place().
  const bench::BenchView& view() const { return shown_->view; }

 private:
  BenchFile bench_;
  store::MotionModel model_;
  std::string set_;
  std::unique_ptr<ModelOnBench> shown_;
};

/// Contents of the window for a task, in window pixels.
struct CalibrationView {
  std::vector<DrawnLine> lines;
  std::optional<std::array<view::ShownBox, 2>> boxes;  ///< clip box of each eye; empty: no clipping
  std::vector<std::string> notes;                        ///< simulated readings
};

class CalibrationBench {
 public:
  virtual ~CalibrationBench() = default;
  /// Passes the device samples since the last call to session and model.
  virtual void send_samples(CalibrationSession& session, AdjustedModel* model) = 0;
  /// Clock of the samples, ns.
  virtual std::int64_t now_ns() const = 0;
  virtual void zero_stage() = 0;
  /// Problems of the devices that the task needs; empty: none.
  virtual std::vector<std::string> device_problems(const Task& task) const = 0;
  /// How far the dials are from the truth; empty if the truth is unknown or there are no dials.
  virtual std::optional<calibration::VirtualOperator::Deviation> deviation(
      const CalibrationSession& session) const = 0;
  /// View of the current task.
  virtual CalibrationView view(const CalibrationSession& session) const = 0;
};

/// Tracker and board of the bench file.
std::unique_ptr<CalibrationBench> open_live_bench(const BenchFile& bench);
/// Virtual bench, drawn as its person sees it.
std::unique_ptr<CalibrationBench> open_virtual_bench(const BenchFile& bench, const VirtualTruth& truth,
                                                     const VirtualNoise& noise);

/// Motion of the file's model along its flexion, mm and rad, unscaled: poses at steps of about 2 degrees,
/// each at the set's own or balanced varus. Throws InputError with the file: a sequence of frames, one
/// flexion only, an unsolved pose.
calibration::JointCurve joint_curve(const std::string& file, const std::string& set);

}  // namespace vrda::calibration
