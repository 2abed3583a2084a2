/// Simulated operator that does the guide's tasks with the noise of a hand and an eye.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "bench_files/calibration_record.hpp"
#include "calibration_tasks/drawing.hpp"
#include "calibration_tasks/session.hpp"
#include "simulation/draws.hpp"
#include "virtual_bench/truth.hpp"

namespace vrda::virtual_bench {

/// Sends the key presses and samples of a real bench; the session receives nothing else.
class VirtualOperator {
 public:
  VirtualOperator(const bench_files::BenchFile& bench, const VirtualTruth& truth, const VirtualNoise& noise);
  ~VirtualOperator();

  /// Completes the current task. If it is refused, the repeated task is done by the next call.
  void do_task(calibration_tasks::CalibrationSession& session);
  int n_refusals() const;
  /// For interactive training, once per frame: sends a tracker frame and the stage for the current task,
  /// and handles zeroes_stage(). Does nothing if no samples are required.
  void send_samples(calibration_tasks::CalibrationSession& session);
  /// Reading of ruler, tape or pupillometer for a task that requires a number; nullopt otherwise.
  std::optional<double> reading(const calibration_tasks::CalibrationSession& session) const;

 private:
  struct Inner;
  std::unique_ptr<Inner> inner_;
};

/// Outlines of the physical things that the current task is aligned with, as seen by the eye, in
/// undistorted px: edge of the visible area, grid, rectangle, marker, the leg's points in sequence. For
/// training and images.
std::vector<calibration_tasks::DrawnLine> physical_outlines(const calibration_tasks::Task& task,
                                                            const bench_files::BenchFile& bench,
                                                            const VirtualTruth& truth);

/// A model placed by eye.
struct ModelPlacement {
  bench_files::CalibrationPart part = bench_files::CalibrationPart::leg;
  std::span<const double> values;         ///< values of the task's dials: mm and degrees
  const bench_files::Calibration& found;  ///< calibration used for drawing
};
/// The model's points in sequence, in the frame buffer, with head and body at rest.
std::vector<calibration_tasks::DrawnLine> drawn_model_lines(const ModelPlacement& placed,
                                                            const bench_files::BenchFile& bench,
                                                            const VirtualTruth& truth);

/// Where lines of the frame buffer are seen through the true optics, clipped to the visible area.
std::vector<calibration_tasks::DrawnLine> seen_lines(std::span<const calibration_tasks::DrawnLine> drawn,
                                                     const VirtualTruth& truth);

/// The current task and its context.
struct TaskContext {
  const calibration_tasks::Task& task;
  bench_files::CalibrationPart part = bench_files::CalibrationPart::viewport;
  const bench_files::Calibration& found;  ///< found so far, used for drawing
};

/// Simulated reading of a ruler, tape or pupillometer; nullopt if the task requires no number.
std::optional<double> simulated_reading(const TaskContext& asked, const bench_files::BenchFile& bench,
                                        const VirtualTruth& truth, const VirtualNoise& noise,
                                        simulation::RandomSequence& draws);

/// Dial values at which everything appears aligned, in the order and units of the dials; empty if the task
/// has none.
std::vector<double> dial_values(const TaskContext& asked, const bench_files::BenchFile& bench,
                                const VirtualTruth& truth, const VirtualNoise& noise,
                                simulation::RandomSequence& draws);

}  // namespace vrda::virtual_bench
