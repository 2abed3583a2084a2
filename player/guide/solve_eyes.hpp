/// Parts that see one eye at a time: from marks to fits.
#pragma once

#include "calibration/distortion_fit.hpp"
#include "calibration/eyepoint_fit.hpp"
#include "calibration/viewport_fit.hpp"
#include "guide/task.hpp"

namespace vrda {

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

}  // namespace vrda
