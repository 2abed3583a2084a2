/// Bodies that follow the joint ([[follower]]): their equilibrium at a position of the joint, and their
/// motion over the cells of a sweep (solve/README.md).
#pragma once

#include <memory>
#include <mutex>
#include <vector>

#include "job/case.hpp"
#include "model/step_record.hpp"
#include "solve/sweep.hpp"

namespace vrda::solve {

/// Equilibrium of one follower, for one thread. Scratch memory does not affect results.
class FollowerSolver {
 public:
  /// Its surfaces and those of the body of its coordinates, made when first needed; shared by threads.
  struct Shared {
    std::once_flag flag;
    std::shared_ptr<const Joint> joint;
  };

  /// `follower` is a row of the case's followers; the case and `shared` must outlive the solver.
  FollowerSolver(const job::Case& job_case, std::size_t follower, Shared& shared);
  ~FollowerSolver();
  FollowerSolver(FollowerSolver&&) noexcept;

  /// Pure. `placed`: the bodies before it. `seeds`: poses relative to the body of its coordinates; the result
  /// of the lowest energy is returned, of equal ones that of the earlier seed. Statuses:
  /// CoordinateEquilibrium::Task. The record's pose is in the follower's own solver frame.
  StepRecord solve(const BodyPoses& placed, const std::vector<Pose>& seeds);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// A body that a follower touches.
struct TouchedBody {
  const Body* body = nullptr;
  BodyIndex index = BodyIndex::reference;
  bool has_drawn = false;  ///< also its drawn parts
};

/// Whether that is the body `of` alone: one scene serves all poses.
bool touches_one_body(const std::vector<TouchedBody>& touched, BodyIndex of);

/// All of them as one mesh in the frame of the body `of`; offsets and overlaps of triangles come with them.
Mesh touched_mesh(const std::vector<TouchedBody>& touched, BodyIndex of, const BodyPoses& placed);

/// Of the step of a sample's follower, by its row.
inline constexpr std::int32_t most_in_step = 64;
inline StepKey sample_follower_key(std::int32_t flexion, std::int32_t sample, std::int32_t follower)
{
  return {StepKind::sample_follower, flexion, sample * most_in_step + follower};
}

/// The frame in which records of a follower are: centred on its centre, Delta its own.
SolverFrame follower_frame(const job::Case& job_case, const job::Follower& follower);

/// Of a record: the follower relative to the body of its coordinates, as stored vertices.
Pose follower_pose_of(const SolverFrame& frame, const StepRecord& record);

/// Of a cell of the joint, as stored vertices.
Pose joint_pose_of(const job::Case& job_case, const StepRecord& cell);

/// Fills `result.followers`: the followers of every stable cell, along the spine from the flexion nearest to
/// that of the meshes, or from the first frame, then along the rows of the plan. Cells of followers with a
/// reaction are replaced by those solved with it. A follower of a cell that is not stable, or after one
/// without a pose, has that status. False when stopped. Pure but for the hooks. `starts`: poses of the
/// followers relative to the bodies of their coordinates, from which the first step starts instead of those
/// of the scan; empty: of the scan.
bool follow(const job::Case& job_case, const SweepPlan& plan, const SolveStep& solve, const SweepHooks& hooks,
            int n_threads, SweepResult& result, const std::vector<Pose>& starts = {});

}  // namespace vrda::solve
