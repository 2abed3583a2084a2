/// The motion of one sample of an uncertain job: one step at each flexion, varus free (or by the roles of its
/// coordinates), started from the equilibria of the job and from the sample's own neighbouring flexions.
#pragma once

#include <functional>

#include "solve/sweep.hpp"

namespace vrda::solve {

struct SampleOptions {
  std::int32_t sample = 0;           ///< number of the sample, in the keys
  std::function<bool()> is_stopped;  ///< polled
};

/// `job` is the result of `plan`, whose spine has a free varus; `solve` solves the steps of the sample's
/// case. Records [n_flexion] of kind `sample`, measured; a flexion without an equilibrium keeps the status of
/// its first start. Empty when stopped. Pure, like `solve`.
std::vector<StepRecord> sample_motion(const SweepPlan& plan, const SweepResult& job, const SolveStep& solve,
                                      const SampleOptions& options);

}  // namespace vrda::solve
