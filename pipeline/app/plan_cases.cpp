#include "app/plan_cases.hpp"

#include <filesystem>
#include <map>

#include "app/prepare.hpp"
#include "core/error.hpp"
#include "load/job.hpp"
#include "load/job_value.hpp"

namespace vrda {
namespace {

// What a case takes from its meshes and tables.
struct Loaded {
  Ligaments ligaments;
  std::vector<Compartment> compartment_of_triangle;
  std::vector<LoadedInput> inputs;
  std::int64_t n_contact_triangles = 0;
  std::int64_t n_triangles = 0;
};

// The keys that the meshes do not depend on; any other may.
bool is_setting(const std::string& key)
{
  for (const char* setting : {"title", "push", "grid", "solver", "smooth", "limits", "player"}) {
    if (key == setting) return true;
  }
  return false;
}

// Equal texts load equal meshes.
std::string meshes_of(const Job& job, const CaseSpec& spec)
{
  JobValue::Table kept;
  for (const JobEntry& entry : *job.document.root.table()) {
    if (!is_setting(entry.key)) kept.push_back(entry);
  }
  const std::string folder = std::filesystem::path(spec.job_file).parent_path().string();
  return folder + '\n' + spec.data_directory + '\n' + toml_text({kept});
}

Loaded loaded_by(const CaseSpec& spec)
{
  Case whole = load_case(spec.job_file, {spec.data_directory, spec.overrides});
  Loaded loaded{std::move(whole.ligaments), std::move(whole.compartment_of_triangle), std::move(whole.inputs),
                0, 0};
  for (const ComponentSurvey& component : whole.survey) {
    loaded.n_triangles += component.n_triangles;
    if (component.has_contact) loaded.n_contact_triangles += component.n_triangles;
  }
  return loaded;
}

CaseSize size_of(const Case& job_case, const Loaded& loaded)
{
  CaseSize size;
  size.is_search = job_case.method == "stability-search";
  size.n_contact_triangles = loaded.n_contact_triangles;
  size.n_triangles = loaded.n_triangles;
  size.n_fibres = static_cast<std::int64_t>(loaded.ligaments.fibres.size());
  size.n_flexion = static_cast<std::int64_t>(job_case.grid.flexion_deg.size());
  size.n_varus = static_cast<std::int64_t>(job_case.grid.varus_deg.size());
  size.n_smoothed = static_cast<std::int64_t>(job_case.smooth_degrees.size());
  return size;
}

class Planner {
 public:
  PlannedCase planned(const CampaignCase& campaign_case)
  {
    const CaseSpec& spec = campaign_case.spec;
    const Job job = read_job(spec.job_file, spec.overrides);
    PlannedCase result;
    result.campaign_case = campaign_case;
    result.job_case = settings_of(job);
    const Loaded& loaded = loaded_once(job, spec);
    result.job_case.ligaments = loaded.ligaments;
    result.job_case.compartment_of_triangle = loaded.compartment_of_triangle;
    result.job_case.inputs = loaded.inputs;
    // Sizes that share their steps are different motion models: all that the job says counts, and every
    // input.
    for (LoadedInput& input : result.job_case.inputs) input.decides_steps = true;
    result.plan = plan_of(result.job_case);
    result.size = size_of(result.job_case, loaded);
    result.cost = cost_of(result.size, step_counts(result.plan));
    const auto [first, is_new] = cases_.emplace(fingerprint_of(result.job_case), spec.name);
    if (!is_new) result.same_as = first->second;
    // Thousands of cases are kept.
    result.job_case.compartment_of_triangle.clear();
    result.job_case.job_text.clear();
    result.job_case.resolved_job.clear();
    return result;
  }

 private:
  const Loaded& loaded_once(const Job& job, const CaseSpec& spec)
  {
    const std::string key = meshes_of(job, spec);
    auto found = loaded_.find(key);
    if (found == loaded_.end()) found = loaded_.emplace(key, loaded_by(spec)).first;
    return found->second;
  }

  std::map<std::string, Loaded> loaded_;
  std::map<std::string, std::string> cases_;  // fingerprint -> name
};

}  // namespace

std::vector<PlannedCase> planned_cases(const Campaign& campaign)
{
  Planner planner;
  std::vector<PlannedCase> cases;
  for (const CampaignCase& one : campaign.cases) {
    try {
      cases.push_back(planner.planned(one));
    } catch (const InputError& error) {
      if (campaign.axes.empty()) throw;
      InputError::Facts facts = error.facts();
      facts.file = "case " + one.spec.name + ": " + facts.file;
      throw InputError(facts);
    }
  }
  return cases;
}

}  // namespace vrda
