/// Command `vrda-player body`: measures a rigid body of markers with the bench's tracker. In: positions of
/// the markers in the tracker's frame, mm. Out: their positions in the body's own frame, for the bench file.
/// Throws InputError if too few markers are seen together.
#pragma once

#include <string>
#include <vector>

#include "bench/bench_file.hpp"
#include "bench/sample.hpp"
#include "show/loop.hpp"
#include "bench/body_pose.hpp"
#include "bench/rigid_body.hpp"

namespace vrda::bench {

/// Groups marker samples by message.
class MarkerFrames {
 public:
  /// `first_tool`: index of the first marker in the order of BenchFile.
  MarkerFrames(std::size_t first_tool, std::size_t n_markers);

  /// Adds a sample, in order of arrival; ignores other tools.
  void take(const bench::Sample& sample);

  /// Frames with at least one visible marker; at most `most`, evenly selected.
  std::vector<bench::MarkerRow> frames(std::size_t most) const;

 private:
  void end_row();

  std::size_t first_tool_, n_markers_;
  std::vector<bool> has_come_;  ///< received in the current row
  bench::MarkerRow row_;
  std::vector<bench::MarkerRow> rows_;
};

/// Expected pose error for the noise estimated from the fit's residual; zero without a fit.
struct FitQuality {
  double residual_mm = 0.0;      ///< root mean square at the used markers
  int n_markers = 0;             ///< used markers
  double rotation_sd_rad = 0.0;  ///< standard deviation of the rotation about the least certain axis
  double centroid_sd_mm = 0.0;   ///< standard deviation of the centroid of the markers
};
FitQuality quality_of(const bench::PoseFit& fit);

/// "residual 0.12 mm at 4 markers, rotation sd 0.06 deg"; without a fit the reason.
std::string fit_text(const bench::PoseFit& fit);

struct MeasureBodyOptions {
  std::string role, bench;
  double seconds = 10.0;
  bool is_quiet = false;
};

/// Measures the body and writes its lines for the bench file, with residual and expected error as comments.
/// Throws InputError, also for markers that do not form a valid body.
void measure_body(const MeasureBodyOptions& options, const show::Streams& streams);

/// Builds the body from `frames`, in the frame of the file's markers_mm if present. Throws InputError with
/// the bench file, the body and its markers.
bench::BuiltBody build_measured_body(const std::vector<bench::MarkerRow>& frames,
                                        const bench::BenchFile& bench, bench::BodyRole role);

/// Lines of the body for the bench file.
std::string bench_file_lines(const bench::BuiltBody& built, const bench::BenchFile& bench,
                             bench::BodyRole role);

}  // namespace vrda::bench
