/// What a case will take: steps counted from its plan, and from them seconds, memory and bytes by constants
/// measured on one machine. An estimate: see `cost_spread`.
#pragma once

#include <cstdint>

#include "sweep/sweep.hpp"

namespace vrda {

/// Steps that a sweep solves when nothing unexpected happens: the balance stays in an inner column of the
/// grid, no place of rest is handed on to a neighbour, every spine cell is stable. Exact then.
struct StepCounts {
  std::int64_t chain = 0;     ///< of the spine, one after the other: nothing runs beside them
  std::int64_t restarts = 0;  ///< of a free spine: flexions side by side
  std::int64_t bands = 0;     ///< extra moments, in the rows
  std::int64_t cells = 0;     ///< the rest of the rows
  std::int64_t records = 0;   ///< what journals hold at the end, spine cells found by walking included

  std::int64_t spine() const { return chain + restarts; }
  std::int64_t rows() const { return bands + cells; }
  std::int64_t all() const { return spine() + rows(); }
};

/// Of the spine and of the rows that `plan` names.
StepCounts step_counts(const SweepPlan& plan);

/// What decides how long a step takes and how large the files are.
struct CaseSize {
  bool is_search = false;  ///< by the stability search, not by the equilibrium
  std::int64_t n_contact_triangles = 0;
  std::int64_t n_triangles = 0;  ///< with what is only drawn
  std::int64_t n_fibres = 0;
  std::int64_t n_flexion = 0;
  std::int64_t n_varus = 0;
  std::int64_t n_smoothed = 0;  ///< sets
};

/// Processor seconds and bytes.
struct CaseCost {
  StepCounts steps;
  double load_s = 0.0;   ///< of each task: meshes, trees
  double spine_s = 0.0;  ///< of which one after the other: chain_s
  double chain_s = 0.0;
  double rows_s = 0.0;
  double finish_s = 0.0;       ///< smoothing, return to contact, the file: of a run or of the merge
  double memory_bytes = 0.0;   ///< of a process, largest
  double journal_bytes = 0.0;  ///< all of them together
  double model_bytes = 0.0;

  double solving_s() const { return spine_s + rows_s; }
  double processor_s() const { return load_s + solving_s() + finish_s; }
};

CaseCost cost_of(const CaseSize& size, const StepCounts& steps);

/// Seconds of a measured case lie between its estimate divided and multiplied by this.
extern const double cost_spread;

}  // namespace vrda
