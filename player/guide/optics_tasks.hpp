/// Tasks that need nothing but the display and somebody who looks into it (thesis 8.1 to 8.4), and the
/// subject's measures.
#pragma once

#include "guide/task.hpp"

namespace vrda {

std::vector<Task> viewport_tasks(const BenchFile& bench);
std::vector<Task> distortion_tasks(const BenchFile& bench, const Calibration& calibration);
std::vector<Task> eyepoint_tasks(const BenchFile& bench, const Calibration& calibration);
std::vector<Task> ipd_tasks(const BenchFile& bench);
std::vector<Task> subject_tasks(const BenchFile& bench);

/// "left eye"
std::string eye_text(bool is_right);
const Eye& eye_of(const Calibration& calibration, bool is_right);

}  // namespace vrda
