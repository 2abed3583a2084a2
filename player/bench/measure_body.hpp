/// Command `vrda-player body`: measures a body of markers with the bench's tracker.
#pragma once

#include <string>
#include <vector>

#include "devices/sample.hpp"
#include "loop/loop.hpp"
#include "setup/bench_file.hpp"
#include "tracking/body_pose.hpp"
#include "tracking/rigid_body.hpp"

namespace vrda {

/// Groups marker samples by message.
class MarkerFrames {
 public:
  /// `first_tool`: index of the first marker in the order of BenchFile.
  MarkerFrames(std::size_t first_tool, std::size_t n_markers);

  /// Adds a sample, in order of arrival; ignores other tools.
  void take(const Sample& sample);

  /// Frames with at least one visible marker; at most `most`, evenly selected.
  std::vector<MarkerRow> frames(std::size_t most) const;

 private:
  void end_row();

  std::size_t first_tool_, n_markers_;
  std::vector<bool> has_come_;  ///< received in the current row
  MarkerRow row_;
  std::vector<MarkerRow> rows_;
};

/// Expected pose error for the noise estimated from the fit's residual; zero without a fit.
struct FitQuality {
  double residual_mm = 0.0;   ///< root mean square at the used markers
  int n_markers = 0;          ///< used markers
  double turn_sd_deg = 0.0;   ///< standard deviation of the rotation about the least certain axis
  double middle_sd_mm = 0.0;  ///< standard deviation of the centroid of the markers
};
FitQuality quality_of(const PoseFit& fit);

/// "residual 0.12 mm at 4 markers, rotation sd 0.06 deg"; without a fit the reason.
std::string fit_text(const PoseFit& fit);

struct MeasureBodyOptions {
  std::string role, bench;
  double seconds = 10.0;
  bool is_quiet = false;
};

/// Measures the body and writes its lines for the bench file, with residual and expected error as comments.
/// Throws InputError, also for markers that do not form a valid body.
void measure_body(const MeasureBodyOptions& options, const Streams& streams);

/// Builds the body from `frames`, in the frame of the file's markers_mm if present. Throws InputError with
/// the bench file, the body and its markers.
BuiltBody body_from(const std::vector<MarkerRow>& frames, const BenchFile& bench, BodyRole role);

/// Lines of the body for the bench file.
std::string body_text(const BuiltBody& built, const BenchFile& bench, BodyRole role);

}  // namespace vrda
