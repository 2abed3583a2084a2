/// What holds the poses of a motion model: contact paths, forces and balances of the equilibrium, ligaments.
#pragma once

#include "load/case.hpp"
#include "store/motion_model.hpp"
#include "sweep/sweep.hpp"

namespace vrda {

/// Fibres and wraps as the file keeps them, without any cell.
LigamentRows ligament_rows(const Ligaments& canonical);

/// Fills those members of `model` that it has: contact_paths, equilibrium, ligaments. Poses and contacts are
/// there already.
void add_balance(MotionModel& model, const Case& job_case, const SweepResult& result);

}  // namespace vrda
