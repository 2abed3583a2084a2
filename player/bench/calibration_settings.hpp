/// The [calibration] table of a bench file: equipment and number of repeats of the calibration.
#pragma once

#include <string>
#include <vector>

#include "model/mesh.hpp"
#include "core/units.hpp"

namespace vrda::bench {

struct CalibrationRectangle {
  double width_mm = 0.0, depth_mm = 0.0;  ///< depth behind the plane of the first rectangle
};

struct CalibrationPoint {
  std::string name;
  Eigen::Vector3d p_model_mm = Eigen::Vector3d::Zero();  ///< canonical axes, as stored in the motion model
  bool is_target = false;                                ///< excluded from the fit
};

struct CalibrationLandmarks {
  std::string name;
  double model_mm = 0.0;  ///< distance between them in the model
};

/// Fewest marks of a fit of an eyepoint and of a distortion, and least range of their depths.
inline constexpr std::size_t least_rectangle_marks = 3;
inline constexpr double least_depth_range_mm = 1.0;
inline constexpr std::size_t least_grid_marks = 12;

struct FunctionalSettings {
  /// Initial noise of each tracked body: of each coordinate of its position, of the rotation about each axis.
  /// The fit estimates a common factor.
  double tracker_sd_mm = 0.3, tracker_sd_rad = rad_from_deg(0.3);
  /// Root mean square deviation of the subject's joint from the model along flexion: length, angle.
  double model_sd_mm = 1.0, model_sd_rad = rad_from_deg(2.0);
};

struct CalibrationSettings {
  bool is_present = false;  ///< the file contains the table

  int edge_repeats = 4;
  double screen_sd_mm = 0.1;  ///< of a ruler reading on the screen

  bool is_grid_adjusted = false;  ///< distortion = "adjust": a whole grid by coefficients; "marks": by node
  int grid_columns = 7, grid_rows = 5;
  int grid_repeats = 3;  ///< adjusted grids

  std::vector<CalibrationRectangle> rectangles = {{150, 0}, {200, 150}, {250, 300}, {300, 450}};
  int rectangle_repeats = 3;
  double alignment_sd_rad = rad_from_deg(0.3);  ///< of the display arms' line of sight about the table's Z
  double sight_sd_px = 3.0;                     ///< of the optical axis about the centre of the visible part

  bool has_pupillometer = true;
  double pupillometer_sd_mm = 0.5;
  double eye_height_sd_mm = 1.0;  ///< of the height difference of the eyes

  std::string probe = "probe";    ///< tracker tool with a pose
  std::string marker = "marker";  ///< tracker tool with a position, for the rails and the bull's-eyes
  int rail_samples = 200, pivot_samples = 300, hold_samples = 30;  ///< tracker samples: sweep, pivot, still
  int bullseyes = 9;

  bool is_model_adjusted =
      false;  ///< model = "adjust": pose by eye; "fiducials": points touched with the probe
  int model_repeats = 3;
  std::vector<CalibrationPoint> points;        ///< on the leg; on the femur with two bodies
  std::vector<CalibrationPoint> tibia_points;  ///< only with two bodies
  std::vector<CalibrationLandmarks> landmarks;

  int bends = 4, bend_samples = 300;  ///< functional: motions of the leg, tracker samples of each
  /// functional: noise of a tracked body, and deviation of the subject's joint from the model
  FunctionalSettings functional;
};

}  // namespace vrda::bench
