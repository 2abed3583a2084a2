/// The [calibration] table of a bench file: what the bench is calibrated with.
#pragma once

#include <string>
#include <vector>

#include "core/mesh.hpp"

namespace vrda {

struct Document;

struct CalibrationRectangle {
  double width_mm = 0.0, depth_mm = 0.0;  ///< depth behind the first one's plane
};

struct CalibrationPoint {
  std::string name;
  Eigen::Vector3d p_model_mm = Eigen::Vector3d::Zero();  ///< canonical axes, as the motion model stores them
  bool is_target = false;                                ///< held out of the fit
};

struct CalibrationLandmarks {
  std::string name;
  double model_mm = 0.0;  ///< distance in the model
};

struct CalibrationSettings {
  bool is_present = false;  ///< the table stands in the file

  int edge_repeats = 4;
  double screen_sd_mm = 0.1;  ///< of the ruler

  bool is_grid_adjusted =
      false;  ///< distortion = "adjust": a whole grid by its coefficients; "marks": node by node
  int grid_columns = 7, grid_rows = 5;
  int grid_repeats = 3;  ///< adjusted grids

  std::vector<CalibrationRectangle> rectangles = {{150, 0}, {200, 150}, {250, 300}, {300, 450}};
  int rectangle_repeats = 3;
  double alignment_sd_deg = 0.3;  ///< of the arms' sight about the table's Z
  double sight_sd_px = 3.0;       ///< of the optical axis from the middle of the visible part

  bool has_pupillometer = true;
  double pupillometer_sd_mm = 0.5;
  double eye_height_sd_mm = 1.0;  ///< of one eye above the other

  std::string probe = "probe";    ///< tool of the tracker: a place
  std::string marker = "marker";  ///< tool of the tracker: a position, on the rails and for bull's-eyes
  int rail_samples = 200, pivot_samples = 300, hold_samples = 30;  ///< tracker samples of a sweep; held still
  int bullseyes = 9;

  bool is_model_adjusted = false;  ///< model = "adjust": six numbers by eye; "fiducials": touched
  int model_repeats = 3;
  std::vector<CalibrationPoint> points;        ///< on the leg, or on the femur where two bodies are tracked
  std::vector<CalibrationPoint> tibia_points;  ///< two bodies
  std::vector<CalibrationLandmarks> landmarks;
};

/// Of a checked bench file. Throws InputError naming file and key of what does not fit together.
CalibrationSettings calibration_settings_of(const Document& document);

}  // namespace vrda
