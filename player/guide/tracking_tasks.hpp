/// Tasks that need the tracker or the stage (thesis 8.5).
#pragma once

#include "guide/task.hpp"

namespace vrda {

std::vector<Task> rail_tasks(const BenchFile& bench);
std::vector<Task> stop_tasks();
std::vector<Task> probe_tasks(const BenchFile& bench);
/// Of `part` bullseye or head.
std::vector<Task> bullseye_tasks(CalibrationPart part, const BenchFile& bench,
                                 const Calibration& calibration);
/// Of `part` leg, femur or tibia.
std::vector<Task> model_tasks(CalibrationPart part, const BenchFile& bench, const Calibration& calibration);

}  // namespace vrda
