// The grid of the thesis by each method in turn, with the same processor and threads.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <thread>

#include "fcl_search.hpp"
#include "processor_time.hpp"
#include "scene.hpp"
#include "shares.hpp"
#include "solve/case_solver.hpp"

namespace vrda::benchmarks {
namespace {

enum class Method { equilibrium, stability_search, search_by_fcl };

// Totals over the steps of a sweep.
struct Spent {
  std::atomic<int> n_steps = 0;
  std::atomic<long> n_queries = 0;
  std::atomic<double> in_steps_s = 0.0;  // wall-clock, of all threads
  std::atomic<double> in_fcl_s = 0.0;    // of all threads
};

struct Swept {
  solve::SweepResult result;
  double wall_s = 0.0;
  double processor_s = 0.0;  // of all threads
  double n_steps = 0.0;
  double n_queries = 0.0;
  double in_steps_s = 0.0;
  Shares parts;  // of in_steps_s
  double in_fcl_s = 0.0;
};

int n_threads()
{
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

job::Case grid_case(Method method, const std::string& grid)
{
  const std::string name = method == Method::equilibrium ? "equilibrium" : "stability-search";
  std::vector<std::string> settings{"solver.method=" + name};
  if (grid != "91x21") {
    settings.push_back("grid.flexion={from = 0, to = 90, step = 5}");
    settings.push_back("grid.varus={from = -8, to = 8, step = 4}");
  }
  return case_of("generic", settings);
}

// Only the sweep is timed; meshes and trees are built before.
Swept swept_by(const solve::SolveStep& solve, const solve::SweepPlan& plan, Spent& spent)
{
  reset_shares();
  const double processor_start_s = process_s();
  const auto start = std::chrono::steady_clock::now();
  solve::SweepResult result = solve::sweep(
      plan,
      [&](const solve::StepTask& task) {
        const auto step_start = std::chrono::steady_clock::now();
        StepRecord record = solve(task);
        spent.in_steps_s += seconds_since(step_start);
        ++spent.n_steps;
        spent.n_queries += record.queries;
        return record;
      },
      {}, n_threads());
  const double wall_s = seconds_since(start);
  const double processor_s = process_s() - processor_start_s;
  return {std::move(result),
          wall_s,
          processor_s,
          static_cast<double>(spent.n_steps),
          static_cast<double>(spent.n_queries),
          spent.in_steps_s,
          shares(),
          spent.in_fcl_s};
}

Swept swept(Method method, const std::string& grid)
{
  const job::Case job_case = grid_case(method, grid);
  const solve::SweepPlan plan = solve::plan_of(job_case);
  Spent spent;
  if (method != Method::search_by_fcl) {
    solve::CaseSolver solver(job_case, n_threads());
    return swept_by([&](const solve::StepTask& task) { return solver(task); }, plan, spent);
  }
  const solve::Joint joint = solve::joint_of(job_case, job_case.frame);
  const FclPair models(joint);
  const solve::SolveStep solve = [&](const solve::StepTask& task) {
    FclStep step = find_stable_pose_by_fcl(joint, models, task.attitude, task.seed, job_case.search);
    spent.in_fcl_s += step.collision_s;
    return std::move(step.record);
  };
  return swept_by(solve, plan, spent);
}

// The equilibrium's median of three, measured next to the row it is compared with.
Swept equilibrium_sweep(const std::string& grid)
{
  std::vector<Swept> runs;
  for (int k = 0; k < 3; ++k) runs.push_back(swept(Method::equilibrium, grid));
  std::sort(runs.begin(), runs.end(), [](const Swept& a, const Swept& b) { return a.wall_s < b.wall_s; });
  return std::move(runs[1]);
}

// How much further along Delta the equilibrium is, mm, at every attitude that both solved; sorted.
std::vector<double> behind_mm(const solve::SweepResult& result, const solve::SweepResult& equilibrium)
{
  std::vector<double> differences;
  for (std::size_t i = 0; i < result.cells.size(); ++i) {
    const StepRecord &theirs = result.cells[i], &ours = equilibrium.cells[i];
    if (theirs.status != StepStatus::stable || ours.status != StepStatus::stable) continue;
    differences.push_back(ours.pose.translation_mm.y() - theirs.pose.translation_mm.y());
  }
  std::sort(differences.begin(), differences.end());
  return differences;
}

double solved_share(const solve::SweepResult& result)
{
  const auto n = std::count_if(result.cells.begin(), result.cells.end(),
                               [](const StepRecord& r) { return r.status == StepStatus::stable; });
  return static_cast<double>(n) / static_cast<double>(result.cells.size());
}

void count_steps(benchmark::State& state, const Swept& run)
{
  state.counters["threads"] = n_threads();
  state.counters["steps"] = run.n_steps;
  state.counters["processor ms per step"] = 1e3 * run.processor_s / run.n_steps;
  state.counters["queries per step"] = run.n_queries / run.n_steps;
  state.counters["solved share"] = solved_share(run.result);
}

void compare(benchmark::State& state, const Swept& run, const Swept& equilibrium)
{
  state.counters["times the equilibrium"] = run.wall_s / equilibrium.wall_s;
  state.counters["per step"] = run.processor_s / run.n_steps * equilibrium.n_steps / equilibrium.processor_s;
  const std::vector<double> behind = behind_mm(run.result, equilibrium.result);
  if (behind.empty()) return state.SkipWithError("no attitude was solved by both");
  state.counters["median travel deficit, mm"] = behind[behind.size() / 2];
}

// Of the product's methods: parts of a step by wall-clock time, which other load prolongs alike.
void count_parts(benchmark::State& state, const Swept& run)
{
  state.counters["gap share"] = run.parts.gap_s / run.in_steps_s;
  state.counters["collision share"] = run.parts.collision_s / run.in_steps_s;
  state.counters["contacts share"] = run.parts.contacts_s / run.in_steps_s;
  state.counters["Bullet share"] = run.parts.bullet_s / run.in_steps_s;
}

void sweep_by(benchmark::State& state, Method method, const std::string& grid)
{
  for (auto _ : state) {
    const Swept equilibrium = equilibrium_sweep(grid);
    if (method == Method::equilibrium) {
      state.SetIterationTime(equilibrium.wall_s);
      count_steps(state, equilibrium);
      count_parts(state, equilibrium);
      continue;
    }
    const Swept run = swept(method, grid);
    state.SetIterationTime(run.wall_s);
    count_steps(state, run);
    compare(state, run, equilibrium);
    if (method == Method::search_by_fcl) {
      state.counters["FCL share"] = run.in_fcl_s / run.processor_s;
    } else {
      count_parts(state, run);
    }
  }
}

[[maybe_unused]] const bool registered = [] {
  struct Row {
    const char* name;
    Method method;
  };
  for (const std::string grid : {"19x5", "91x21"}) {
    for (const Row& row :
         {Row{"equilibrium", Method::equilibrium}, Row{"stability_search", Method::stability_search},
          Row{"stability_search_by_FCL", Method::search_by_fcl}}) {
      const std::string name = std::string("sweep/") + row.name + "/generic " + grid;
      benchmark::RegisterBenchmark(
          name.c_str(), [row, grid](benchmark::State& state) { sweep_by(state, row.method, grid); })
          ->UseManualTime()
          ->Iterations(1);
    }
  }
  return true;
}();

}  // namespace
}  // namespace vrda::benchmarks
