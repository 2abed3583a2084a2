#include "run/campaign.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>

#include "core/document.hpp"
#include "core/fields_json.hpp"
#include "core/files.hpp"
#include "job/job.hpp"

namespace vrda::run {
namespace {

namespace fs = std::filesystem;

std::string absolute(const std::string& path)
{
  return path.empty() ? path : fs::absolute(path).lexically_normal().string();
}

}  // namespace

CaseSpec case_of_job(const std::string& job_file, const std::string& data_directory,
                     const std::vector<std::string>& overrides)
{
  return {fs::path(job_file).stem().string(), absolute(job_file), absolute(data_directory), overrides};
}

std::string case_file_of(const std::string& output)
{
  return output + ".case.json";
}

void write_case_file(const std::string& path, const CaseFile& content)
{
  write_atomically(path, {core::json_text(content, 2), "\n"});
}

CaseFile read_case_file(const std::string& path)
{
  constexpr const char* wanted = "the case file that vrda run --spine or --shard wrote, or --job";
  const std::optional<std::string> text = read_text_file(path);
  if (!text) throw InputError({path, "", "no file", wanted});
  return core::value_in<CaseFile>(core::JsonFile(path, *text, wanted), path);
}

InputError error_of_case_file(const std::string& path, const CaseSpec& spec, const InputError& error)
{
  InputError::Facts facts = error.facts();
  constexpr std::string_view with_override = " with --set ";
  if (facts.file == "--set") {
    facts.file = path;
    facts.field = facts.field.empty() ? "set" : "set: " + facts.field;
  } else if (const std::size_t with = facts.file.find(with_override); with != std::string::npos) {
    facts.file.replace(with, with_override.size(), " with " + path + ": set: ");
  } else if (facts.file == spec.job_file && facts.field.empty()) {
    facts.wanted += ", which " + path + " names";
  } else {
    return error;
  }
  facts.wanted += "; --job names another job";
  return InputError(facts);
}

std::string sha256_of_model(const std::string& output)
{
  return job::sha256_of(job::file_bytes(output, {output, "", "", "a motion model"}, largest_model_bytes));
}

namespace {

// Empty if the text is not a case file.
std::optional<CaseFile> parsed(const std::string& text)
{
  try {
    return core::json_in(text).get<CaseFile>();
  } catch (const nlohmann::json::exception&) {
    return std::nullopt;
  }
}

}  // namespace

bool is_cleanup_pending(const std::string& output)
{
  const std::optional<std::string> text = read_text_file(case_file_of(output));
  const std::optional<CaseFile> case_file = text ? parsed(*text) : std::nullopt;
  if (!case_file || case_file->merged_sha256.empty()) return false;
  const std::optional<std::string> model = read_text_file(output);
  return model && case_file->merged_sha256 == job::sha256_of(*model);
}

namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t largest_campaign_bytes = 16U << 20U;  // ten thousand subjects are 2 MiB
constexpr std::size_t most_cases = 100'000;  // ten thousand is a large study; more is a mistake

// Folders of a submission, next to those of the cases.
const std::set<std::string> reserved_names{"logs", "scripts", "tasks"};

struct Level {
  std::string name;
  std::string key;                     // "campaign.size.1"
  std::string job;                     // absolute, or empty
  std::string data;                    // absolute, or empty
  std::vector<std::string> overrides;  // "key.path=value"
};

struct Axis {
  std::string name;
  std::vector<Level> levels;
  std::set<std::string> keys;  // set by its levels
};

struct Source {
  const core::Document& document;

  [[noreturn]] void refuse(const std::string& key, const std::string& found, const std::string& wanted) const
  {
    document.refuse(key.empty() ? "campaign" : "campaign." + key, found, wanted);
  }

