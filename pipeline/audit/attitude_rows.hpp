/// The attitudes at which a motion is measured, shared out over threads by flexion.
#pragma once

#include <functional>
#include <vector>

#include "audit/pose_meter.hpp"
#include "motion/poses.hpp"
#include "store/motion_model.hpp"

namespace vrda {

/// `axis_deg` with each step cut into `refine` parts; its own values stay to the last bit.
std::vector<double> refined(const std::vector<double>& axis_deg, int refine);

/// Calls `measure(row, meter)` for every row of `flexion_deg`, each once, from `n_threads` threads; the meter
/// is that of the row's Delta. What `measure` writes must belong to its row. Its first exception is thrown
/// again.
void for_each_row(const MotionModel& model, const Motion& motion, const std::vector<double>& flexion_deg,
                  int n_threads, const std::function<void(std::size_t, PoseMeter&)>& measure);

}  // namespace vrda
