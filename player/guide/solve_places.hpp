/// Parts of the tracker: from samples to places.
#pragma once

#include "calibration/eyes_fit.hpp"
#include "calibration/fiducial_fit.hpp"
#include "calibration/pivot_fit.hpp"
#include "calibration/table_fit.hpp"
#include "guide/solve_eyes.hpp"

namespace vrda {

/// The sweep of task `done` of rails alone: throws PartRefusal as the table's fit would.
void require_good_rail(const Task& done, const BenchFile& bench, const Calibration& begun,
                       const std::string& path);

/// Each throws PartRefusal naming `path` as its fit does.
TableFit table_of(const BenchFile& bench, const Calibration& begun, const std::string& path);
PivotFit pivot_of(const BenchFile& bench, const Calibration& begun, const std::string& path);

/// Of `part` bullseye or head. On a stage the covariance of the eyes' place holds that of the table, too.
EyesFit eyes_of(CalibrationPart part, const BenchFile& bench, const Calibration& begun,
                const std::string& path);

/// Of `part` leg, femur or tibia. The covariance holds those of the probe's tip and of the subject's scale.
FiducialFit model_of(CalibrationPart part, const BenchFile& bench, const Calibration& begun,
                     const std::string& path);

/// Mean and noise of places that should be one.
struct MeanPlace {
  Eigen::Vector3d p_mm = Eigen::Vector3d::Zero();
  double sd_mm = 0.0;  ///< of a coordinate of one sample
  double furthest_mm = 0.0;
};
MeanPlace mean_place(const std::vector<Eigen::Vector3d>& places);
/// Of a bull's-eye's samples: the marker, in the frame of the head's body where that is tracked.
std::vector<Eigen::Vector3d> marker_places(const CalibrationMark& mark);

}  // namespace vrda
