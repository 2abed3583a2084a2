// One motion step of the generic knee from the same start, by rigid-body dynamics and by the equilibrium.
#include <benchmark/benchmark.h>

#include <cmath>

#include "core/text.hpp"
#include "processor_time.hpp"
#include "rigid_body.hpp"
#include "scene.hpp"
#include "solve/case_solver.hpp"

namespace vrda::benchmarks {
namespace {

constexpr double start_below_mm = 2.0;
constexpr double neighbour_deg = 5.0;  // difference in flexion of the start's attitude
constexpr int n_solved = 20;           // repetitions of the equilibrium for timing

struct Knee {
  job::Case job_case = case_of("generic", {"solver.method=equilibrium"});
  solve::Joint joint = solve::joint_of(job_case, job_case.frame);
  solve::EquilibriumSolver solver{joint, job_case.ligaments, job_case.equilibrium};
  geometry::GapQuery gap{joint.reference_gap, joint.moving_gap};
  RigidPair bodies{joint.reference.tree_mesh.mesh, joint.moving.tree_mesh.mesh, {}};
};

Knee& knee()
{
  static Knee made;
  return made;
}

double travel_left_mm(const Attitude& attitude, const MovingPose& pose)
{
  knee().gap.set_attitude(attitude);
  return knee().gap.travel_mm(pose);
}

StepRecord rest_at(const Attitude& attitude, const MovingPose& seed)
{
  return knee().solver.solve(
      {attitude, seed, solve::loads_of(knee().job_case, knee().job_case.push.front()), false});
}

// Pose of a neighbour's equilibrium, slightly below first contact.
MovingPose start_of(const Attitude& attitude)
{
  Attitude neighbour = attitude;
  neighbour.flexion_rad += rad_from_deg(attitude.flexion_rad > 0.0 ? -neighbour_deg : neighbour_deg);
  MovingPose start = rest_at(neighbour, solve::plan_of(knee().job_case).initial).pose;
  const double travel_mm = travel_left_mm(attitude, start);
  check(std::isfinite(travel_mm), "the neighbour's pose must face the reference");
  start.translation_mm.y() += travel_mm - start_below_mm;
  return start;
}

void settle(benchmark::State& state, const Attitude& attitude)
{
  const MovingPose start = start_of(attitude);
  for (auto _ : state) {
    const double before_s = thread_s();
    const Settled settled = knee().bodies.settle(attitude, start);
    const double between_s = thread_s();
    StepRecord rest;
    for (int k = 0; k < n_solved; ++k) rest = rest_at(attitude, start);
    check(rest.status == StepStatus::stable,
          "the generic knee must have an equilibrium at each of these attitudes");
    const double settled_s = between_s - before_s, solved_s = (thread_s() - between_s) / n_solved;
    const Eigen::Vector3d off_mm = settled.pose.translation_mm - rest.pose.translation_mm;
    state.SetIterationTime(settled_s);
    state.counters["times the equilibrium"] = settled_s / solved_s;
    state.counters["simulated s"] = settled.simulated_s;
    state.counters["converged"] = settled.is_at_rest ? 1.0 : 0.0;
    state.counters["travel deficit along Delta, mm"] = -off_mm.y();
    state.counters["mm across"] = std::hypot(off_mm.x(), off_mm.z());
    state.counters["degrees"] = std::abs(deg_from_rad(settled.pose.theta_rad - rest.pose.theta_rad));
    state.counters["remaining travel, mm"] = travel_left_mm(attitude, settled.pose);
    state.counters["theta determined"] = rest.theta_determined ? 1.0 : 0.0;
  }
}

[[maybe_unused]] const bool registered = [] {
  struct Row {
    int flexion_deg, varus_deg;
  };
  for (const Row& row : {Row{0, 0}, Row{30, 0}, Row{60, 0}, Row{90, 0}, Row{30, -3}, Row{30, 3}}) {
    const std::string name = "rest/rigid_body_by_Bullet/flexion " + std::to_string(row.flexion_deg) +
                             " varus " + std::to_string(row.varus_deg);
    const Attitude attitude{rad_from_deg(row.flexion_deg), rad_from_deg(row.varus_deg)};
    benchmark::RegisterBenchmark(name.c_str(),
                                 [attitude](benchmark::State& state) { settle(state, attitude); })
        ->UseManualTime()
        ->Iterations(1);
  }
  return true;
}();

}  // namespace
}  // namespace vrda::benchmarks
