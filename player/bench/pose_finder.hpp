/// Poses of the printed bodies in one grey picture of a calibrated camera.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "model/mesh.hpp"
#include "bench/body_sheet.hpp"
#include "bench/camera.hpp"

namespace vrda::bench {

enum class BodyState {
  seen,
  hidden,     ///< no marker visible
  ambiguous,  ///< too few markers to know the tilt: one, or two of a face far away
  misfit      ///< the markers do not fit the body: wrong fold, bent sheet, or a false marker
};
const char* name_of(BodyState state);

struct FoundBody {
  BodyState state = BodyState::hidden;
  /// Camera axes: x right, y down, z forwards; mm. Valid if seen.
  Pose X_camera_body = Pose::Identity();
  int n_markers = 0;
  double rms_px = 0.0;  ///< distance of the corners from their projections
};

struct PoseFinderOptions {
  BodySheet sheet;
  std::size_t n_bodies = 2;
  /// Corners of a correct body are within 0.6 px at 1 m with blur and noise; a fold 30 degrees wrong gives
  /// more than 1 px. A wrong focal length or size of the markers changes the distance, not the fit.
  double most_rms_px = 1.0;
  double remembered_s = 0.5;  ///< the last pose resolves an ambiguous one for this long
};

class PoseFinder {
 public:
  PoseFinder(const Camera& camera, const PoseFinderOptions& options);
  ~PoseFinder();

  /// `time_s`: of the picture, ascending. Throws InputError if the picture's size is not the camera's.
  std::vector<FoundBody> find(const GreyPicture& picture, double time_s);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace vrda::bench
