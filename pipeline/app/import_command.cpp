// `vrda import`: a motion model from measured poses.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "analysis/audit.hpp"
#include "app/commands.hpp"
#include "app/printing.hpp"
#include "core/document.hpp"
#include "core/fields_json.hpp"
#include "core/files.hpp"
#include "core/text.hpp"
#include "job/job.hpp"
#include "model/coordinates.hpp"
#include "run/run_output.hpp"
#include "solve/case_solver.hpp"
#include "store/motion_model.hpp"
#include "store/solved_cells.hpp"
#include "tables/convention_search.hpp"
#include "tables/imported_model.hpp"

namespace vrda::app {
namespace {

using Json = nlohmann::ordered_json;
using tables::Candidate;
using tables::ConventionSearch;
using tables::Term;

struct ImportOptions : job::JobSource {
  std::string motion;            ///< file of the moving object's poses
  std::string reference_motion;  ///< file of the reference's poses in the same frame; may be empty
  /// Words of tables/motion_table.hpp, "auto" (try all), or empty: as the file states, else try all.
  std::string unit, angles, order, direction, axes, side, lengths;
  std::string key;                            ///< column; empty: found
  std::vector<std::string> columns;           ///< COORDINATE=COLUMN
  std::vector<std::string> follower_columns;  ///< FOLLOWER.COORDINATE=COLUMN
  std::string moving_prefix, reference_prefix;
  std::string output;  ///< may be empty: as of `vrda run`
  bool may_replace = false;
  int n_threads = 0;  ///< 0: one per processor
  bool as_json = false;
};

constexpr std::size_t most_printed = 12;

tables::SearchRequest request_of(const ImportOptions& o)
{
  using namespace tables;
  tables::SearchRequest request;
  StatedConvention& stated = request.stated;
  for (const double length_mm : {1.0, 10.0, 1000.0})
    if (o.unit == length_unit_name(length_mm)) stated.length_mm = length_mm;
  // "" and "auto" name no value.
  stated.angles = core::value_named<AngleUnit>(o.angles);
  stated.order = core::value_named<AngleOrder>(o.order);
  stated.direction = core::value_named<Direction>(o.direction);
  stated.axes = core::value_named<TableAxes>(o.axes);
  for (const Side side : {Side::right, Side::left})
    if (o.side == side_name(side)) stated.side = side;
  stated.lengths = core::value_named<LengthPoint>(o.lengths);
  const std::pair<const std::string&, Term> words[] = {
      {o.unit, Term::unit},           {o.angles, Term::angles}, {o.order, Term::order},
      {o.direction, Term::direction}, {o.axes, Term::axes},     {o.side, Term::side},
      {o.lengths, Term::lengths}};
  for (const auto& [word, term] : words)
    if (word == "auto") request.automatic.insert(term);
  return request;
}

tables::TableColumns columns_of(const ImportOptions& o)
{
  tables::TableColumns columns;
  columns.of_coordinate = tables::names_by_coordinate("vrda import", "--column", o.columns);
  columns.key = o.key;
  columns.moving_prefix = o.moving_prefix;
  columns.reference_prefix = o.reference_prefix;
  columns.reference_file = o.reference_motion;
  return columns;
}

/// "--order zxy --side right": the options that state a convention's terms.
std::string options_text(const tables::Convention& convention, const std::vector<Term>& terms)
{
  std::vector<std::string> words;
  for (const Term term : terms)
    words.push_back(std::string("--") + core::name_of(term) + ' ' + tables::value_of(convention, term));
  return joined(words, " ");
}

/// "order: xyz, yxz or yzx; side: right or left".
std::string alternatives_text(const ConventionSearch& search)
{
  std::string text;
  for (const Term term : search.undecided) {
    std::vector<std::string> values;
    for (std::size_t i = 0; i < search.n_best; ++i) {
      const std::string value = tables::value_of(search.candidates[i].convention, term);
      if (std::find(values.begin(), values.end(), value) == values.end()) values.push_back(value);
    }
    text += (text.empty() ? "" : "; ") + std::string(core::name_of(term)) + ": " + join_alternatives(values);
  }
  return text;
}

Json json_of(const tables::Convention& convention)
{
  Json json = Json::object();
  for (const Term term : tables::all_terms) json[core::name_of(term)] = tables::value_of(convention, term);
  return json;
}

Json json_of(const ConventionSearch& search)
{
  Json candidates = Json::array();
  for (const Candidate& c : search.candidates) {
    Json gaps = Json::array();
    for (const tables::GapSpread& gap : c.gaps)
      gaps.push_back({{"mean_mm", gap.mean_mm}, {"deviation_mm", gap.deviation_mm}});
    candidates.push_back({{"convention", json_of(c.convention)},
                          {"gaps", gaps},
                          {"deviation_mm", json_value(c.deviation_mm)},
                          {"motion_mm", c.motion_mm},
                          {"share", json_value(c.share)}});
  }
  Json undecided = Json::array();
  for (const Term term : search.undecided) undecided.push_back(core::name_of(term));
  return {{"candidates", candidates}, {"equally_good", search.n_best}, {"undecided", undecided}};
}

std::string gap_text(const std::vector<tables::GapSpread>& gaps)
{
  std::vector<std::string> words;
  for (const tables::GapSpread& gap : gaps)
    words.push_back(printed("%.3f (%.2f)", gap.deviation_mm, gap.mean_mm));
  return words.empty() ? "nothing faces" : joined(words);
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
    for (const Term term : tables::all_terms) words.push_back(tables::value_of(c.convention, term));
    const std::string share = formatted("%.4f", c.share);
    std::printf(row, words[0].c_str(), words[1].c_str(), words[2].c_str(), words[3].c_str(), words[4].c_str(),
                words[5].c_str(), words[6].c_str(), share.c_str(), gap_text(c.gaps).c_str());
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
std::string record_of(const ImportOptions& o, const tables::Convention& convention)
{
  std::string text = "\n[import]\nmotion = \"" + std::filesystem::path(o.motion).filename().string() + "\"\n";
  for (const Term term : tables::all_terms)
    text += std::string(core::name_of(term)) + " = \"" + tables::value_of(convention, term) + "\"\n";
  for (const std::string& column : o.follower_columns)
    text += "follower_column = " + core::json_text(Json(column), -1) + "\n";
  return text;
}

void add_input(job::Case& job_case, const std::string& file)
{
  if (file.empty()) return;
  const std::string bytes =
      job::file_bytes(file, {file, "", "", "a table with one pose per frame"}, std::uintmax_t{1} << 28);
  job_case.inputs.push_back({std::filesystem::path(file).filename().string(), job::sha256_of(bytes), true});
}

/// The columns of each follower of the job by coordinate, as the user names them.
std::vector<std::map<std::string, std::string>> follower_columns_of(const ImportOptions& o,
                                                                    const job::Case& of)
{
  std::vector<std::map<std::string, std::string>> columns(of.followers.size());
  for (const auto& [name, column] :
       tables::names_by_coordinate("vrda import", "--follower-column", o.follower_columns)) {
    const std::size_t dot = std::min(name.rfind('.'), name.size());
    const std::string coordinate = name.substr(std::min(dot + 1, name.size()));
    const auto follower = std::ranges::find(of.followers, name.substr(0, dot), &job::Follower::name);
    const bool is_coordinate = std::any_of(follower_coordinate_names.begin(), follower_coordinate_names.end(),
                                           [&](const char* known) { return coordinate == known; });
    if (follower == of.followers.end() || !is_coordinate)
      throw InputError({"vrda import", "--follower-column", name + "=" + column,
                        "FOLLOWER.COORDINATE=COLUMN: a [[follower]] of the job, and flexion, rotation, tilt, "
                        "anterior, proximal or lateral"});
    columns[static_cast<std::size_t>(follower - of.followers.begin())][coordinate] = column;
  }
  return columns;
}

/// Both bodies of the job, and the table under the convention found.
struct Found {
  ConventionSearch search;
  tables::MotionSequence motion;
};

Found found_motion(const ImportOptions& o, const job::Case& subject, const tables::ImportFrame& frame)
{
  const tables::MotionTable table = tables::read_motion_table(o.motion, columns_of(o));
  tables::SearchRequest request = request_of(o);
  if (!frame.has_file_axes) {
    if (request.stated.axes == tables::TableAxes::files)
      throw InputError({"vrda import", "--axes", "files with a job that has [scaling]", "canonical"});
    request.stated.axes = tables::TableAxes::canonical;
  }
  const solve::Joint joint = solve::joint_of(subject, subject.frame);
  const tables::SearchScene scene{subject.frame, joint, bounding_box(subject.moving.contact.mesh)};
  Found found;
  found.search =
      tables::find_convention(table, request, frame.joint, scene, run::thread_count_or_all(o.n_threads));
  const tables::Convention& convention = found.search.candidates.front().convention;
  const bool is_searched = request.automatic.count(Term::angles) > 0 || !table.stated.angles;
  const tables::UnitSource source = request.stated.angles ? tables::UnitSource::option
                                    : is_searched         ? tables::UnitSource::found
                                                          : tables::UnitSource::file;
  found.motion = {
      table.key_name, table.key, tables::poses_of(table, convention, frame.joint), {}, table.warnings};
  for (const std::string& line : tables::unit_warnings(table, convention.angles, source, frame.joint))
    found.motion.warnings.push_back(line);
  const auto columns = follower_columns_of(o, subject);
  for (std::size_t k = 0; k < subject.followers.size(); ++k)
    found.motion.followers.push_back(tables::read_follower(o.motion, subject.followers[k].name, columns[k]));
  return found;
}

/// Of the imported poses, as measured by an audit; empty without overlap.
std::string overlap_text(const store::MotionModel& model, int n_threads)
{
  const analysis::AuditFigures figures = analysis::figures_of(analysis::audit(model, "raw", 1, n_threads));
  if (figures.n_overlapping == 0) return "";
  return printed(
      "the bones overlap in %d of %d frames, by at most %.1f mm at %s %.4g; vrda repair finds the nearest "
      "motion without overlap",
      figures.n_overlapping, figures.n_poses, figures.largest_penetration.value_mm,
      model.frames->key_name.c_str(), figures.largest_penetration.key);
}

// Prints the conventions tried with the gaps that they leave, and the path of the model. Throws InputError
// with the options to add where conventions cannot be distinguished; nothing is then written.
core::ExitCode import_command(const ImportOptions& o)
{
  run::require_plain_text("--motion", o.motion);
  run::require_plain_text("--reference-motion", o.reference_motion);
  const job::Case job_case = job::with_one_delta(run::load_and_report_case(o.job_file, o), o.job_file);
  const job::Case subject = job::scaled_to_subject(job_case);
  const tables::ImportFrame frame = tables::import_frame(job::read_job(o.job_file, o.overrides), job_case);
  const Found found = found_motion(o, subject, frame);
  if (!o.as_json) print(found.search);
  if (o.as_json && found.search.n_best != 1) print_json(json_of(found.search));
  for (const std::string& line : found.motion.warnings) core::log_warning(line);
  require_decided(found.search, o.motion);

  const tables::Convention& convention = found.search.candidates.front().convention;
  job::Case import_case = tables::import_case(job_case, found.motion, record_of(o, convention));
  for (const std::string& file : {o.motion, o.reference_motion}) add_input(import_case, file);
  const std::string output = run::output_path_of(o.output, o.job_file);
  run::make_parent_folder(output);
  const std::optional<OutputLock> lock = run::lock_output(output, "vrda import");
  if (!lock) return core::ExitCode::interrupted;
  run::existing_result(import_case, output, o.may_replace);  // throws for another result
  const int n_threads = run::thread_count_or_all(o.n_threads);
  const store::MotionModel model = tables::imported_model(import_case, found.motion, n_threads);
  store::write_motion_model(output, model);
  core::log_info(std::to_string(found.motion.key.size()) + " frames over " + found.motion.key_name + ": " +
                 options_text(convention, {std::begin(tables::all_terms), std::end(tables::all_terms)}));
  const std::string gimbal_lock = gimbal_lock_text(store::clinical_curves(model).n_locked);
  if (!gimbal_lock.empty()) core::log_warning(output + ": " + gimbal_lock);
  const std::string overlap = overlap_text(model, n_threads);
  if (!overlap.empty()) core::log_warning(output + ": " + overlap);
  if (o.as_json) {
    Json json = json_of(found.search);
    json["convention"] = json_of(convention);
    json["frames"] = found.motion.key.size();
    json["key_name"] = found.motion.key_name;
    json["output"] = output;
    print_json(json);
  } else {
    std::printf("%s\n", output.c_str());
  }
  return core::ExitCode::done;
}

}  // namespace

void declare_import(Command& c)
{
  auto& o = c.options<ImportOptions>();
  const auto add_term = [&](const char* name, std::string& word, std::vector<std::string> words,
                            const char* what) {
    words.emplace_back("auto");
    c.option(name, word, what).one_of(words);
  };
  const auto add_repeated = [&](const char* name, std::vector<std::string>& texts, const char* what) {
    c.option(name, texts, what).repeatable();
  };
  c.job(o.job_file, "Job file (TOML): meshes, frames, side, Delta; its grid is not used");
  c.option("--motion", o.motion, "Table with one pose per frame: .csv, .sto, .mot or .tra").required();
  c.option("-o,--output", o.output, "Motion model; default: results/NAME/NAME.h5, named by job and folder");
  c.loading(o);
  add_term("--unit", o.unit, {"mm", "cm", "m"}, "Unit of lengths");
  add_term("--angles", o.angles, {"deg", "rad"}, "Unit of angles");
  add_term("--order", o.order, {"xyz", "xzy", "yxz", "yzx", "zxy", "zyx"},
           "Order of the rotations about the body's own axes: zxy is R = Rz Rx Ry");
  add_term("--direction", o.direction, {"moving-in-reference", "reference-in-moving"}, "Whose pose it is");
  add_term("--axes", o.axes, {"canonical", "files"},
           "Axes and origins: those of the motion model, or of the mesh files before the frames of the job");
  add_term("--side", o.side, {"right", "left"}, "Side for which the signs of the table hold");
  add_term("--lengths", o.lengths, {"origin", "centre", "grood-suntay"},
           "Lengths of the moving origin, of the rotation centre, or along the Grood-Suntay axes");
  c.option("--key", o.key, "Column of the frames' keys; default: time, frame, gait_percent, ...");
  add_repeated("--column", o.columns,
               "COORDINATE=COLUMN: column of flexion, varus, internal, rx, ry, rz, tx, ty, tz, ...; "
               "COORDINATE=-COLUMN: with the opposite sign; may be repeated");
  add_repeated(
      "--follower-column", o.follower_columns,
      "FOLLOWER.COORDINATE=COLUMN: column of flexion, rotation, tilt (degrees), anterior, proximal or "
      "lateral (mm) of a [[follower]]; default: follower_NAME_flexion_deg, ...; may be repeated");
  c.option("--moving-prefix", o.moving_prefix, "Before T11 to T34 of the moving object: tibia_");
  c.option("--reference-prefix", o.reference_prefix,
           "The same of the reference, where both are posed in a common frame");
  c.option("--reference-motion", o.reference_motion,
           "File with the poses of the reference in a common frame");
  c.flag("--replace", o.may_replace, "Replace another result");
  c.threads(o.n_threads);
  c.json(o.as_json);
  c.runs([&o] { return import_command(o); });
}

}  // namespace vrda::app
