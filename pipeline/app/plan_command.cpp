// `vrda plan`: cases, shards, processor time, memory and disk of a campaign, as a table or JSON, from jobs
// and meshes; nothing is solved.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "app/commands.hpp"
#include "app/printing.hpp"
#include "core/document.hpp"
#include "core/text.hpp"
#include "job/job.hpp"
#include "solve/case_solver.hpp"

namespace vrda::app {
namespace {

using Json = nlohmann::ordered_json;

struct PlanOptions : job::JobSource {
  int n_shards = 1;
  bool as_json = false;
};

/// A checked case of a campaign with its estimated cost.
struct PlannedCase {
  run::CampaignCase campaign_case;
  job::Case job_case;  ///< without bodies, survey and job text
  solve::SweepPlan plan;
  run::CaseSize size;
  run::CaseCost cost;
  std::string same_as;        ///< an earlier case with the same motion; empty: none
  std::string same_steps_as;  ///< an earlier case that differs only in scaling and can share its journal
};

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

// For printf.
long long as_long(std::int64_t n)
{
  return n;
}

// Share of the solving time above which more shards gain little, since they wait for the spine.
constexpr double large_spine_share = 0.5;

struct ShardCost {
  std::int64_t n_rows = 0;
  std::int64_t n_samples = 0;
  std::int64_t n_attitudes = 0;
  double processor_s = 0.0;  ///< including loading
};

ShardCost cost_of_shard(const PlannedCase& planned, const store::Shard& shard)
{
  solve::SweepPlan plan = planned.plan;
  plan.rows = run::rows_of(shard, static_cast<std::int32_t>(plan.flexion_rad.size()));
  run::CaseSize size = planned.size;
  size.n_samples = std::ssize(run::rows_of(shard, static_cast<std::int32_t>(planned.size.n_samples)));
  const run::CaseCost cost = run::cost_of(size, run::step_counts(plan));
  const auto n_rows = static_cast<std::int64_t>(plan.rows->size());
  return {n_rows, size.n_samples, n_rows * planned.size.n_varus, cost.load_s + cost.rows_s};
}

std::vector<ShardCost> shards_of(const PlannedCase& planned, int n_shards)
{
  std::vector<ShardCost> shards;
  for (std::int32_t i = 1; i <= n_shards; ++i) shards.push_back(cost_of_shard(planned, {i, n_shards}));
  return shards;
}

double spine_share(const PlannedCase& planned)
{
  const double solving_s = planned.cost.solving_s();
  return solving_s > 0.0 ? planned.cost.spine_s / solving_s : 0.0;
}

// Every task (spine, shards, merge) loads the case.
double processor_s_of(const PlannedCase& planned, int n_shards)
{
  const int n_more = n_shards > 1 ? n_shards + 1 : 0;
  return planned.cost.processor_s() + n_more * planned.cost.load_s;
}

std::int64_t n_attitudes(const PlannedCase& planned)
{
  return planned.size.n_flexion * planned.size.n_varus;
}

// "2.1 s", "3:05 min", "4:10 h".
std::string duration(double seconds)
{
  const auto whole = as_long(std::llround(seconds));
  if (seconds < 100.0) return printed("%.2g s", seconds);
  if (whole < 6000) return printed("%lld:%02lld min", whole / 60, whole % 60);
  return printed("%lld:%02lld h", whole / 3600, whole % 3600 / 60);
}

std::string amount(double bytes)
{
  const char* unit = bytes < 1e9 ? "MB" : bytes < 1e12 ? "GB" : "TB";
  const double in_unit = bytes / (bytes < 1e9 ? 1e6 : bytes < 1e12 ? 1e9 : 1e12);
  return printed(in_unit < 10.0 ? "%.1f %s" : "%.0f %s", in_unit, unit);
}

struct Totals {
  std::int64_t attitudes = 0, steps = 0;
  double processor_s = 0.0, journal_bytes = 0.0, model_bytes = 0.0, largest_memory = 0.0, largest_s = 0.0;
};

Totals totals_of(const std::vector<PlannedCase>& cases, int n_shards)
{
  Totals totals;
  for (const PlannedCase& planned : cases) {
    totals.attitudes += n_attitudes(planned);
    totals.steps += planned.cost.steps.all();
    totals.processor_s += processor_s_of(planned, n_shards);
    totals.journal_bytes += planned.cost.journal_bytes;
    totals.model_bytes += planned.cost.model_bytes;
    totals.largest_memory = std::max(totals.largest_memory, planned.cost.memory_bytes);
    totals.largest_s = std::max(totals.largest_s, planned.cost.processor_s());
  }
  return totals;
}

Json command_of(const run::CaseSpec& spec)
{
  Json words = {"vrda", "run", spec.job_file};
  if (!spec.data_directory.empty()) words.insert(words.end(), {"--data", spec.data_directory});
  for (const std::string& text : spec.overrides) words.insert(words.end(), {"--set", text});
  return words;
}

Json case_json(const run::Campaign& campaign, const PlannedCase& planned, int n_shards)
{
  Json levels = Json::object();
  for (std::size_t a = 0; a < campaign.axes.size(); ++a)
    levels[campaign.axes[a]] = planned.campaign_case.levels[a];
  const run::CaseCost& cost = planned.cost;
  Json result = {
      {"name", planned.campaign_case.spec.name},
      {"levels", levels},
      {"command", command_of(planned.campaign_case.spec)},
      {"title", planned.job_case.title},
      {"method", planned.job_case.method},
      {"flexions", planned.size.n_flexion},
      {"varus_columns", planned.size.n_varus},
      {"samples", planned.size.n_samples},
      {"varus_is_free", planned.job_case.is_varus_free},
      {"attitudes", n_attitudes(planned)},
      {"triangles", {{"contact", planned.size.n_contact_triangles}, {"all", planned.size.n_triangles}}},
      {"fibres", planned.size.n_fibres},
      {"steps", {{"spine", cost.steps.spine()}, {"bands", cost.steps.bands}, {"rows", cost.steps.cells}}},
      {"processor_s",
       {{"load", cost.load_s},
        {"spine", cost.spine_s},
        {"spine_one_after_the_other", cost.chain_s},
        {"rows", cost.rows_s},
        {"finish", cost.finish_s},
        {"all", processor_s_of(planned, n_shards)}}},
      {"memory_bytes", cost.memory_bytes},
      {"journal_bytes", cost.journal_bytes},
      {"model_bytes", cost.model_bytes},
      {"same_as", planned.same_as},
      {"same_steps_as", planned.same_steps_as}};
  if (n_shards == 1) return result;
  for (const ShardCost& shard : shards_of(planned, n_shards)) {
    result["shards"].push_back(
        {{"rows", shard.n_rows}, {"attitudes", shard.n_attitudes}, {"processor_s", shard.processor_s}});
  }
  return result;
}

Json plan_json(const run::Campaign& campaign, const std::vector<PlannedCase>& cases, int n_shards)
{
  const Totals totals = totals_of(cases, n_shards);
  Json list = Json::array();
  for (const PlannedCase& planned : cases) list.push_back(case_json(campaign, planned, n_shards));
  return {{"title", campaign.title},
          {"axes", campaign.axes},
          {"cases", list},
          {"total",
           {{"cases", cases.size()},
            {"attitudes", totals.attitudes},
            {"steps", totals.steps},
            {"processor_s", totals.processor_s},
            {"longest_case_s", totals.largest_s},
            {"largest_memory_bytes", totals.largest_memory},
            {"journal_bytes", totals.journal_bytes},
            {"model_bytes", totals.model_bytes}}},
          {"estimate_is_within_a_factor_of", run::cost_spread}};
}

void print_case(const PlannedCase& planned, int n_shards, int name_width)
{
  const std::string grid = std::to_string(planned.size.n_flexion) + " x " +
                           (planned.job_case.is_varus_free ? "free" : std::to_string(planned.size.n_varus));
  std::printf("%-*s  %-16s  %10s  %9lld  %9lld  %9s  %7s  %8s  %7s", name_width,
              planned.campaign_case.spec.name.c_str(), planned.job_case.method.c_str(), grid.c_str(),
              as_long(n_attitudes(planned)), as_long(planned.size.n_contact_triangles),
              duration(processor_s_of(planned, n_shards)).c_str(), amount(planned.cost.memory_bytes).c_str(),
              amount(planned.cost.journal_bytes).c_str(), amount(planned.cost.model_bytes).c_str());
  if (n_shards > 1) {
    std::printf("  %9s  %9s", duration(planned.cost.load_s + planned.cost.spine_s).c_str(),
                duration(cost_of_shard(planned, {1, n_shards}).processor_s).c_str());
  }
  std::printf("\n");
}

void print_cases(const std::vector<PlannedCase>& cases, int n_shards)
{
  std::size_t width = 4;
  for (const PlannedCase& planned : cases) width = std::max(width, planned.campaign_case.spec.name.size());
  const int name_width = static_cast<int>(width);
  std::printf("%-*s  %-16s  %10s  %9s  %9s  %9s  %7s  %8s  %7s", name_width, "case", "method", "grid",
              "attitudes", "triangles", "processor", "memory", "journals", "model");
  std::printf(n_shards > 1 ? "  %9s  %9s\n" : "\n", "spine", "per shard");
  for (const PlannedCase& planned : cases) print_case(planned, n_shards, name_width);
}

void print_shards(const PlannedCase& planned, int n_shards)
{
  const std::vector<ShardCost> shards = shards_of(planned, n_shards);
  const auto n_idle = std::count_if(shards.begin(), shards.end(),
                                    [](const ShardCost& s) { return s.n_rows + s.n_samples == 0; });
  std::printf("spine: %lld steps, %s; %lld of them in sequence\n", as_long(planned.cost.steps.spine()),
              duration(planned.cost.spine_s).c_str(), as_long(planned.cost.steps.chain));
  for (std::size_t i = 0; i < shards.size(); ++i) {
    if (shards[i].n_rows + shards[i].n_samples == 0) continue;
    const std::string samples =
        shards[i].n_samples > 0 ? std::to_string(shards[i].n_samples) + " samples, " : "";
    std::printf("shard %zu/%d: %lld flexions, %lld attitudes, %s%s\n", i + 1, n_shards,
                as_long(shards[i].n_rows), as_long(shards[i].n_attitudes), samples.c_str(),
                duration(shards[i].processor_s).c_str());
  }
  if (n_idle > 0) std::printf("%lld of %d shards have no flexion\n", as_long(n_idle), n_shards);
}

// One line for all cases.
void warn_of_large_spines(const std::vector<PlannedCase>& cases, int n_shards)
{
  const auto n = std::count_if(cases.begin(), cases.end(),
                               [](const PlannedCase& p) { return spine_share(p) > large_spine_share; });
  if (n == 0 || n_shards == 1) return;
  const std::string of =
      cases.size() == 1 ? "" : " in " + std::to_string(n) + " of " + std::to_string(cases.size()) + " cases";
  core::log_warning(
      "--shards: most of the work is the spine" + of +
      ", which one task solves before all shards: use more --cpus for its restarts, not more shards");
}

void warn_of_duplicates(const std::vector<PlannedCase>& cases)
{
  for (const PlannedCase& planned : cases) {
    if (planned.same_as.empty()) continue;
    core::log_warning("case " + planned.campaign_case.spec.name + " gives the same motion as " +
                      planned.same_as);
  }
}

// One line for all cases: a size study has hundreds.
void report_shared_steps(const std::vector<PlannedCase>& cases)
{
  const auto is_scaled = [](const PlannedCase& planned) { return !planned.same_steps_as.empty(); };
  const auto n = std::count_if(cases.begin(), cases.end(), is_scaled);
  if (n == 0) return;
  const PlannedCase& first = *std::find_if(cases.begin(), cases.end(), is_scaled);
  core::log_info(std::to_string(n) + " of " + std::to_string(cases.size()) +
                 " cases differ from another case only in scaling, such as " + first.campaign_case.spec.name +
                 " from " + first.same_steps_as +
                 ": vrda merge --job of one accepts the journals of the other");
}

void print(const run::Campaign& campaign, const std::vector<PlannedCase>& cases, int n_shards)
{
  if (!campaign.title.empty()) std::printf("%s\n", campaign.title.c_str());
  print_cases(cases, n_shards);
  const Totals totals = totals_of(cases, n_shards);
  if (n_shards > 1 && cases.size() == 1) print_shards(cases.front(), n_shards);
  std::printf(
      "%zu case%s: %lld attitudes, %lld steps, %s of processor time, at most %s of memory per task, %s of "
      "journals, %s of motion models\n",
      cases.size(), cases.size() == 1 ? "" : "s", as_long(totals.attitudes), as_long(totals.steps),
      duration(totals.processor_s).c_str(), amount(totals.largest_memory).c_str(),
      amount(totals.journal_bytes).c_str(), amount(totals.model_bytes).c_str());
  std::printf("estimates from one machine: actual times are expected between half and twice these\n");
}

// Prints the cases and their estimated cost; solves nothing. Throws InputError for the first invalid case.
core::ExitCode plan_command(const PlanOptions& options)
{
  const run::Campaign campaign =
      run::campaign_of(options.job_file, options.data_directory, options.overrides);
  const std::vector<PlannedCase> cases = planned_cases(campaign);
  warn_of_duplicates(cases);
  report_shared_steps(cases);
  warn_of_large_spines(cases, options.n_shards);
  if (options.as_json) return print_json(plan_json(campaign, cases, options.n_shards));
  print(campaign, cases, options.n_shards);
  return core::ExitCode::done;
}

}  // namespace

void declare_plan(Command& c)
{
  auto& o = c.options<PlanOptions>();
  c.cases(o, o.n_shards);
  c.json(o.as_json);
  c.runs([&o] { return plan_command(o); });
}

}  // namespace vrda::app
