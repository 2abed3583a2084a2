/// From a Case to what the solver and the sweep work on.
#pragma once

#include "load/case.hpp"
#include "solve/joint.hpp"
#include "sweep/sweep.hpp"

namespace vrda {

/// Both objects as the solver sees them with the Delta of `frame`.
Joint joint_of(const Case& job_case, const SolverFrame& frame);
SweepPlan plan_of(const Case& job_case);

/// One SHA-256 for everything that decides the steps: solver version, resolved job, inputs. Where scaling
/// keeps the steps it is the unscaled job's, so one journal serves every size.
std::string fingerprint_of(const Case& job_case);

}  // namespace vrda