  // Paths are relative to the campaign's file.
  std::string resolved(const std::string& path) const
  {
    return (fs::absolute(document.file).parent_path() / path).lexically_normal().string();
  }
};

std::string key_of(const std::string& override_text)
{
  return override_text.substr(0, override_text.find('='));
}

// Whether the keys are equal or one is part of the other.
bool do_overlap(const std::string& a, const std::string& b)
{
  const std::string& inner = a.size() < b.size() ? b : a;
  const std::string& outer = a.size() < b.size() ? a : b;
  return inner.starts_with(outer) && (inner.size() == outer.size() || inner[outer.size()] == '.');
}

// Every leaf of the table; a list is one leaf.
void add_leaves(const Source& source, const std::string& at, const core::DocumentValue& value,
                const std::string& path, std::vector<std::string>& leaves)
{
  if (!value.is_object() || (value.empty() && !path.empty())) {
    leaves.push_back(path + "=" + core::value_text(value));
    return;
  }
  for (const auto& [key, child] : value.items()) {
    if (key.empty() || key.find_first_of(".=") != std::string::npos) {
      source.refuse(at, "the key \"" + key + "\"", "keys without '.' and '='");
    }
    add_leaves(source, at, child, path.empty() ? key : path + "." + key, leaves);
  }
}

Level level_of(const Source& source, const std::string& key, const core::DocumentValue& table)
{
  Level level;
  level.name = core::text_at(table, "name");
  level.key = "campaign." + key;
  if (const std::string job = core::text_or_empty(table, "job"); !job.empty())
    level.job = source.resolved(job);
  if (const std::string data = core::text_or_empty(table, "data"); !data.empty())
    level.data = source.resolved(data);
  if (const core::DocumentValue* settings = core::find_at(table, "set")) {
    if (settings->contains("campaign")) source.refuse(key + ".set", "campaign", "keys of a job");
    add_leaves(source, key + ".set", *settings, "", level.overrides);
  }
  return level;
}

Axis axis_of(const Source& source, const std::string& name, const core::DocumentValue& levels)
{
  Axis axis{name, {}, {}};
  std::set<std::string> names;
  for (const core::DocumentValue& table : levels) {
    const std::string key = axis.name + "." + std::to_string(axis.levels.size());
    Level level = level_of(source, key, table);
    if (!names.insert(level.name).second) {
      source.refuse(key + ".name", "\"" + level.name + "\" a second time", "a unique name for each level");
    }
    for (const std::string& setting : level.overrides) axis.keys.insert(key_of(setting));
    axis.levels.push_back(std::move(level));
  }
  return axis;
}

std::vector<Axis> axes_of(const Source& source, const core::DocumentValue& campaign)
{
  std::vector<Axis> axes;
  for (const auto& [key, levels] : campaign.items()) {
    if (key != "title" && key != "exclude") axes.push_back(axis_of(source, key, levels));
  }
  return axes;
}

// A key of `axis` that overlaps `key`; empty if none exists.
std::string key_that_overlaps(const Axis& axis, const std::string& key)
{
  const auto found =
      std::find_if(axis.keys.begin(), axis.keys.end(), [&](const auto& own) { return do_overlap(own, key); });
  return found == axis.keys.end() ? "" : *found;
}

void check_disjoint_keys(const Source& source, const std::vector<Axis>& axes)
{
  for (std::size_t b = 1; b < axes.size(); ++b) {
    for (std::size_t a = 0; a < b; ++a) {
      for (const std::string& key : axes[a].keys) {
        const std::string other = key_that_overlaps(axes[b], key);
        if (other.empty()) continue;
        source.refuse(axes[b].name, other + ", which the axis \"" + axes[a].name + "\" also sets",
                      "keys of the job that no other axis sets");
      }
    }
  }
}

// An override of an axis' key would make its levels equal.
void check_overrides(const std::vector<Axis>& axes, const std::vector<std::string>& overrides)
{
  for (const std::string& text : overrides) {
    const std::string key = key_of(text);
    if (do_overlap(key, "campaign")) {
      throw InputError({"--set", key, "a key of the campaign", "keys of its jobs"});
    }
    for (const Axis& axis : axes) {
      if (key_that_overlaps(axis, key).empty()) continue;
      throw InputError({"--set", key, "a key that the axis \"" + axis.name + "\" of the campaign sets",
                        "keys that no axis sets"});
    }
  }
}

void check_subjects(const Source& source, const std::vector<Axis>& axes, bool is_alone)
{
  if (!is_alone) return;
  const auto subject =
      std::find_if(axes.begin(), axes.end(), [](const Axis& axis) { return axis.name == "subject"; });
  if (subject == axes.end()) {
    source.refuse("subject", "nothing", "a list of [[campaign.subject]], since the file is not a job");
  }
  for (std::size_t i = 0; i < subject->levels.size(); ++i) {
    if (!subject->levels[i].job.empty()) continue;
    source.refuse("subject." + std::to_string(i) + ".job", "nothing",
                  "the path of a job file, since the campaign's file is not a job");
  }
}

std::vector<std::string> names_of(const Axis& axis)
{
  std::vector<std::string> names;
  for (const Level& level : axis.levels) names.push_back(level.name);
  return names;
}

// Axis name -> level name.
using Combination = std::map<std::string, std::string>;

Combination combination_of(const Source& source, const std::vector<Axis>& axes,
                           const core::DocumentValue& table, const std::string& key)
{
  Combination combination;
  for (const auto& item : table.items()) {
    const auto axis =
        std::find_if(axes.begin(), axes.end(), [&](const Axis& a) { return a.name == item.key(); });
    const std::string at = key + "." + item.key();
    if (axis == axes.end()) source.refuse(at, "an axis that the campaign does not have", "one of its axes");
    const std::vector<std::string> names = names_of(*axis);
    const std::string& name = core::text_at(item.value(), "");
    if (std::find(names.begin(), names.end(), name) == names.end()) {
      source.refuse(at, "\"" + name + "\"",
                    "a level of that axis; the nearest is \"" + nearest_word(name, names) + "\"");
    }
    combination[item.key()] = name;
  }
  return combination;
}

std::vector<Combination> excluded(const Source& source, const std::vector<Axis>& axes,
                                  const core::DocumentValue& campaign)
{
  std::vector<Combination> combinations;
  for (const core::DocumentValue& table : core::list_or_empty(campaign, "exclude")) {
    combinations.push_back(
        combination_of(source, axes, table, "exclude." + std::to_string(combinations.size())));
  }
  return combinations;
}

using Chosen = std::vector<const Level*>;  // [axes]

bool is_excluded(const std::vector<Axis>& axes, const Chosen& chosen,
                 const std::vector<Combination>& combinations)
{
  return std::any_of(combinations.begin(), combinations.end(), [&](const Combination& combination) {
    for (std::size_t a = 0; a < axes.size(); ++a) {
      const auto found = combination.find(axes[a].name);
      if (found != combination.end() && found->second != chosen[a]->name) return false;
    }
    return true;
  });
}

CampaignCase case_of(const CaseSpec& base, const Chosen& chosen, const std::vector<std::string>& overrides)
{
  CampaignCase result{base, {}, {}};
  std::string name;
  for (const Level* level : chosen) {
    name += (name.empty() ? "" : "_") + level->name;
    result.levels.push_back(level->name);
    if (!level->job.empty()) result.spec.job_file = level->job;
    if (!level->data.empty()) result.spec.data_directory = level->data;
    result.spec.overrides.insert(result.spec.overrides.end(), level->overrides.begin(),
                                 level->overrides.end());
    result.override_keys.insert(result.override_keys.end(), level->overrides.size(), level->key + ".set");
  }
  if (!name.empty()) result.spec.name = name;
  result.spec.overrides.insert(result.spec.overrides.end(), overrides.begin(), overrides.end());
  return result;
}

// The k-th combination of the product, the last axis fastest.
Chosen chosen_at(const std::vector<Axis>& axes, std::size_t k)
{
  Chosen chosen(axes.size());
  for (std::size_t a = axes.size(); a-- > 0;) {
    chosen[a] = &axes[a].levels[k % axes[a].levels.size()];
    k /= axes[a].levels.size();
  }
  return chosen;
}

std::size_t n_combinations(const Source& source, const std::vector<Axis>& axes)
{
  std::size_t n = 1;
  for (const Axis& axis : axes) {
    n *= axis.levels.size();
    if (n > most_cases) {
      source.refuse(axis.name, "more than " + std::to_string(most_cases) + " cases with the preceding axes",
                    "axes with fewer levels, or several campaigns");
    }
  }
  return n;
}

// Key of the level that sets `key`, a part of it or a table with it; empty if none exists.
std::string override_location(const CampaignCase& one, const std::string& key)
{
  for (std::size_t k = 0; k < one.override_keys.size(); ++k) {
    if (do_overlap(key_of(one.spec.overrides[k]), key)) return one.override_keys[k] + "." + key;
  }
  return "";
}

void check_names(const Source& source, const std::vector<CampaignCase>& cases)
{
  std::set<std::string> names = reserved_names;
  for (const CampaignCase& one : cases) {
    if (names.insert(one.spec.name).second) continue;
    source.refuse("", "two folders named \"" + one.spec.name + "\"",
                  "level names that, joined by _, are unique for each case and none of logs, scripts "
                  "and tasks");
  }
}

}  // namespace

