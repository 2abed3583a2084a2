// The cases of a campaign with their costs, from jobs and meshes; nothing is solved. For plan_command.cpp.
#include "app/cluster_commands.hpp"

#include <filesystem>
#include <map>
#include <utility>

#include "core/document.hpp"
#include "core/text.hpp"
#include "job/job.hpp"
#include "solve/case_solver.hpp"

namespace vrda::app {
namespace {

// A joint at scaling factor 1 and its mesh sizes.
struct Loaded {
  job::Case joint;  ///< without bodies
  std::int64_t n_contact_triangles = 0;
  std::int64_t n_triangles = 0;
};

// True for job keys that do not affect the meshes.
bool is_mesh_independent(const std::string& key)
{
  for (const char* setting : {"title", "push", "grid", "solver", "smooth", "limits", "player", "scaling"}) {
    if (key == setting) return true;
  }
  return false;
}

// Cache key: equal keys load equal meshes.
std::string mesh_key_of(const job::Job& job, const run::CaseSpec& spec)
{
  core::DocumentValue kept = core::DocumentValue::object();
  for (const auto& [key, value] : job.document.root.items()) {
    if (!is_mesh_independent(key)) kept[key] = value;
  }
  const std::string folder = std::filesystem::path(spec.job_file).parent_path().string();
  return folder + '\n' + spec.data_directory + '\n' + core::toml_text(kept);
}

Loaded loaded_by(run::CaseSpec spec)
{
  spec.overrides.emplace_back("scaling={}");
  Loaded loaded{job::load_case(spec.job_file, {spec.data_directory, spec.overrides}), 0, 0};
  for (const job::ComponentSurvey& component : loaded.joint.survey) {
    loaded.n_triangles += component.n_triangles;
    if (component.has_contact) loaded.n_contact_triangles += component.n_triangles;
  }
  loaded.joint.reference = loaded.joint.moving = {};
  return loaded;
}

run::CaseSize size_of(const job::Case& job_case, const Loaded& loaded)
{
  run::CaseSize size;
  size.is_search = job_case.method == "stability-search";
  size.n_contact_triangles = loaded.n_contact_triangles;
  size.n_triangles = loaded.n_triangles;
  size.n_fibres = static_cast<std::int64_t>(loaded.joint.ligaments.fibres.size());
  size.n_flexion = static_cast<std::int64_t>(job_case.grid.flexion_deg.size());
  size.n_varus = static_cast<std::int64_t>(job_case.grid.varus_deg.size());
  size.n_smoothed = static_cast<std::int64_t>(job_case.smooth_degrees.size());
  if (job_case.uncertainty) size.n_samples = job_case.uncertainty->n_samples;
  return size;
}

class Planner {
 public:
  PlannedCase planned(const run::CampaignCase& campaign_case)
  {
    const run::CaseSpec& spec = campaign_case.spec;
    const job::Job job = job::read_job(spec.job_file, spec.overrides);
    const Loaded& loaded = loaded_once(job, spec);
    PlannedCase result;
    result.campaign_case = campaign_case;
    result.job_case = job::case_with_joint(job, spec.data_directory, loaded.joint);
    result.plan = solve::plan_of(result.job_case);
    result.size = size_of(result.job_case, loaded);
    result.cost = run::cost_of(result.size, run::step_counts(result.plan));
    find_duplicates(result);
    // Frees what is not needed later: a campaign may have thousands of cases.
    job::Case& job_case = result.job_case;
    job_case.compartment_of_triangle = {};
    job_case.ligaments = {};
    for (std::string* text : {&job_case.job_text, &job_case.resolved_job, &job_case.steps_job_text})
      text->clear();
    return result;
  }

 private:
  void find_duplicates(PlannedCase& planned)
  {
    const std::string& name = planned.campaign_case.spec.name;
    const std::string steps = solve::fingerprint_of(planned.job_case);
    const auto [twin, is_new] = motions_.emplace(std::pair{steps, planned.job_case.steps_scale}, name);
    if (!is_new) planned.same_as = twin->second;
    const auto [same, is_first] = steps_.emplace(steps, name);
    if (!is_first && is_new) planned.same_steps_as = same->second;
  }

  const Loaded& loaded_once(const job::Job& job, const run::CaseSpec& spec)
  {
    const std::string key = mesh_key_of(job, spec);
    auto found = loaded_.find(key);
    if (found == loaded_.end()) found = loaded_.emplace(key, loaded_by(spec)).first;
    return found->second;
  }

  std::map<std::string, Loaded> loaded_;
  std::map<std::string, std::string> steps_;  // fingerprint -> name of the first case
  std::map<std::pair<std::string, double>, std::string> motions_;
};

}  // namespace

std::vector<PlannedCase> planned_cases(const run::Campaign& campaign)
{
  Planner planner;
  std::vector<PlannedCase> cases;
  for (const run::CampaignCase& one : campaign.cases) {
    try {
      cases.push_back(planner.planned(one));
    } catch (const InputError& error) {
      throw run::error_of_case(campaign, one, error);
    }
  }
  return cases;
}

}  // namespace vrda::app
