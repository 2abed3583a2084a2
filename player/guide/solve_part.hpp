/// From a part's marks to numbers of the calibration.
#pragma once

#include <string>

#include "calibration/distortion_fit.hpp"
#include "calibration/eyepoint_fit.hpp"
#include "calibration/eyes_fit.hpp"
#include "calibration/fiducial_fit.hpp"
#include "calibration/table_fit.hpp"
#include "calibration/viewport_fit.hpp"
#include "guide/task.hpp"

namespace vrda {

/// `begun` with the part's estimate in its record and what it found in the calibration's own fields. All of
/// the part's tasks must have marks, and the parts that it rests on estimates. Throws PartRefusal, of the
/// fits and where the samples say that something moved.
Calibration solved_part(CalibrationPart part, const BenchFile& bench, const Calibration& begun,
                        const std::string& path);

/// What solving `part` takes from marks of earlier parts: throws InputError naming that part, when they do
/// not give it. To be asked before the part is begun, as its own marks are not to blame.
void require_earlier_marks(CalibrationPart part, const BenchFile& bench, const Calibration& begun,
                           const std::string& path);

/// The marks of one round alone, which ends with `done`: throws PartRefusal as solving them would, and
/// returns what is to be said of them.
std::vector<std::string> round_remarks(CalibrationPart part, const BenchFile& bench, const Calibration& begun,
                                       const Task& done, const std::string& path);

/// The samples of one mark alone: throws PartRefusal when something moved that had to rest.
void require_still(CalibrationPart part, const Task& task, const CalibrationMark& mark,
                   const std::string& path);

/// "left.k1 0.1023 +- 0.0012": a line for each number of an estimate with its 95 % interval, then its
/// remarks.
std::vector<std::string> lines_of(const Estimate& estimate);

/// Of one eye: its tasks' marks, in order. Each throws PartRefusal naming `path` as its fit does.
ViewportFit viewport_of(const BenchFile& bench, const Calibration& begun, bool is_right,
                        const std::string& path);
DistortionFit distortion_of(const BenchFile& bench, const Calibration& begun, bool is_right,
                            const std::string& path);
EyeRectangles eyepoint_of(const BenchFile& bench, const Calibration& begun, bool is_right,
                          const std::string& path);

/// The bench file's rectangles, each so often, without marks.
std::vector<RectangleMark> rectangles_of(const CalibrationSettings& settings);

/// Tasks of a part and their marks, of one eye where `is_right` says so.
struct MarkedTask {
  Task task;
  const CalibrationMark* mark = nullptr;
};
std::vector<MarkedTask> marked_tasks(CalibrationPart part, const BenchFile& bench, const Calibration& begun);
/// Of the tasks.
std::vector<std::string> names_of(std::span<const MarkedTask> tasks);

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
