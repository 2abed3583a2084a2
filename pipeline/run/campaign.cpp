#include "run/campaign.hpp"

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>

#include "core/error.hpp"
#include "core/text.hpp"
#include "job/input_file.hpp"
#include "job/job_schema.hpp"

namespace vrda::run {
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
  const core::DocumentValue::Table* table = value.table();
  if (table == nullptr || (table->empty() && !path.empty())) {
    leaves.push_back(path + "=" + core::value_text(value));
    return;
  }
  for (const core::DocumentEntry& entry : *table) {
    if (entry.key.empty() || entry.key.find_first_of(".=") != std::string::npos) {
      source.refuse(at, "the key \"" + entry.key + "\"", "keys without '.' and '='");
    }
    add_leaves(source, at, entry.value, path.empty() ? entry.key : path + "." + entry.key, leaves);
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
  if (const core::DocumentValue* settings = table.find("set")) {
    if (settings->find("campaign") != nullptr) source.refuse(key + ".set", "campaign", "keys of a job");
    add_leaves(source, key + ".set", *settings, "", level.overrides);
  }
  return level;
}

Axis axis_of(const Source& source, const core::DocumentEntry& entry)
{
  Axis axis{entry.key, {}, {}};
  std::set<std::string> names;
  for (const core::DocumentValue& table : *entry.value.list()) {
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
  for (const core::DocumentEntry& entry : *campaign.table()) {
    if (entry.key != "title" && entry.key != "exclude") axes.push_back(axis_of(source, entry));
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
  for (const core::DocumentEntry& entry : *table.table()) {
    const auto axis =
        std::find_if(axes.begin(), axes.end(), [&](const Axis& a) { return a.name == entry.key; });
    const std::string at = key + "." + entry.key;
    if (axis == axes.end()) source.refuse(at, "an axis that the campaign does not have", "one of its axes");
    const std::vector<std::string> names = names_of(*axis);
    const std::string& name = *entry.value.text();
    if (std::find(names.begin(), names.end(), name) == names.end()) {
      source.refuse(at, "\"" + name + "\"",
                    "a level of that axis; the nearest is \"" + nearest_word(name, names) + "\"");
    }
    combination[entry.key] = name;
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
  const core::Document document{job_or_campaign, core::parse_toml(bytes, job_or_campaign)};
  const core::DocumentValue* table = document.root.find("campaign");
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

}  // namespace vrda::run
