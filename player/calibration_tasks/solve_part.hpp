/// Solves a part from its marks.
#pragma once

#include <string>

#include "calibration/distortion_fit.hpp"
#include "calibration/eyepoint_fit.hpp"
#include "calibration/eyes_fit.hpp"
#include "calibration/fiducial_fit.hpp"
#include "calibration/table_fit.hpp"
#include "calibration/viewport_fit.hpp"
#include "calibration_tasks/task.hpp"

namespace vrda::calibration_tasks {

/// Returns `begun` with the estimate in the part's record and in the calibration values. All tasks must have
/// marks and all dependencies estimates. Throws PartRefusal if a fit fails or a static measurement moved.
bench_files::Calibration solve_part(bench_files::CalibrationPart part, const bench_files::BenchFile& bench,
                                    const bench_files::Calibration& begun, const std::string& path);

/// Checks the fits of earlier marks that solving `part` repeats; throws InputError with the earlier part. To
/// be called before the part starts.
void require_earlier_fits(bench_files::CalibrationPart part, const bench_files::BenchFile& bench,
                          const bench_files::Calibration& begun, const std::string& path);

/// Solves only the task group that ends with `done` and returns its remarks. Throws PartRefusal.
std::vector<std::string> group_remarks(bench_files::CalibrationPart part, const bench_files::BenchFile& bench,
                                       const bench_files::Calibration& begun, const Task& done,
                                       const std::string& path);

/// Throws PartRefusal if the samples of a static measurement moved.
void require_static(bench_files::CalibrationPart part, const Task& task,
                    const bench_files::CalibrationMark& mark, const std::string& path);

/// One line per number with its 95 % interval ("left.k1 0.1023 +- 0.0012"), then residual and remarks.
std::vector<std::string> estimate_lines(const calibration::Estimate& estimate);

/// Fits of one eye to the marks of its tasks. Throw PartRefusal with `path`.
calibration::ViewportFit solve_viewport(const bench_files::BenchFile& bench,
                                        const bench_files::Calibration& begun, bool is_right,
                                        const std::string& path);
calibration::DistortionFit solve_distortion(const bench_files::BenchFile& bench,
                                            const bench_files::Calibration& begun, bool is_right,
                                            const std::string& path);
calibration::EyeRectangles solve_eye_rectangles(const bench_files::BenchFile& bench,
                                                const bench_files::Calibration& begun, bool is_right,
                                                const std::string& path);

/// Rectangles of the bench file with their repeats, without measured positions.
std::vector<calibration::RectangleMark> rectangles_of(const bench_files::CalibrationSettings& settings);

/// A task with its mark, or nullptr.
struct MarkedTask {
  Task task;
  const bench_files::CalibrationMark* mark = nullptr;
};
std::vector<MarkedTask> marked_tasks(bench_files::CalibrationPart part, const bench_files::BenchFile& bench,
                                     const bench_files::Calibration& begun);
/// Names of the tasks.
std::vector<std::string> names_of(std::span<const MarkedTask> tasks);

/// Checks the sweep of the rail task `done`. Throws PartRefusal.
void require_good_rail(const Task& done, const bench_files::BenchFile& bench,
                       const bench_files::Calibration& begun, const std::string& path);

/// Fits of table and probe. Throw PartRefusal with `path`.
calibration::TableFit solve_table(const bench_files::BenchFile& bench, const bench_files::Calibration& begun,
                                  const std::string& path);
calibration::PivotFit solve_pivot(const bench_files::BenchFile& bench, const bench_files::Calibration& begun,
                                  const std::string& path);

/// `part`: bullseye or head. With a stage the covariance of the pose includes the error of the table.
calibration::EyesFit solve_eye_pose(bench_files::CalibrationPart part, const bench_files::BenchFile& bench,
                                    const bench_files::Calibration& begun, const std::string& path);

/// `part`: leg, femur or tibia. The covariance includes the errors of probe tip and scale.
calibration::FiducialFit solve_model_pose(bench_files::CalibrationPart part,
                                          const bench_files::BenchFile& bench,
                                          const bench_files::Calibration& begun, const std::string& path);

/// Mean and scatter of repeated positions.
struct MeanPosition {
  Eigen::Vector3d p_mm = Eigen::Vector3d::Zero();
  double sd_mm = 0.0;  ///< standard deviation of a coordinate of one sample
  double furthest_mm = 0.0;
};
MeanPosition mean_position(const std::vector<Eigen::Vector3d>& places);
/// Marker positions of a bull's-eye, in the frame of the head's body if it is tracked, else of the tracker.
std::vector<Eigen::Vector3d> marker_positions(const bench_files::CalibrationMark& mark);

}  // namespace vrda::calibration_tasks
