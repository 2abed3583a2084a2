/// The mode `body`: a body of markers measured with the bench's tracker.
#pragma once

#include <string>
#include <vector>

#include "devices/sample.hpp"
#include "loop/loop.hpp"
#include "setup/bench_file.hpp"
#include "tracking/body_pose.hpp"
#include "tracking/rigid_body.hpp"

namespace vrda {

class MarkerFrames {
 public:
  /// The markers are the tracker's tools from `first_tool` on, as BenchFile lists them.
  MarkerFrames(std::size_t first_tool, std::size_t n_markers);

  /// In the order of arrival; other tools' samples are passed over.
  void take(const Sample& sample);

  /// Those that saw a marker, `most` of them at most, evenly chosen.
  std::vector<MarkerRow> frames(std::size_t most) const;

 private:
  void end_row();

  std::size_t first_tool_, n_markers_;
  std::vector<bool> has_come_;  ///< since the row began
  MarkerRow row_;
  std::vector<MarkerRow> rows_;
};

/// What the noise that the fit's own residual speaks for makes of the pose: the least certain turn about any
/// axis and the place of the markers' middle, standard deviations. Zero where there is no fit.
struct FitQuality {
  double residual_mm = 0.0;  ///< at the markers used, root mean square
  int n_markers = 0;         ///< used
  double turn_sd_deg = 0.0, middle_sd_mm = 0.0;
};
FitQuality quality_of(const PoseFit& fit);

/// "0.12 mm off at 4 markers, turns known to 0.06 deg"; without a fit why.
std::string fit_text(const PoseFit& fit);

struct MeasureBodyOptions {
  std::string role, bench;
  double seconds = 10.0;
  bool is_quiet = false;
};

/// Listens to the tracker and writes the body's lines for the bench file, with residual and expected error as
/// comments. Throws InputError, for markers that make no body too.
void measure_body(const MeasureBodyOptions& options, const Streams& streams);

/// The body that `frames` show, in the frame of the file's markers_mm where they stand there. Throws
/// InputError naming the bench file, the body and its markers.
BuiltBody body_from(const std::vector<MarkerRow>& frames, const BenchFile& bench, BodyRole role);

/// The lines.
std::string body_text(const BuiltBody& built, const BenchFile& bench, BodyRole role);

}  // namespace vrda
