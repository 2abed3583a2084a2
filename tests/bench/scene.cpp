#include "scene.hpp"

#include <filesystem>
#include <map>

#include "core/units.hpp"
#include "solve/case_solver.hpp"
#include "solve/stability_search.hpp"
#include "support/real_knees.hpp"

namespace vrda::benchmarks {
namespace {

namespace fs = std::filesystem;

std::vector<Step> swept(const job::Case& job_case, const solve::Joint& joint)
{
  solve::SweepPlan plan = solve::plan_of(job_case);
  plan.flexion_rad.clear();
  for (int i = 0; i <= 6; ++i) plan.flexion_rad.push_back(rad_from_deg(15.0 * i));
  plan.varus_rad = {rad_from_deg(-3), rad_from_deg(0), rad_from_deg(3)};
  std::vector<Step> steps;
  const solve::SolveStep solve = [&](const solve::StepTask& task) {
    StepRecord record = solve::find_stable_pose(joint, task.attitude, task.seed, job_case.search);
    if (record.status == StepStatus::stable) steps.push_back({task.attitude, task.seed, record.pose});
    return record;
  };
  solve::sweep(plan, solve, {}, 1);
  return steps;
}

}  // namespace

bool has_real_knees()
{
  return test::data_directory().has_value();
}

job::Case case_of(const std::string& knee, const std::vector<std::string>& settings)
{
  // Contact only, as required by the search and its references.
  const std::string name = knee == "generic" ? "generic-contact" : knee;
  const fs::path job = test::source_directory() / "jobs" / ("knee-" + name + ".toml");
  return job::load_case(job.string(), {test::data_directory().value_or("").string(), settings});
}

const Scene& scene(const std::string& knee)
{
  static std::map<std::string, Scene> known;
  const auto found = known.find(knee);
  if (found != known.end()) return found->second;
  Scene made;
  made.job_case = case_of(knee);
  made.joint = solve::joint_of(made.job_case, made.job_case.frame);
  made.steps = swept(made.job_case, made.joint);
  return known.emplace(knee, std::move(made)).first->second;
}

std::vector<MovingPose> near_misses(const Step& step)
{
  std::vector<MovingPose> poses;
  for (const double back_mm : {0.002, 0.05, 0.2}) {
    for (const double turn_deg : {-0.5, 0.0, 0.5}) {
      MovingPose pose = step.solved;
      pose.translation_mm.y() -= back_mm;
      pose.theta_rad += rad_from_deg(turn_deg) * back_mm;
      poses.push_back(pose);
    }
  }
  return poses;
}

void for_each_knee(const std::string& room_and_what, void (*run)(benchmark::State&, const std::string&))
{
  std::vector<std::string> knees{"generic"};
  if (has_real_knees()) knees.push_back("jam-smith2019");
  for (const std::string& knee : knees) {
    benchmark::RegisterBenchmark((room_and_what + "/" + knee).c_str(),
                                 [run, knee](benchmark::State& state) { run(state, knee); });
  }
}

}  // namespace vrda::benchmarks
