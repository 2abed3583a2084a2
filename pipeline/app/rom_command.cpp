// `vrda rom`: the rotations that a joint can reach.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>

#include "analysis/rom_files.hpp"
#include "app/commands.hpp"
#include "app/option_values.hpp"
#include "app/printing.hpp"
#include "core/document.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "job/job.hpp"
#include "report/result_pages.hpp"
#include "run/run_output.hpp"
#include "run/submission.hpp"

namespace vrda::app {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

struct RomOptions : job::JobSource {
  std::string folder;
  std::string flexion, varus, internal;  ///< FROM:TO:STEP, degrees; empty: 0, not driven
  std::string translation_mm = "2";      ///< or "free"
  double opening_mm = 0.5;
  double strain = 0.1;
  std::string delta_of;              ///< "moving" or "reference"; empty: as the job's push
  std::vector<std::string> compare;  ///< two rom.json, instead of a job
  std::string shard;                 ///< "I/N", or empty
  bool is_fresh = false;
  bool may_replace = false;
  int n_threads = 0;  ///< 0: one per processor
  std::string progress = "auto";
  bool as_json = false;
};

constexpr std::size_t most_cells = 1'000'000;
constexpr std::uintmax_t largest_file_bytes = 1U << 30U;

std::vector<double> radians_of(const std::string& option, const std::string& text)
{
  if (text.empty()) return {0.0};
  std::vector<double> values;
  for (const double deg : angle_range({"vrda rom", option}, text)) {
    // Beyond, the varus angle is not one of the three.
    const double largest_deg = option == "--varus" ? 89.0 : 180.0;
    if (std::abs(deg) > largest_deg) {
      throw InputError({"vrda rom", option, text,
                        "angles from -" + std::to_string(static_cast<int>(largest_deg)) + " to " +
                            std::to_string(static_cast<int>(largest_deg)) + " degrees"});
    }
    values.push_back(rad_from_deg(deg));
  }
  return values;
}

analysis::RomPlan plan_of(const RomOptions& o)
{
  analysis::RomPlan plan;
  plan.axes.rad = {radians_of("--flexion", o.flexion), radians_of("--varus", o.varus),
                   radians_of("--internal", o.internal)};
  const auto n_driven = std::count_if(plan.axes.rad.begin(), plan.axes.rad.end(),
                                      [](const std::vector<double>& rad) { return rad.size() > 1; });
  if (n_driven < 2) {
    throw InputError({"vrda rom", "--flexion, --varus, --internal",
                      std::to_string(n_driven) + " driven rotations",
                      "two or three ranges such as --flexion -20:120:5 --varus -45:45:5"});
  }
  if (plan.axes.n_cells() > most_cells)
    throw InputError({"vrda rom", "--flexion, --varus, --internal",
                      std::to_string(plan.axes.n_cells()) + " attitudes", "at most 1000000"});
  plan.limits.translation_mm = o.translation_mm == "free" ? std::numeric_limits<double>::infinity()
                                                          : finite_number(o.translation_mm).value_or(nan);
  plan.limits.opening_mm = o.opening_mm;
  plan.limits.strain = o.strain;
  plan.n_threads = run::thread_count_or_all(o.n_threads);
  plan.is_stopped = core::is_interrupted;
  return plan;
}

analysis::RomDocument read_rom(const std::string& file)
{
  return analysis::parse_rom(
      file, job::file_bytes(file, {file, "", "no such file", "rom.json of vrda rom"}, largest_file_bytes));
}

// The file has degrees, whose conversion rounds.
bool is_same_axis(const std::vector<double>& a_rad, const std::vector<double>& b_rad)
{
  constexpr double tolerance_rad = 1e-12;
  return std::equal(a_rad.begin(), a_rad.end(), b_rad.begin(), b_rad.end(),
                    [](double a, double b) { return std::abs(a - b) <= tolerance_rad; });
}

// Refuses the result of another job or of other limits.
void require_same_or_absent(const std::string& file, const job::Case& job_case, const analysis::RomPlan& plan)
{
  std::error_code error;
  if (!fs::exists(file, error)) return;
  const analysis::RomDocument found = read_rom(file);
  const auto refuse = [&](const std::string& what, const std::string& found_text) {
    throw InputError({file, what, found_text, "this one's, another --output, or --replace"});
  };
  if (found.job != job_case.resolved_job) refuse("job", "the result of another job, \"" + found.title + "\"");
  const analysis::RangeOfMotion& range = found.range;
  for (std::size_t a = 0; a < 3; ++a) {
    if (!is_same_axis(range.axes.rad[a], plan.axes.rad[a])) refuse("axes", "other rotations");
  }
  if (range.limits.translation_mm != plan.limits.translation_mm ||
      range.limits.opening_mm != plan.limits.opening_mm || range.limits.strain != plan.limits.strain ||
      range.delta_body != plan.delta_body)
    refuse("limits", "other limits");
}

Json volume_json(const analysis::RomVolume& volume)
{
  return {{"attitudes", volume.n_cells},
          {"volume_deg", volume.volume},
          {"share", volume.volume / volume.driven_volume}};
}

std::string name_or_dash(const std::vector<std::string>& names, std::int32_t row)
{
  return row < 0 ? "-" : names[static_cast<std::size_t>(row)];
}

Json end_json(const analysis::RomDocument& document, const analysis::RangeEnd& end)
{
  Json json = {{"deg", end.deg}, {"ended_by", end.is_of_axis ? "not_tried" : analysis::name_of(end.beyond)}};
  if (!end.is_of_axis) {
    json["reference"] = name_or_dash(document.reference_names, end.component_reference);
    json["moving"] = name_or_dash(document.moving_names, end.component_moving);
    if (end.beyond == analysis::RomStatus::fibre)
      json["fibre"] = name_or_dash(document.fibre_names, end.fibre);
  }
  return json;
}

std::string end_text(const analysis::RomDocument& document, const analysis::RangeEnd& end)
{
  return formatted("%g", end.deg) + " (" + analysis::cause_of(document, end) + ")";
}

Json ends_json(const analysis::RomDocument& document)
{
  Json ends = Json::object();
  for (const analysis::RangeAlong& along : analysis::boundaries_of(document.range)) {
    if (along.at != document.range.neutral) continue;
    ends[analysis::rotation_names[along.axis]] =
        along.is_empty
            ? Json()
            : Json({{"from", end_json(document, along.low)}, {"to", end_json(document, along.high)}});
  }
  return ends;
}

std::map<std::string, int> statuses_of(const analysis::RangeOfMotion& range)
{
  std::map<std::string, int> counts;
  for (const analysis::RomCell& cell : range.cells) ++counts[analysis::name_of(cell.status)];
  return counts;
}

void print(const analysis::RomDocument& document, const std::vector<std::string>& files, bool as_json)
{
  const analysis::RomVolume volume = analysis::volume_of(document.range);
  if (as_json) {
    const Json json = {{"statuses", statuses_of(document.range)},
                       {"in_range", volume_json(volume)},
                       {"neutral_ends", ends_json(document)},
                       {"files", files}};
    print_json(json);
    return;
  }
  std::vector<std::string> counts;
  for (const auto& [name, n] : statuses_of(document.range)) counts.push_back(std::to_string(n) + ' ' + name);
  std::printf("%zu attitudes: %s\n", document.range.cells.size(), joined(counts).c_str());
  std::printf("in range: %.6g degrees^%d, %.3g %% of the driven box\n", volume.volume, volume.n_driven,
              100.0 * volume.volume / volume.driven_volume);
  for (const analysis::RangeAlong& along : analysis::boundaries_of(document.range)) {
    if (along.at != document.range.neutral) continue;
    const std::string ends = along.is_empty
                                 ? "not in range at the neutral attitude"
                                 : end_text(document, along.low) + " to " + end_text(document, along.high);
    std::printf("  %-9s %s\n", analysis::rotation_names[along.axis], ends.c_str());
  }
  for (const std::string& file : files) std::printf("%s\n", file.c_str());
}

std::vector<std::string> journals_of(const std::string& file)
{
  std::vector<std::string> list = store::list_shard_journals_if_readable(file);
  std::error_code error;
  if (fs::exists(store::journal_of(file), error)) list.push_back(store::journal_of(file));
  return list;
}

/// The range, or that of a shard, which has no cells; empty when interrupted.
std::optional<analysis::RangeOfMotion> solved(const RomOptions& o, const std::string& file,
                                              const job::Case& job_case, analysis::RomPlan& plan)
{
  const std::string key = analysis::rom_key(job_case, plan);
  analysis::RomLines lines;
  if (o.is_fresh && !plan.shard) run::remove_obsolete_files(journals_of(file));
  if (!plan.shard) {
    for (const std::string& shard : store::list_shard_journals_if_readable(file))
      analysis::read_lines(shard, key, lines);
  }
  const std::string path = plan.shard ? store::shard_journal_of(file, *plan.shard) : store::journal_of(file);
  core::FrameWriter journal = analysis::open_lines(path, key, o.is_fresh, lines);
  core::Progress progress(core::progress_style_of(o.progress), "attitudes",
                          static_cast<int>(plan.axes.n_cells()), 0);
  plan.on_progress = [&](std::size_t) { progress.advance(); };
  plan.recall = [&](std::int8_t axis, const std::array<std::int32_t, 3>& at) {
    const auto found = lines.find({axis, at});
    return found == lines.end() ? std::nullopt : std::optional(found->second);
  };
  plan.keep = [&](const analysis::RomLine& line) { journal.append(core::bytes_of_value(line)); };
  analysis::RangeOfMotion range = analysis::range_of_motion(job_case, plan);
  journal.close();
  if (core::is_interrupted()) {
    core::log_info(path + ": repeat the command to resume");
    return std::nullopt;
  }
  if (plan.shard) std::printf("%s\n", path.c_str());
  return range;
}

// Publishes the files in the folder, the last one as the main file; returns their paths.
std::vector<std::string> published(Publication& result, const fs::path& folder,
                                   const std::vector<std::pair<const char*, std::string>>& outputs)
{
  std::vector<std::string> files;
  for (const auto& [name, text] : outputs) {
    files.push_back((folder / name).string());
    if (name == outputs.back().first) {
      result.publish(text);
    } else {
      result.add(files.back(), text);
    }
  }
  return files;
}

core::ExitCode compare(const RomOptions& o)
{
  const analysis::RomDocument a = read_rom(o.compare[0]), b = read_rom(o.compare[1]);
  const analysis::RomComparison found = analysis::compare_ranges(a.range, b.range, o.compare[1]);
  std::vector<std::string> files;
  if (!o.folder.empty()) {
    run::make_folder(o.folder);
    std::optional<Publication> result =
        run::begin_result((fs::path(o.folder) / "comparison.csv").string(), "vrda rom --compare");
    if (!result) return core::ExitCode::interrupted;
    files = published(*result, o.folder,
                      {{"comparison.html", report::range_comparison_page(a, b)},
                       {"comparison.png", analysis::maps_picture(analysis::comparison_maps(a, b))},
                       {"comparison.csv", analysis::comparison_csv(a, b)}});
  }
  const std::pair<const char*, const analysis::RomVolume&> rows[] = {{"first", found.a},
                                                                     {"second", found.b},
                                                                     {"both", found.both},
                                                                     {"only_first", found.only_a},
                                                                     {"only_second", found.only_b}};
  if (o.as_json) {
    Json json = Json::object();
    for (const auto& [name, volume] : rows) json[name] = volume_json(volume);
    if (!files.empty()) json["files"] = files;
    return print_json(json);
  }
  std::printf("%-12s %10s %16s %10s\n", "", "attitudes",
              ("degrees^" + std::to_string(found.a.n_driven)).c_str(), "% of box");
  for (const auto& [name, volume] : rows) {
    std::printf("%-12s %10zu %16.6g %10.3g\n", name, volume.n_cells, volume.volume,
                100.0 * volume.volume / volume.driven_volume);
  }
  for (const std::string& file : files) std::printf("%s\n", file.c_str());
  return core::ExitCode::done;
}

// Resumes from its journal and those of shards in the folder, which it removes at the end. With `shard`
// writes only a journal. Writes rom.json, rom.csv, boundary.csv, index.html and rom.png into the folder and
// prints volume and ends; or compares two rom.json, into the folder if one is given. Throws InputError
// before solving if less than two rotations are driven, or if the folder has the result of another job or of
// other limits.
core::ExitCode rom_command(const RomOptions& o)
{
  if (!o.compare.empty()) {
    if (!o.job_file.empty())
      throw InputError({"vrda rom", "--compare", "a job", "the two files, and --output at most"});
    return compare(o);
  }
  if (o.job_file.empty() || o.folder.empty())
    throw InputError({"vrda rom", o.job_file.empty() ? "job" : "--output", "nothing",
                      "vrda rom JOB -o FOLDER, or --compare A B"});
  analysis::RomPlan plan = plan_of(o);
  const job::Case job_case = job::scaled_to_subject(run::load_and_report_case(o.job_file, o));
  const bool is_of_reference =
      o.delta_of.empty() ? job_case.is_push_fixed_in_reference : o.delta_of == "reference";
  plan.delta_body = is_of_reference ? BodyIndex::reference : BodyIndex::moving;
  const fs::path folder = o.folder;
  const std::string file = (folder / "rom.json").string();
  run::make_folder(folder.string());
  if (!o.shard.empty()) plan.shard = run::shard_of(o.shard);
  // Shards run in parallel, each with its own journal.
  std::optional<Publication> result =
      run::begin_result(plan.shard ? store::shard_journal_of(file, *plan.shard) : file, "vrda rom");
  if (!result) return core::ExitCode::interrupted;
  if (!o.may_replace) require_same_or_absent(file, job_case, plan);
  const std::optional<analysis::RangeOfMotion> range = solved(o, file, job_case, plan);
  if (!range) return core::ExitCode::interrupted;
  if (plan.shard) return core::ExitCode::done;
  const analysis::RomDocument document = analysis::rom_document(job_case, *range, "vrda " VRDA_VERSION);
  const std::vector<std::string> files =
      published(*result, folder,
                {{"index.html", report::range_page(document)},
                 {"rom.png", analysis::maps_picture(analysis::status_maps(document))},
                 {"rom.csv", analysis::rom_csv(document)},
                 {"boundary.csv", analysis::boundary_csv(document)},
                 {"rom.json", analysis::rom_json(document)}});
  run::remove_obsolete_files(journals_of(file));
  print(document, files, o.as_json);
  return core::ExitCode::done;
}

}  // namespace

