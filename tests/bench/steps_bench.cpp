// Motion steps of the equilibrium on one core: those of a coarse run, solved again in sequence.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>

#include "processor_time.hpp"
#include "scene.hpp"
#include "solve/case_solver.hpp"

namespace vrda::benchmarks {
namespace {

constexpr int n_passes = 3;

struct Knee {
  std::string name;                   // of the job
  std::vector<std::string> settings;  // in addition to the equilibrium and its grid
};

// The results that a task refers to live as long as its sweep.
struct Step {
  solve::StepTask task;
  std::vector<StepRecord> known;
};

// The tasks of a run in their order. Neighbours along varus are a degree apart, as in a full grid.
std::vector<Step> tasks_of(const job::Case& job_case, solve::CaseSolver& solver)
{
  std::vector<Step> tasks;
  const solve::SolveStep solve = [&](const solve::StepTask& task) {
    tasks.push_back({task, task.known == nullptr ? std::vector<StepRecord>{} : *task.known});
    return solver(task);
  };
  solve::sweep(solve::plan_of(job_case), solve, {}, 1);
  return tasks;
}

struct Pass {
  double processor_s = 0.0;
  double n_queries = 0.0;
  double n_iterations = 0.0;
  double n_stable = 0.0;
};

Pass pass_over(const std::vector<Step>& tasks, solve::CaseSolver& solver)
{
  Pass pass;
  const double start_s = thread_s();
  for (const Step& step : tasks) {
    solve::StepTask task = step.task;
    task.known = &step.known;
    const StepRecord record = solver(task);
    pass.n_queries += record.queries;
    pass.n_iterations += record.iterations;
    pass.n_stable += record.status == StepStatus::stable ? 1.0 : 0.0;
  }
  pass.processor_s = thread_s() - start_s;
  return pass;
}

// The median of several passes.
Pass timed(const std::vector<Step>& tasks, solve::CaseSolver& solver)
{
  std::array<Pass, n_passes> passes;
  for (Pass& pass : passes) pass = pass_over(tasks, solver);
  std::sort(passes.begin(), passes.end(),
            [](const Pass& a, const Pass& b) { return a.processor_s < b.processor_s; });
  return passes[n_passes / 2];
}

void steps(benchmark::State& state, const Knee& knee)
{
  const job::Case job_case = case_of(knee.name, knee.settings);
  solve::CaseSolver solver(job_case, 1);
  const std::vector<Step> tasks = tasks_of(job_case, solver);
  const auto n = static_cast<double>(tasks.size());
  for (auto _ : state) {
    const Pass pass = timed(tasks, solver);
    state.SetIterationTime(pass.processor_s / n);
    state.counters["triangles"] = static_cast<double>(job_case.reference.contact.mesh.triangles.rows() +
                                                      job_case.moving.contact.mesh.triangles.rows());
    state.counters["fibres"] = static_cast<double>(job_case.ligaments.fibres.size());
    state.counters["steps"] = n;
    state.counters["queries per step"] = pass.n_queries / n;
    state.counters["iterations per step"] = pass.n_iterations / n;
    state.counters["solved share"] = pass.n_stable / n;
  }
}

void add(const std::string& name, const Knee& knee)
{
  benchmark::RegisterBenchmark(name.c_str(), [knee](benchmark::State& state) { steps(state, knee); })
      ->UseManualTime()
      ->Iterations(1);
}

std::vector<std::string> contact_only()
{
  return {"solver.method=equilibrium", "grid.flexion={from = 0, to = 90, step = 15}",
          "grid.varus={from = -3, to = 3, step = 1}"};
}

std::vector<std::string> refined(double resolution)
{
  std::vector<std::string> settings = contact_only();
  const std::string value = ".generate.resolution=" + std::to_string(resolution);
  settings.push_back("reference.component.0" + value);
  for (const char* part : {"0", "1", "2"}) settings.push_back("moving.component." + (part + value));
  return settings;
}

[[maybe_unused]] const bool registered = [] {
  add("equilibrium/contact_only/generic", {"generic", contact_only()});
  if (has_real_knees()) {
    add("equilibrium/contact_only/jam-smith2019", {"jam-smith2019", contact_only()});
    add("equilibrium/fibres_and_free_varus/jam-smith2019",
        {"jam-smith2019-ligaments", {"grid.flexion={from = 0, to = 90, step = 5}"}});
  }
  // Each twice as fine as the previous one, and one with a million triangles.
  struct Row {
    const char* name;
    double resolution;
  };
  for (const Row& row : {Row{"generic x 1", 1.0}, Row{"generic x 2", 2.0}, Row{"generic x 4", 4.0},
                         Row{"generic x 8", 8.0}, Row{"generic x 14.7", 14.7}}) {
    add(std::string("scaling/contact_only/") + row.name, {"generic", refined(row.resolution)});
  }
  return true;
}();

}  // namespace
}  // namespace vrda::benchmarks
