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
#include <tuple>
#include <vector>

#include "core/fields.hpp"
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

/// Columns of a follower over the rows: the attributes of vrda.FollowerSolution.
struct FollowerResults {
  std::string name;
  std::vector<std::int8_t> status;  ///< StepStatus
  std::vector<double> flexion_deg, rotation_deg, tilt_deg, anterior_mm, proximal_mm, lateral_mm;
  std::vector<double> X_of_follower;          ///< [n, 4, 4]
  std::vector<double> energy_nmm, tension_n;  ///< tension: [n, n_fibres]
};

/// The meanings are the docstrings.
constexpr auto fields_of(const FollowerResults*)
{
  using R = FollowerResults;
  return std::tuple{
      Field{"flexion", &R::flexion_deg, unit::degree, "(n,) degrees: flexion of the follower."},
      Field{"rotation", &R::rotation_deg, unit::degree, "(n,) degrees: rotation about the floating axis."},
      Field{"tilt", &R::tilt_deg, unit::degree, "(n,) degrees: rotation about its long axis."},
      Field{"anterior", &R::anterior_mm, unit::mm,
            "(n,) mm: displacement of its centre along the axes of the body of its coordinates."},
      Field{"proximal", &R::proximal_mm, unit::mm, "(n,) mm: the same, proximal."},
      Field{"lateral", &R::lateral_mm, unit::mm, "(n,) mm: the same, lateral on both sides."},
      Field{"energy", &R::energy_nmm, unit::nmm,
            "(n,) N mm: energy of its fibres and springs minus the work of its push."},
      Field{"tension", &R::tension_n, unit::n, "(n, fibres) N: tension of each of its fibres and lines."},
      Field{"X_of_follower", &R::X_of_follower, unit::mm,
            "(n, 4, 4) mm: takes its stored vertices to those of the body of its coordinates."},
      Field{"status_code", &R::status, unit::none,
            "(n,) int8: the codes of `status` in a motion model; 0 is stable."}};
}

/// Columns over the rows, which are the attributes of vrda.Solution under the names of fields_of().
struct RowResults {
  std::vector<std::int8_t> status;  ///< StepStatus
  std::vector<double> flexion_deg, varus_deg, internal_deg, anterior_mm, proximal_mm, lateral_mm, theta_deg;
  std::vector<double> X_reference_moving;  ///< [n, 4, 4]
  std::vector<double> gap_medial_mm, gap_lateral_mm, force_medial_n, force_lateral_n;
  std::vector<double> energy_nmm, flexion_moment_nmm, varus_moment_nmm;
  std::vector<double> strain, tension_n;  ///< [n, n_fibres]
  std::vector<std::int32_t> iterations;
  std::vector<FollowerResults> followers;  ///< in the order of the job
};

/// The meanings are the docstrings.
constexpr auto fields_of(const RowResults*)
{
  using R = RowResults;
  constexpr const char* gap = "(n,) mm: gap left along Delta; NaN without the compartment.";
  constexpr const char* force = "(n,) N: contact force along Delta of the compartment.";
  return std::tuple{
      Field{"flexion", &R::flexion_deg, unit::degree, "(n,) degrees: Grood-Suntay flexion."},
      Field{"varus", &R::varus_deg, unit::degree,
            "(n,) degrees: varus, adduction positive; the one found where it was free."},
      Field{"internal", &R::internal_deg, unit::degree, "(n,) degrees: internal rotation."},
      Field{"anterior", &R::anterior_mm, unit::mm,
            "(n,) mm: the rotation centre's moving point along the floating axis."},
      Field{"proximal", &R::proximal_mm, unit::mm, "(n,) mm: the same along the moving body's long axis."},
      Field{"lateral", &R::lateral_mm, unit::mm,
            "(n,) mm: the same along the flexion axis, lateral on both sides."},
      Field{"theta", &R::theta_deg, unit::degree, "(n,) degrees: rotation about Delta, right-knee sign."},
      Field{"gap_medial", &R::gap_medial_mm, unit::mm, gap},
      Field{"gap_lateral", &R::gap_lateral_mm, unit::mm, gap},
      Field{"force_medial", &R::force_medial_n, unit::n, force},
      Field{"force_lateral", &R::force_lateral_n, unit::n, force},
      Field{"energy", &R::energy_nmm, unit::nmm,
            "(n,) N mm: energy of the fibres minus the work of the loads."},
      Field{"flexion_moment", &R::flexion_moment_nmm, unit::nmm, "(n,) N mm: moment that holds the flexion."},
      Field{"varus_moment", &R::varus_moment_nmm, unit::nmm,
            "(n,) N mm: moment that holds the varus; 0 where free."},
      Field{"strain", &R::strain, unit::one, "(n, fibres): strain of each fibre, negative where slack."},
      Field{"tension", &R::tension_n, unit::n, "(n, fibres) N: tension of each fibre."},
      Field{"X_reference_moving", &R::X_reference_moving, unit::mm,
            "(n, 4, 4) mm: takes stored moving vertices to stored reference vertices, canonical axes."},
      Field{"status_code", &R::status, unit::none,
            "(n,) int8: the codes of `status` in a motion model; 0 is stable."},
      Field{"iterations", &R::iterations, unit::one, "(n,) int32: iterations of the solver."}};
}

class JointSolver {
 public:
  /// Throws InputError as load_case(), and for a job with [coordinates] or [scaling], whose attitudes or
  /// lengths are not those of a row.
  JointSolver(const std::string& job_file, const job::LoadOptions& options);

  const job::Case& job_case() const { return case_; }
  std::vector<std::string> fibre_names() const;
  std::vector<std::string> follower_names() const;
  /// Throws InputError for a name that the job does not have.
  const job::Follower& follower(const std::string& name) const;
  std::vector<std::string> follower_fibre_names(const std::string& name) const;

  /// Each row starts from the last stable one before it. `before_row` is called before each; what it throws
  /// ends the work. One call at a time: others wait. Throws InputError naming the argument.
  RowResults solve(const RowPlan& plan, const std::function<void()>& before_row);

 private:
  job::Push push_at(const RowPlan& plan, std::size_t row) const;
  solve::SolverPosition seed_position(const std::array<double, 16>& seed, const SolverFrame& frame) const;
  void add_row(RowResults& results, const StepRecord& record, double flexion_rad,
               const SolverFrame& frame) const;
  // Solves the followers of a row's record, which those with a reaction replace; `starts` are their last
  // poses, and become those of the row.
  void follow(StepRecord& record, RowResults& results, std::vector<Pose>& starts);
  void add_follower(std::size_t k, const StepRecord& record, model::BodyPoses& placed,
                    FollowerResults& results) const;
  void require_solvable(const RowPlan& plan) const;

  job::Job job_;
  job::Case case_;
  std::unique_ptr<solve::CaseSolver> solver_;
  bool is_varus_free_ = false;  ///< of the rows being solved
  std::mutex mutex_;
};

}  // namespace vrda::python