Campaign campaign_of(const std::string& job_or_campaign, const std::string& data_directory,
                     const std::vector<std::string>& overrides)
{
  const CaseSpec base = case_of_job(job_or_campaign, data_directory, overrides);
  const std::string bytes = job::file_bytes(
      job_or_campaign, {job_or_campaign, "", "", "a job or campaign file"}, largest_campaign_bytes);
  const core::Document document = core::read_toml(bytes, job_or_campaign);
  const core::DocumentValue* table = core::find_at(document.root, "campaign");
  if (table == nullptr) return {job_or_campaign, "", {}, {{base, {}, {}}}};

  job::check_campaign(document);
  const Source source{document};
  const std::vector<Axis> axes = axes_of(source, *table);
  check_subjects(source, axes, job::is_campaign_only(document.root));
  check_disjoint_keys(source, axes);
  check_overrides(axes, overrides);
  const std::vector<Combination> exclusions = excluded(source, axes, *table);
  Campaign campaign{job_or_campaign, core::text_or_empty(*table, "title"), {}, {}};
  for (const Axis& axis : axes) campaign.axes.push_back(axis.name);
  const std::size_t n = n_combinations(source, axes);
  const CaseSpec plain{base.name, base.job_file, base.data_directory, {}};
  for (std::size_t k = 0; k < n; ++k) {
    const Chosen chosen = chosen_at(axes, k);
    if (!is_excluded(axes, chosen, exclusions)) campaign.cases.push_back(case_of(plain, chosen, overrides));
  }
  if (campaign.cases.empty()) source.refuse("exclude", "every case excluded", "at least one case to run");
  if (!axes.empty()) check_names(source, campaign.cases);
  return campaign;
}

