/// Somebody who does what the guide asks, with the noise of a hand and an eye.
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

/// Presses the keys and sends the samples that a real bench would: nothing else goes into the session.
class VirtualOperator {
 public:
  VirtualOperator(const BenchFile& bench, const VirtualTruth& truth, const VirtualNoise& noise);
  ~VirtualOperator();

  /// Does the task at hand to its end. A refusal is met by doing again what was asked.
  void do_task(GuideSession& session);
  int n_refusals() const;
  /// For somebody who trains, once a picture: a frame of the tracker and the stage for the task at hand.
  /// Meets zeroes_stage() as well. Nothing where no samples are wanted.
  void send_samples(GuideSession& session);
  /// What ruler, tape or pupillometer say, of a number that is asked for; nothing of other tasks.
  std::optional<double> reading(const GuideSession& session) const;

 private:
  struct Inner;
  std::unique_ptr<Inner> inner_;
};

/// Of the real things that the task at hand is aligned with, where that eye sees them, in px of the
/// undistorted picture ("shown"): the edge of the visible part, the grid, the rectangle, the marker, the
/// leg's points one after another. For training and pictures.
std::vector<GuideLine> real_things(const Task& task, const BenchFile& bench, const VirtualTruth& truth);

/// A model that is being placed by eye.
struct PlacedPoints {
  CalibrationPart part = CalibrationPart::leg;
  std::span<const double> values;  ///< of the task's dials: mm and degrees
  const Calibration& found;        ///< by which the guide draws
};
/// Its points one after another, in the frame buffer, with the head and the body at rest.
std::vector<GuideLine> drawn_points(const PlacedPoints& placed, const BenchFile& bench,
                                    const VirtualTruth& truth);

/// Where lines of the frame buffer are seen: through the true optics, what lies beyond the visible part left
/// out.
std::vector<GuideLine> seen_lines(std::span<const GuideLine> drawn, const VirtualTruth& truth);

/// The task at hand.
struct AskedFor {
  const Task& task;
  CalibrationPart part = CalibrationPart::viewport;
  const Calibration& found;  ///< so far: what the guide draws by
};

/// What a ruler, a tape or a pupillometer says; nothing of tasks that ask for no number.
std::optional<double> number_read(const AskedFor& asked, const BenchFile& bench, const VirtualTruth& truth,
                                  const VirtualNoise& noise, Draws& draws);

/// Where the dials stand when everything is seen aligned, in their order and units; nothing of tasks without
/// dials.
std::vector<double> dial_values(const AskedFor& asked, const BenchFile& bench, const VirtualTruth& truth,
                                const VirtualNoise& noise, Draws& draws);

}  // namespace vrda
