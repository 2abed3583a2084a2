// Whole motion steps, and other rooms used by a run.
#include <benchmark/benchmark.h>

#include <chrono>
#include <filesystem>

#include "analysis/smooth.hpp"
#include "processor_time.hpp"
#include "scene.hpp"
#include "shares.hpp"
#include "solve/case_solver.hpp"
#include "solve/stability_search.hpp"
#include "store/motion_model.hpp"

namespace vrda::benchmarks {
namespace {

void motion_step(benchmark::State& state, const std::string& knee)
{
  const Scene& s = scene(knee);
  double total_s = 0.0;
  std::int64_t n_queries = 0;
  reset_shares();
  for (auto _ : state) {
    const auto start = std::chrono::steady_clock::now();
    for (const Step& step : s.steps) {
      const StepRecord record = solve::find_stable_pose(s.joint, step.attitude, step.seed, s.job_case.search);
      n_queries += record.queries;
    }
    total_s += seconds_since(start);
  }
  const auto n_steps = static_cast<double>(s.steps.size());
  state.counters["motion steps/s"] =
      benchmark::Counter(n_steps, benchmark::Counter::kIsIterationInvariantRate);
  state.counters["queries per step"] =
      static_cast<double>(n_queries) / (n_steps * static_cast<double>(state.iterations()));
  const Shares spent = shares();
  state.counters["gap share"] = spent.gap_s / total_s;
  state.counters["collision share"] = spent.collision_s / total_s;
  state.counters["contacts share"] = spent.contacts_s / total_s;
  state.counters["Bullet share"] = spent.bullet_s / total_s;
  state.counters["turning share"] = spent.turn_s / total_s;
}

// The motion model of the coarse sweep, assembled as in a run.
store::MotionModel small_model(const Scene& s)
{
  job::Case job_case = s.job_case;
  job_case.grid.flexion_deg = {0, 15, 30, 45, 60, 75, 90};
  job_case.grid.varus_deg = {-3, 0, 3};
  solve::SweepResult result;
  for (int i = 0; i < 7; ++i) {
    for (int j = 0; j < 3; ++j) {
      StepRecord record;
      record.key = {StepKind::row, i, j};
      record.status = StepStatus::stable;
      record.pose = s.steps[static_cast<std::size_t>(3 * i + j) % s.steps.size()].solved;
      result.cells.push_back(record);
    }
  }
  result.spine_column.assign(7, 1);
  return solve::motion_model_of(job_case, result);
}

void write(benchmark::State& state, const std::string& knee)
{
  const store::MotionModel model = small_model(scene(knee));
  const std::string path = (std::filesystem::temp_directory_path() / "vrda-bench.h5").string();
  for (auto _ : state) store::write_motion_model(path, model);
  std::filesystem::remove(path);
}

void smooth_degree_2(benchmark::State& state, const std::string& knee)
{
  const analysis::SmoothInput input = analysis::smooth_input(small_model(scene(knee)), "bench");
  for (auto _ : state) benchmark::DoNotOptimize(analysis::smooth(input, 2));
}

void prepare(benchmark::State& state, const std::string& knee)
{
  const Scene& s = scene(knee);
  for (auto _ : state) benchmark::DoNotOptimize(solve::joint_of(s.job_case, s.job_case.frame));
}

[[maybe_unused]] const bool registered = [] {
  for_each_knee("solve/motion_step", motion_step);
  for_each_knee("solve/make_joint", prepare);
  for_each_knee("smooth/degree_2_of_21_cells", smooth_degree_2);
  for_each_knee("store/write_motion_model", write);
  return true;
}();

}  // namespace
}  // namespace vrda::benchmarks
