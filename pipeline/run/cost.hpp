/// Cost estimate of a case: steps counted from its plan, and seconds, memory and bytes by constants measured
/// on one machine. For the accuracy see `cost_spread`.
#pragma once

#include <cstdint>

#include "solve/sweep.hpp"

namespace vrda::run {

/// Steps of a sweep. Exact if the balance stays in an inner column of the grid, no equilibrium is propagated
/// to a neighbouring flexion and every spine cell is stable.
struct StepCounts {
  std::int64_t chain = 0;     ///< of the spine, sequential
  std::int64_t restarts = 0;  ///< of a free spine, parallel over flexions
  std::int64_t bands = 0;     ///< steps with additional moments, in the rows
  std::int64_t cells = 0;     ///< other steps of the rows
  std::int64_t records = 0;   ///< final number of journal records, including spine cells found by walking

  std::int64_t spine() const { return chain + restarts; }
  std::int64_t rows() const { return bands + cells; }
  std::int64_t all() const { return spine() + rows(); }
};

/// Steps of the spine and of the rows in `plan`.
StepCounts step_counts(const solve::SweepPlan& plan);

/// Quantities that determine step times and file sizes.
struct CaseSize {
  bool is_search = false;  ///< stability search instead of equilibrium
  std::int64_t n_contact_triangles = 0;
  std::int64_t n_triangles = 0;  ///< including display-only meshes
  std::int64_t n_fibres = 0;
  std::int64_t n_flexion = 0;
  std::int64_t n_varus = 0;
  std::int64_t n_smoothed = 0;  ///< sets
  std::int64_t n_samples = 0;   ///< of an uncertain job; of a shard: its own
};

/// Processor seconds and bytes.
struct CaseCost {
  StepCounts steps;
  double load_s = 0.0;   ///< per task: meshes, trees
  double spine_s = 0.0;  ///< includes the sequential part chain_s
  double chain_s = 0.0;
  double rows_s = 0.0;
  double finish_s = 0.0;       ///< of a run or merge: smoothing, recontacting, file
  double memory_bytes = 0.0;   ///< peak of one process
  double journal_bytes = 0.0;  ///< of all journals
  double model_bytes = 0.0;

  double solving_s() const { return spine_s + rows_s; }
  double processor_s() const { return load_s + solving_s() + finish_s; }
};

CaseCost cost_of(const CaseSize& size, const StepCounts& steps);

/// Measured times are between the estimate divided and multiplied by this factor.
extern const double cost_spread;

}  // namespace vrda::run