InputError error_of_case(const Campaign& campaign, const CampaignCase& one, const InputError& error)
{
  if (campaign.axes.empty()) return error;
  InputError::Facts facts = error.facts();
  // The format of Document::source_of() for overrides, which here come from levels, not from the user.
  constexpr std::string_view with_override = " with --set ";
  const std::size_t with = facts.file.find(with_override);
  if (facts.file == "--set") {
    if (const std::string location = override_location(one, facts.field); !location.empty()) {
      facts.file = campaign.file;
      facts.field = location;
    }
  } else if (with != std::string::npos) {
    const std::string location = override_location(one, facts.file.substr(with + with_override.size()));
    if (!location.empty())
      facts.file = facts.file.substr(0, with) + " with " + campaign.file + ": " + location;
  }
  facts.file = "case " + one.spec.name + ": " + facts.file;
  return InputError(facts);
}

namespace {

// Measured on one core of an Intel Xeon with two or three other busy cores, release build, on the generic
// knee with 1,200 to 75,000 contact triangles, with and without ligaments, and on four real knees with
// 75,000 to 97,000 (results/benchmarks.md), flexion steps of 1 to 10 degrees: log least squares.
constexpr double reference_triangles = 5000.0;

struct StepSeconds {
  double
      spine_s;  ///< per step at `reference_triangles`; spine steps are further from their seed than row steps
  double row_s;
};
// Equilibrium: 0.6 to 5.3 ms and 0.4 to 5.5 ms measured; one real knee 19 ms on its spine.
constexpr StepSeconds of_equilibrium{1.5e-3, 0.95e-3};
// Search: 14 to 150 ms and 12 to 80 ms measured.
constexpr StepSeconds of_search{30e-3, 19e-3};

// Generated meshes need more, 12 microseconds.
constexpr double load_s_of_triangle = 8e-6;
constexpr double load_s_at_least = 0.03;
// Recontacting one cell at `reference_triangles`, with its share of fitting and compression.
constexpr double finish_s_of_cell = 0.4e-3;
constexpr double finish_s_at_least = 0.03;

constexpr double memory_at_least = 20e6;
constexpr double memory_of_triangle = 1250.0;  // of contact meshes: vertices, trees, both objects' copies
constexpr double memory_of_cell = 8e3;

// A record grows with the number of contacts: 460 to 3,500 bytes measured, most on a fine regular mesh.
constexpr double journal_of_spine = 470.0;
constexpr double journal_of_row = 1000.0;

// A sample starts from the job's equilibria and both neighbouring flexions, and is measured: a typical count.
constexpr double starts_of_sample = 4.5;
constexpr double model_of_sample = 60.0;  // of each flexion, compressed

constexpr double model_at_least = 250e3;
constexpr double model_of_triangle = 22.0;  // compressed; all meshes, including display-only
constexpr double model_of_cell = 900.0;
constexpr double model_of_cell_and_fibre = 22.0;

// The exponent 1/2 needs only sqrt, which is equal on all processors; fitted exponents (0.53 to 0.57) improve
// the estimate by less than a tenth over the measured range.
double growth(std::int64_t n_triangles)
{
  return std::sqrt(static_cast<double>(n_triangles) / reference_triangles);
}

std::int64_t nearest_zero(const std::vector<double>& varus_rad)
{
  const auto nearer = [](double a, double b) { return std::abs(a) < std::abs(b); };
  return std::min_element(varus_rad.begin(), varus_rad.end(), nearer) - varus_rad.begin();
}

// The balanced cell, and the probes on either side of it.
std::int64_t probes_of_flexion(const solve::SweepPlan& plan)
{
  if (plan.spine == solve::SpineRule::nearest_zero) return 1;
  const std::int64_t column = nearest_zero(plan.varus_rad);
  const auto last = static_cast<std::int64_t>(plan.varus_rad.size()) - 1;
  return 1 + (column > 0 ? 1 : 0) + (column < last ? 1 : 0);
}

}  // namespace

