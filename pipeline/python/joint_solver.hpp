/// Single attitudes of a job, solved one after the other: the state behind `vrda.Joint`.
///
/// In: a job, rows of attitudes and loads, a start pose. Out: columns over the rows, degrees and mm as in
/// files, translations of the rotation centre (schemas/clinical.md). Numbers of rows that are not stable are
/// NaN.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "job/case.hpp"
#include "job/job.hpp"
#include "model/frames.hpp"
#include "solve/case_solver.hpp"

namespace vrda::python {

/// Rows of loads that replace those of the job; empty: the job's. Meanings and axes as in [push].
struct RowLoads {
  std::vector<double> force_n;          ///< [n] along Delta
  std::vector<double> lateral_force_n;  ///< [n, 2] across Delta: anterior, right
  std::vector<double> moment_nmm;       ///< [n] about Delta, right-knee sign of theta
  std::vector<double> varus_moment_nmm;
};

struct RowPlan {
  std::vector<double> flexion_deg;  ///< [n] in the order of solving
  std::vector<double> varus_deg;    ///< [n], or empty: varus is free
  RowLoads loads;
  /// X_reference_moving, row by row, from which the first row is solved; absent: the start pose of the job.
  std::optional<std::array<double, 16>> seed;
};

/// Columns over the rows.
struct RowResults {
  std::vector<std::int8_t> status;  ///< StepStatus
  std::vector<double> flexion_deg, varus_deg, internal_deg, anterior_mm, proximal_mm, lateral_mm, theta_deg;
  std::vector<double> X_reference_moving;  ///< [n, 4, 4]
  std::vector<double> gap_medial_mm, gap_lateral_mm, force_medial_n, force_lateral_n;
  std::vector<double> energy_nmm, flexion_moment_nmm, varus_moment_nmm;
  std::vector<double> strain, tension_n;  ///< [n, n_fibres]
  std::vector<std::int32_t> iterations;
};

class JointSolver {
 public:
  /// Throws InputError as load_case(), and for a job with [coordinates] or [scaling], whose attitudes or
  /// lengths are not those of a row.
  JointSolver(const std::string& job_file, const job::LoadOptions& options);

  const job::Case& job_case() const { return case_; }
  std::vector<std::string> fibre_names() const;

  /// Each row starts from the last stable one before it. `before_row` is called before each; what it throws
  /// ends the work. One call at a time: others wait. Throws InputError naming the argument.
  RowResults solve(const RowPlan& plan, const std::function<void()>& before_row);

 private:
  job::Push push_at(const RowPlan& plan, std::size_t row) const;
  SolverPosition seed_position(const std::array<double, 16>& seed, const SolverFrame& frame) const;
  void add_row(RowResults& results, const StepRecord& record, double flexion_rad,
               const SolverFrame& frame) const;
  void require_solvable(const RowPlan& plan) const;

  job::Job job_;
  job::Case case_;
  std::unique_ptr<solve::CaseSolver> solver_;
  std::mutex mutex_;
};

}  // namespace vrda::python