void declare_rom(Command& c)
{
  auto& o = c.options<RomOptions>();
  constexpr double largest = 1e6;
  c.option("job", o.job_file, "Job file (TOML); its grid is not used");
  c.option("-o,--output", o.folder, "Output folder: rom.json, rom.csv, boundary.csv, index.html, rom.png");
  c.loading(o);
  c.option("--flexion", o.flexion, "FROM:TO:STEP, degrees; default: 0, not driven");
  c.option("--varus", o.varus, "FROM:TO:STEP, degrees (adduction +); default: 0, not driven");
  c.option("--internal", o.internal, "FROM:TO:STEP, degrees; default: 0, not driven");
  c.option("--translation-mm", o.translation_mm,
           "Largest translation of the rotation centre from the neutral seat along each axis across "
           "Delta, or free")
      .number(0.0, largest, {"free"})
      .shows_default();
  c.option("--opening-mm", o.opening_mm,
           "Largest translation of the rotation centre from the neutral seat against Delta")
      .number(0.0, largest)
      .shows_default();
  c.option("--strain", o.strain, "Largest strain of a fibre").number(0.0, largest).shows_default();
  c.option("--delta-of", o.delta_of,
           "The object to which Delta is fixed: moving or reference; default: as push.frame of the job")
      .one_of({"moving", "reference"});
  c.option("--compare", o.compare,
           "Two rom.json: volume of each, common, only in one; with --output also maps as "
           "comparison.html and comparison.png, and comparison.csv")
      .takes(2);
  c.option("--shard", o.shard,
           "I/N: solve every Nth flexion from the Ith on, into a journal in the folder; the same command "
           "without --shard joins them");
  c.flag("--fresh", o.is_fresh, "Discard the journals in the folder");
  c.flag("--replace", o.may_replace, "Replace the result of another job or of other limits");
  c.threads(o.n_threads);
  c.progress(o.progress);
  c.json(o.as_json);
  c.runs([&o] { return rom_command(o); });
}

}  // namespace vrda::app
