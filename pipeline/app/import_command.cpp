#include "app/import_command.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "audit/audit.hpp"
#include "core/clinical.hpp"
#include "core/error.hpp"
#include "core/open_file.hpp"
#include "core/text.hpp"
#include "documents/json_file.hpp"
#include "job_run/run_output.hpp"
#include "job_run/summary.hpp"
#include "load/input_file.hpp"
#include "measured/angle_plausibility.hpp"
#include "measured/motion_poses.hpp"
#include "model_build/case_solver.hpp"
#include "motion_import/convention_search.hpp"
#include "motion_import/imported_model.hpp"
#include "store/motion_model_file.hpp"
#include "store/solved_cells.hpp"

namespace vrda::app {
namespace {

using Json = nlohmann::ordered_json;
using motion_import::Candidate;
using motion_import::ConventionSearch;
using motion_import::Term;

constexpr std::size_t most_printed = 12;

/// The value whose name is `word`; empty for "" and "auto".
template <typename Value, typename NameOf>
std::optional<Value> value_named(const std::string& word, std::initializer_list<Value> values, NameOf name_of)
{
  for (const Value value : values)
    if (word == name_of(value)) return value;
  return std::nullopt;
}

motion_import::SearchRequest request_of(const ImportOptions& o)
{
  using namespace measured;
  const auto name = [](auto value) { return name_of(value); };
  motion_import::SearchRequest request;
  StatedConvention& stated = request.stated;
  stated.length_mm = value_named(o.unit, {1.0, 10.0, 1000.0}, length_unit_name);
  stated.angles = angle_unit_named(o.angles);
  stated.order = value_named(
      o.order,
      {AngleOrder::xyz, AngleOrder::xzy, AngleOrder::yxz, AngleOrder::yzx, AngleOrder::zxy, AngleOrder::zyx},
      name);
  stated.direction =
      value_named(o.direction, {Direction::moving_in_reference, Direction::reference_in_moving}, name);
  stated.axes = value_named(o.axes, {TableAxes::canonical, TableAxes::files}, name);
  stated.side = value_named(o.side, {Side::right, Side::left}, name_of_side);
  stated.lengths =
      value_named(o.lengths, {LengthPoint::origin, LengthPoint::centre, LengthPoint::grood_suntay}, name);
  const std::pair<const std::string&, Term> words[] = {
      {o.unit, Term::unit},           {o.angles, Term::angles}, {o.order, Term::order},
      {o.direction, Term::direction}, {o.axes, Term::axes},     {o.side, Term::side},
      {o.lengths, Term::lengths}};
  for (const auto& [word, term] : words)
    if (word == "auto") request.automatic.insert(term);
  return request;
}

measured::TableColumns columns_of(const ImportOptions& o)
{
  measured::TableColumns columns;
  columns.of_coordinate = measured::names_by_coordinate("vrda import", "--column", o.columns);
  columns.key = o.key;
  columns.moving_prefix = o.moving_prefix;
  columns.reference_prefix = o.reference_prefix;
  columns.reference_file = o.reference_motion;
  return columns;
}

/// "--order zxy --side right": the options that state a convention's terms.
std::string options_text(const measured::Convention& convention, const std::vector<Term>& terms)
{
  std::string text;
  for (const Term term : terms)
    text += (text.empty() ? "--" : " --") + std::string(motion_import::name_of(term)) + ' ' +
            motion_import::value_of(convention, term);
  return text;
}

/// "order: xyz, yxz or yzx; side: right or left".
std::string alternatives_text(const ConventionSearch& search)
{
  std::string text;
  for (const Term term : search.undecided) {
    std::vector<std::string> values;
    for (std::size_t i = 0; i < search.n_best; ++i) {
      const std::string value = motion_import::value_of(search.candidates[i].convention, term);
      if (std::find(values.begin(), values.end(), value) == values.end()) values.push_back(value);
    }
    text += (text.empty() ? "" : "; ") + std::string(motion_import::name_of(term)) + ": " +
            join_alternatives(values);
  }
  return text;
}

Json json_of(const measured::Convention& convention)
{
  Json json = Json::object();
  for (const Term term : motion_import::all_terms)
    json[motion_import::name_of(term)] = motion_import::value_of(convention, term);
  return json;
}

Json finite_or_null(double value)
{
  return std::isfinite(value) ? Json(value) : Json();
}

Json json_of(const ConventionSearch& search)
{
  Json candidates = Json::array();
  for (const Candidate& c : search.candidates) {
    Json gaps = Json::array();
    for (const motion_import::GapSpread& gap : c.gaps)
      gaps.push_back({{"mean_mm", gap.mean_mm}, {"deviation_mm", gap.deviation_mm}});
    candidates.push_back({{"convention", json_of(c.convention)},
                          {"gaps", gaps},
                          {"deviation_mm", finite_or_null(c.deviation_mm)},
                          {"motion_mm", c.motion_mm},
                          {"share", finite_or_null(c.share)}});
  }
  Json undecided = Json::array();
  for (const Term term : search.undecided) undecided.push_back(motion_import::name_of(term));
  return {{"candidates", candidates}, {"equally_good", search.n_best}, {"undecided", undecided}};
}

std::string gap_text(const std::vector<motion_import::GapSpread>& gaps)
{
  std::string text;
  for (const motion_import::GapSpread& gap : gaps) {
    char part[48];
    std::snprintf(part, sizeof part, "%s%.3f (%.2f)", text.empty() ? "" : ", ", gap.deviation_mm,
                  gap.mean_mm);
    text += part;
  }
  return text.empty() ? "nothing faces" : text;
}

void print(const ConventionSearch& search)
{
  if (search.candidates.size() < 2) return;
  constexpr const char* row = "%-5s %-6s %-5s %-19s %-9s %-5s %-12s %8s  %s\n";
  std::printf(row, "unit", "angles", "order", "direction", "axes", "side", "lengths", "share",
              "gaps along Delta, mm: standard deviation (mean) of each compartment");
  std::size_t n = 0;
  for (const Candidate& c : search.candidates) {
    if (n++ == std::max(most_printed, search.n_best) || !std::isfinite(c.share)) break;
    std::vector<std::string> words;
    for (const Term term : motion_import::all_terms)
      words.push_back(motion_import::value_of(c.convention, term));
    char share[24];
    std::snprintf(share, sizeof share, "%.4f", c.share);
    std::printf(row, words[0].c_str(), words[1].c_str(), words[2].c_str(), words[3].c_str(), words[4].c_str(),
                words[5].c_str(), words[6].c_str(), share, gap_text(c.gaps).c_str());
  }
  std::printf("%zu conventions tried, %zu of them cannot be distinguished\n", search.candidates.size(),
              search.n_best == 1 ? 0 : search.n_best);
}

void require_decided(const ConventionSearch& search, const std::string& motion_file)
{
  if (search.n_best == 1) return;
  throw InputError(
      {motion_file, "convention", "no difference in the gaps between " + alternatives_text(search),
       "them stated, e.g. " + options_text(search.candidates.front().convention, search.undecided)});
}

/// Added to the resolved job, so that the import of another table is another result.
std::string record_of(const ImportOptions& o, const measured::Convention& convention)
{
  std::string text = "\n[import]\nmotion = \"" + std::filesystem::path(o.motion).filename().string() + "\"\n";
  for (const Term term : motion_import::all_terms)
    text += std::string(motion_import::name_of(term)) + " = \"" + motion_import::value_of(convention, term) +
            "\"\n";
  return text;
}

void add_input(load::Case& job_case, const std::string& file)
{
  if (file.empty()) return;
  const std::string bytes =
      load::file_bytes(file, {file, "", "", "a table with one pose per frame"}, std::uintmax_t{1} << 28);
  job_case.inputs.push_back({std::filesystem::path(file).filename().string(), load::sha256_of(bytes), true});
}

/// Both bodies of the job, and the table under the convention found.
struct Found {
  ConventionSearch search;
  measured::MotionSequence motion;
};

Found found_motion(const ImportOptions& o, const load::Case& subject, const motion_import::ImportFrame& frame)
{
  const measured::MotionTable table = measured::read_motion_table(o.motion, columns_of(o));
  motion_import::SearchRequest request = request_of(o);
  if (!frame.has_file_axes) {
    if (request.stated.axes == measured::TableAxes::files)
      throw InputError({"vrda import", "--axes", "files with a job that has [scaling]", "canonical"});
    request.stated.axes = measured::TableAxes::canonical;
  }
  const solve::Joint joint = model_build::joint_of(subject, subject.frame);
  const motion_import::SearchScene scene{subject.frame, joint, bounding_box(subject.moving.contact.mesh)};
  Found found;
  found.search = motion_import::find_convention(table, request, frame.joint, scene,
                                                job_run::thread_count_or_all(o.n_threads));
  const measured::Convention& convention = found.search.candidates.front().convention;
  const bool is_searched = request.automatic.count(Term::angles) > 0 || !table.stated.angles;
  const measured::UnitSource source = request.stated.angles ? measured::UnitSource::option
                                      : is_searched         ? measured::UnitSource::found
                                                            : measured::UnitSource::file;
  found.motion = {
      table.key_name, table.key, measured::poses_of(table, convention, frame.joint), {}, table.warnings};
  for (const std::string& line : measured::unit_warnings(table, convention.angles, source, frame.joint))
    found.motion.warnings.push_back(line);
  return found;
}

/// Of the imported poses, as measured by an audit; empty without overlap.
std::string overlap_text(const store::MotionModel& model, int n_threads)
{
  const audit::AuditFigures figures = audit::figures_of(audit::audit(model, "raw", 1, n_threads));
  if (figures.n_overlapping == 0) return "";
  char text[256];
  std::snprintf(
      text, sizeof text,
      "the bones overlap in %d of %d frames, by at most %.1f mm at %s %.4g; vrda repair finds the nearest "
      "motion without overlap",
      figures.n_overlapping, figures.n_poses, figures.largest_penetration.value_mm,
      model.frames->key_name.c_str(), figures.largest_penetration.key);
  return text;
}

}  // namespace

console::ExitCode import_command(const ImportOptions& o)
{
  job_run::require_plain_text("--motion", o.motion);
  job_run::require_plain_text("--reference-motion", o.reference_motion);
  const load::LoadOptions where{o.data_directory, o.overrides};
  const load::Case job_case =
      load::with_one_delta(job_run::load_and_report_case(o.job_file, where), o.job_file);
  const load::Case subject = load::scaled_to_subject(job_case);
  const motion_import::ImportFrame frame =
      motion_import::import_frame(load::read_job(o.job_file, o.overrides), job_case);
  const Found found = found_motion(o, subject, frame);
  if (!o.as_json) print(found.search);
  if (o.as_json && found.search.n_best != 1)
    std::printf("%s\n", documents::json_text(json_of(found.search), 2).c_str());
  for (const std::string& line : found.motion.warnings) console::log_warning(line);
  require_decided(found.search, o.motion);

  const measured::Convention& convention = found.search.candidates.front().convention;
  load::Case import_case = motion_import::import_case(job_case, found.motion, record_of(o, convention));
  for (const std::string& file : {o.motion, o.reference_motion}) add_input(import_case, file);
  const std::string output = job_run::output_path_of(o.output, o.job_file);
  job_run::make_parent_folder(output);
  const std::optional<OutputLock> lock = job_run::lock_output(output, "vrda import");
  if (!lock) return console::ExitCode::interrupted;
  job_run::existing_result(import_case, output, o.may_replace);  // throws for another result
  const int n_threads = job_run::thread_count_or_all(o.n_threads);
  const store::MotionModel model = motion_import::imported_model(import_case, found.motion, n_threads);
  store::write_motion_model(output, model);
  console::log_info(
      std::to_string(found.motion.key.size()) + " frames over " + found.motion.key_name + ": " +
      options_text(convention, {std::begin(motion_import::all_terms), std::end(motion_import::all_terms)}));
  const std::string gimbal_lock = gimbal_lock_text(store::clinical_curves(model).n_locked);
  if (!gimbal_lock.empty()) console::log_warning(output + ": " + gimbal_lock);
  const std::string overlap = overlap_text(model, n_threads);
  if (!overlap.empty()) console::log_warning(output + ": " + overlap);
  if (o.as_json) {
    Json json = json_of(found.search);
    json["convention"] = json_of(convention);
    json["frames"] = found.motion.key.size();
    json["key_name"] = found.motion.key_name;
    json["output"] = output;
    std::printf("%s\n", documents::json_text(json, 2).c_str());
  } else {
    std::printf("%s\n", output.c_str());
  }
  return console::ExitCode::done;
}

}  // namespace vrda::app