const double cost_spread = 2.0;

StepCounts step_counts(const solve::SweepPlan& plan)
{
  check(!plan.flexion_rad.empty() && !plan.varus_rad.empty(), "step_counts: an empty grid");
  const auto n_flexion = static_cast<std::int64_t>(plan.flexion_rad.size());
  const auto n_varus = static_cast<std::int64_t>(plan.varus_rad.size());
  const auto n_rows = plan.rows ? static_cast<std::int64_t>(plan.rows->size()) : n_flexion;
  StepCounts counts;
  if (plan.spine == solve::SpineRule::free_varus) {
    const auto n_path = static_cast<std::int64_t>(path_of(plan).size());
    // Each neighbour's equilibrium is tried once at least, each set of small offsets too.
    const auto n_offsets = static_cast<std::int64_t>(polish_offsets(plan).size());
    counts.chain = 2 * n_path + 2 * (n_path - 1);
    counts.restarts = n_path * (plan.n_restarts + n_offsets);
    counts.bands = plan.has_band ? 2 * n_rows : 0;
    counts.cells = plan.is_varus_free ? 0 : n_rows * n_varus;
    counts.records = counts.all() + (plan.is_varus_free ? n_rows : 0);
  } else {
    counts.chain = n_flexion * probes_of_flexion(plan);
    counts.cells = n_rows * (n_varus - 1);
    counts.records = counts.all() + n_flexion;
  }
  return counts;
}

CaseCost cost_of(const CaseSize& size, const StepCounts& steps)
{
  const StepSeconds step = size.is_search ? of_search : of_equilibrium;
  const double factor = growth(size.n_contact_triangles);
  const auto n_triangles = static_cast<double>(size.n_triangles);
  const auto n_cells = static_cast<double>(size.n_flexion * size.n_varus);
  CaseCost cost;
  cost.steps = steps;
  cost.load_s = load_s_at_least + load_s_of_triangle * n_triangles;
  cost.chain_s = step.spine_s * factor * static_cast<double>(steps.chain);
  cost.spine_s = step.spine_s * factor * static_cast<double>(steps.spine());
  const auto n_sampled = static_cast<double>(size.n_samples * size.n_flexion);
  cost.rows_s = step.row_s * factor * (static_cast<double>(steps.rows()) + starts_of_sample * n_sampled);
  cost.finish_s =
      finish_s_at_least + finish_s_of_cell * factor * n_cells * static_cast<double>(size.n_smoothed);
  cost.memory_bytes = memory_at_least + memory_of_triangle * static_cast<double>(size.n_contact_triangles) +
                      memory_of_cell * n_cells;
  cost.journal_bytes = journal_of_spine * static_cast<double>(steps.records - steps.rows()) +
                       journal_of_row * (static_cast<double>(steps.rows()) + n_sampled);
  cost.model_bytes =
      model_at_least + model_of_triangle * n_triangles +
      (model_of_cell + model_of_cell_and_fibre * static_cast<double>(size.n_fibres)) * n_cells +
      model_of_sample * n_sampled;
  return cost;
}

}  // namespace vrda::run
