/// Estimates the numbers of one part of a calibration from its marks, with residuals and 95 % intervals;
/// units of schemas/calibration.md. A fit that fails throws PartRefusal, which names part and reason.
#pragma once

#include <string>

#include "calibration/distortion_fit.hpp"
#include "calibration/eyepoint_fit.hpp"
#include "calibration/eyes_fit.hpp"
#include "calibration/fiducial_fit.hpp"
#include "calibration/functional_fit.hpp"
#include "calibration/table_fit.hpp"
#include "calibration/task.hpp"

namespace vrda::calibration {

/// Returns `begun` with the estimate in the part's record and in the calibration values. All tasks must have
/// marks and all dependencies estimates. Throws PartRefusal if a fit fails or a static measurement moved.
Calibration solve_part(CalibrationPart part, const PartInput& in);

/// Checks the fits of earlier marks that solving `part` repeats; throws InputError with the earlier part. To
/// be called before the part starts.
void require_earlier_fits(CalibrationPart part, const PartInput& in);

/// Solves only the task group that ends with `done` and returns its remarks. Throws PartRefusal.
std::vector<std::string> group_remarks(CalibrationPart part, const Task& done, const PartInput& in);

/// Throws PartRefusal if the samples of a static measurement moved.
void require_static(CalibrationPart part, const Task& task, const CalibrationMark& mark,
                    const std::string& path);

/// "PART is done:"; one line per number with its 95 % interval ("left.k1 0.1023 +- 0.0012"), then residual
/// and remarks.
std::vector<std::string> result_lines(CalibrationPart part, const bench::Estimate& estimate);

/// Fits of one eye to the marks of its tasks. Throw PartRefusal with `path`.
bench::Estimate solve_viewport(const PartInput& in, bool is_right);
calibration::DistortionFit solve_distortion(const PartInput& in, bool is_right);
calibration::EyeRectangles solve_eye_rectangles(const PartInput& in, bool is_right);

/// Rectangles of the bench file with their repeats, without measured positions.
std::vector<calibration::RectangleMark> rectangles_of(const CalibrationSettings& settings);

/// A task with its mark, or nullptr.
struct MarkedTask {
  Task task;
  const CalibrationMark* mark = nullptr;
};
std::vector<MarkedTask> marked_tasks(CalibrationPart part, const PartInput& in);
/// Names of the tasks.
std::vector<std::string> names_of(std::span<const MarkedTask> tasks);

/// Checks the sweep of the rail task `done`. Throws PartRefusal.
void require_good_rail(const Task& done, const PartInput& in);

/// Fits of table and probe. Throw PartRefusal with `path`.
calibration::TableFit solve_table(const PartInput& in);
calibration::PivotFit solve_pivot(const PartInput& in);

/// `part`: bullseye or head. With a stage the covariance of the pose includes the error of the table.
calibration::EyesFit solve_eye_pose(CalibrationPart part, const PartInput& in);

/// `part`: leg, femur or tibia. The covariance includes the errors of probe tip and scale.
calibration::FiducialFit solve_model_pose(CalibrationPart part, const PartInput& in);

/// Touched points of a model part, in the frame of its body.
std::vector<calibration::Fiducial> touched_points(CalibrationPart part, const PartInput& in);

/// Placement of both bones from the marks of the part functional, starting from the estimates of femur and
/// tibia. Uses the model's motion of the record. Throws PartRefusal.
calibration::FunctionalFit solve_functional(const PartInput& in);
/// Remarks on one bend. Throws PartRefusal if its range of flexion is too small.
std::vector<std::string> bend_remarks(const Task& done, const PartInput& in);

/// Mean and scatter of repeated positions.
struct MeanPosition {
  Eigen::Vector3d p_mm = Eigen::Vector3d::Zero();
  double sd_mm = 0.0;  ///< standard deviation of a coordinate of one sample
  double furthest_mm = 0.0;
};
MeanPosition mean_position(const std::vector<Eigen::Vector3d>& places);
/// Marker positions of a bull's-eye, in the frame of the head's body if it is tracked, else of the tracker.
std::vector<Eigen::Vector3d> marker_positions(const CalibrationMark& mark);

}  // namespace vrda::calibration
