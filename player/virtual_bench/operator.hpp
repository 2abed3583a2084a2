/// Simulated operator that does the guide's tasks with the noise of a hand and an eye.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "guide/drawing.hpp"
#include "guide/session.hpp"
#include "setup/calibration_record.hpp"
#include "simulation/draws.hpp"
#include "virtual_bench/truth.hpp"

namespace vrda {

/// Sends the key presses and samples of a real bench; the session receives nothing else.
class VirtualOperator {
 public:
  VirtualOperator(const BenchFile& bench, const VirtualTruth& truth, const VirtualNoise& noise);
  ~VirtualOperator();

  /// Completes the current task. If it is refused, the repeated task is done by the next call.
  void do_task(GuideSession& session);
  int n_refusals() const;
  /// For interactive training, once per frame: sends a tracker frame and the stage for the current task,
  /// and handles zeroes_stage(). Does nothing if no samples are required.
  void send_samples(GuideSession& session);
  /// Reading of ruler, tape or pupillometer for a task that requires a number; nullopt otherwise.
  std::optional<double> reading(const GuideSession& session) const;

 private:
  struct Inner;
  std::unique_ptr<Inner> inner_;
};

/// Outlines of the physical things that the current task is aligned with, as seen by the eye, in
/// undistorted px: edge of the visible area, grid, rectangle, marker, the leg's points in sequence. For
/// training and images.
std::vector<GuideLine> real_things(const Task& task, const BenchFile& bench, const VirtualTruth& truth);

/// A model placed by eye.
struct PlacedPoints {
  CalibrationPart part = CalibrationPart::leg;
  std::span<const double> values;  ///< values of the task's dials: mm and degrees
  const Calibration& found;        ///< calibration used for drawing
};
/// The model's points in sequence, in the frame buffer, with head and body at rest.
std::vector<GuideLine> drawn_points(const PlacedPoints& placed, const BenchFile& bench,
                                    const VirtualTruth& truth);

/// Where lines of the frame buffer are seen through the true optics, clipped to the visible area.
std::vector<GuideLine> seen_lines(std::span<const GuideLine> drawn, const VirtualTruth& truth);

/// The current task and its context.
struct AskedFor {
  const Task& task;
  CalibrationPart part = CalibrationPart::viewport;
  const Calibration& found;  ///< found so far, used for drawing
};

/// Simulated reading of a ruler, tape or pupillometer; nullopt if the task requires no number.
std::optional<double> number_read(const AskedFor& asked, const BenchFile& bench, const VirtualTruth& truth,
                                  const VirtualNoise& noise, Draws& draws);

/// Dial values at which everything appears aligned, in the order and units of the dials; empty if the task
/// has none.
std::vector<double> dial_values(const AskedFor& asked, const BenchFile& bench, const VirtualTruth& truth,
                                const VirtualNoise& noise, Draws& draws);

}  // namespace vrda
