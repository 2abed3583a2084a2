// `vrda score`: a motion compared with a measured one.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>

#include "analysis/score.hpp"
#include "app/commands.hpp"
#include "app/option_values.hpp"
#include "app/printing.hpp"
#include "core/document.hpp"
#include "core/fields_json.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "model/coordinates.hpp"
#include "run/run_output.hpp"
#include "store/motion.hpp"
#include "tables/imported_model.hpp"

namespace vrda::app {
namespace {

using Json = nlohmann::ordered_json;

struct ScoreCommandOptions {
  std::string model;    ///< motion model, or a table of a motion
  std::string against;  ///< the same
  std::string set = "raw";
  std::string follower;  ///< a body that follows the joint; empty: the joint itself
  std::string match;     ///< key or flexion; empty: flexion for a grid, else key
  std::string align = "none";
  std::string rows, fit_rows;  ///< A:B, first-half or second-half; empty: all, and those scored
  std::string line;            ///< flexion or key; empty: what the rows are matched by
  std::string translations = "rotation-centre";
  std::string long_axis;             ///< push, or X,Y,Z; empty: the joint's own axes
  std::string side;                  ///< of two tables; empty: right
  std::string angles;                ///< of the tables: deg or rad; empty: as they state, else degrees
  std::vector<std::string> columns;  ///< COORDINATE=COLUMN of the tables
  std::vector<double> centre_mm;     ///< three numbers, canonical; empty: that of the model, else the origin
  bool bridges = false;
  bool as_json = false;
};

/// One of the two motions: a model, or a table.
struct Source {
  std::string file;
  std::optional<store::MotionModel> model;
  tables::MotionSequence table = {};
};

[[noreturn]] void refuse_score(const std::string& option, const std::string& found, const std::string& wanted)
{
  throw InputError({"vrda score", option, found, wanted});
}

Source source_of(const std::string& file)
{
  if (!file.ends_with(".h5")) return {file, {}, {}};
  return {file, run::read_solved_model(file), {}};
}

/// Three numbers with commas between them, a unit vector.
Eigen::Vector3d direction_of(const std::string& text)
{
  Eigen::Vector3d v = Eigen::Vector3d::Constant(nan);
  std::size_t from = 0;
  for (Eigen::Index k = 0; k < 3; ++k) {
    const std::size_t end = k < 2 ? text.find(',', from) : text.size();
    if (end == std::string::npos) break;
    const auto [rest, error] = std::from_chars(text.data() + from, text.data() + end, v[k]);
    if (error != std::errc() || rest != text.data() + end) v[k] = nan;
    from = end + 1;
  }
  if (!v.allFinite() || !(v.norm() > 1e-6)) refuse_score("--long-axis", "\"" + text + "\"", "push, or X,Y,Z");
  return v.normalized();
}

std::optional<Eigen::Vector3d> long_axis_of(const Source& found, const std::string& text)
{
  if (text.empty()) return {};
  if (text != "push") return direction_of(text);
  if (!found.model) refuse_score("--long-axis", "push with the table " + found.file, "X,Y,Z");
  const Points& delta = found.model->push.delta;
  if ((delta.rowwise() - delta.row(0)).cwiseAbs().maxCoeff() > 0.0)
    throw InputError({found.file, "--long-axis", "push with a Delta that depends on flexion", "X,Y,Z"});
  return found.model->delta;
}

analysis::Convention convention_of(const Source& found, const Source& against,
                                   const ScoreCommandOptions& options)
{
  if (found.model && against.model && found.model->side != against.model->side)
    throw InputError({against.file, "side", against.model->side, found.model->side + ", as " + found.file});
  const Source& known = found.model ? found : against;
  analysis::Convention convention;
  if (known.model) {
    if (!options.side.empty())
      refuse_score("--side", options.side, "no value: the side is that of " + known.file);
    convention.side = side_named(known.model->side);
    convention.rotation_centre_mm = known.model->rotation_centre_mm;
  } else if (options.side == "left") {
    convention.side = Side::left;
  }
  if (!options.centre_mm.empty())
    convention.rotation_centre_mm = Eigen::Map<const Eigen::Vector3d>(options.centre_mm.data());
  convention.long_axis = long_axis_of(found, options.long_axis);
  if (options.translations == "mesh-origin") convention.translations = analysis::Translations::mesh_origin;
  return convention;
}

void require_set(const Source& found, const std::string& set)
{
  if (!found.model) {
    if (set != "raw") refuse_score("--set", set, "no value: " + found.file + " is a table");
    return;
  }
  const std::vector<std::string> names = store::all_set_names(*found.model);
  if (std::find(names.begin(), names.end(), set) != names.end()) return;
  throw InputError(
      {found.file, "--set", "\"" + set + "\"", "a set of this file: " + join_alternatives(names)});
}

analysis::Sequence sequence_of(const Source& source, const std::string& set,
                               const analysis::Convention& convention)
{
  if (source.model) return analysis::sequence_of(source.file, *source.model, set, convention);
  const tables::MotionSequence& table = source.table;
  return analysis::sequence_of(source.file, table.key_name, table.key, table.X_reference_moving, convention);
}

/// Of two tables each --column must be in one.
void read_tables(Source& found, Source& against, const ScoreCommandOptions& options,
                 const analysis::Convention& convention)
{
  tables::MotionConvention of_table;
  of_table.joint.side = convention.side;
  of_table.joint.rotation_centre_mm = convention.rotation_centre_mm;
  const Source& known = found.model ? found : against;
  if (known.model) of_table.joint.has_large_flexion = joint_kind(known.model->joint).has_large_flexion;
  of_table.stated.angles = core::value_named<tables::AngleUnit>(options.angles);
  of_table.columns.of_coordinate = tables::names_by_coordinate("vrda score", "--column", options.columns);
  of_table.columns.may_be_absent = !found.model && !against.model;
  for (Source* source : {&found, &against}) {
    if (source->model) continue;
    source->table = tables::read_motion(source->file, of_table);
    for (const std::string& line : source->table.warnings) core::log_warning(line);
  }
  const std::vector<std::string>& absent = against.table.absent_columns;
  for (const std::string& column : found.table.absent_columns) {
    if (std::find(absent.begin(), absent.end(), column) != absent.end())
      throw InputError({against.file, "--column", "no column " + column, "it, here or in " + found.file});
  }
}

std::string match_of(const Source& found, const ScoreCommandOptions& options)
{
  const bool is_grid = found.model && !found.model->frames;
  if (options.match.empty()) return is_grid ? "flexion" : "key";
  if (is_grid && options.match == "key")
    throw InputError({found.file, "--match", "key", "flexion: a grid has no frames"});
  return options.match;
}

std::vector<analysis::Row> matched_rows(const Source& found, const analysis::Sequence& measured,
                                        const std::string& match, const ScoreCommandOptions& options,
                                        const analysis::Convention& convention)
{
  const bool is_given_varus = found.model && !analysis::is_sequence(*found.model, options.set);
  if (is_given_varus) {
    if (options.bridges)
      throw InputError({found.file, "--bridge", "a grid with given varus", "a motion over flexion"});
    return analysis::rows_at_attitudes(*found.model, options.set, measured, convention);
  }
  const analysis::Sequence rows = sequence_of(found, options.set, convention);
  if (match == "flexion") return analysis::rows_over_flexion(rows, measured, options.bridges);
  if (options.bridges) refuse_score("--bridge", "--match key", "--match flexion");
  if (rows.key_name != measured.key_name)
    throw InputError({found.file, "key", rows.key_name,
                      measured.key_name + ", as " + measured.file + "; or --match flexion"});
  return analysis::rows_by_key(rows, measured);
}

// The rows of a follower at the measured frames, or at the measured flexions of the joint.
std::vector<analysis::Row> follower_rows(const Source& found, const analysis::Sequence& measured,
                                         const ScoreCommandOptions& options)
{
  if (!found.model->frames) {
    if (measured.key_name != "flexion_deg")
      throw InputError({measured.file, "key", measured.key_name,
                        "flexion_deg, of the joint, at which the follower of a grid is compared"});
    return analysis::follower_sequence(found.file, *found.model, options.set, options.follower, measured.key)
        .rows;
  }
  const analysis::Sequence rows =
      analysis::follower_sequence(found.file, *found.model, options.set, options.follower);
  if (rows.key_name != measured.key_name)
    throw InputError({found.file, "key", rows.key_name, measured.key_name + ", as " + measured.file});
  return analysis::rows_by_key(rows, measured);
}

void require_follower_options(const Source& found, const ScoreCommandOptions& options)
{
  if (!found.model) refuse_score("--follower", "the table " + found.file, "a motion model first");
  if (options.align == "rigid") refuse_score("--align", "rigid with --follower", "none or constant");
  if (options.translations != "rotation-centre" || !options.long_axis.empty() || !options.centre_mm.empty() ||
      !options.match.empty() || options.bridges)
    refuse_score("--follower", "--translations, --centre, --long-axis, --match or --bridge",
                 "its own coordinates (schemas/followers.md), matched by the key");
}

analysis::ScoreOptions score_options(const ScoreCommandOptions& options,
                                     const analysis::Convention& convention, const std::string& match,
                                     std::size_t n)
{
  analysis::ScoreOptions with;
  with.convention = convention;
  if (options.align == "constant") with.align = analysis::Alignment::constant;
  if (options.align == "rigid") with.align = analysis::Alignment::rigid;
  const std::string over = options.line.empty() ? match : options.line;
  with.line_over = over == "flexion" ? analysis::LineOver::flexion : analysis::LineOver::key;
  with.scored = rows_of({"vrda score", "--rows"}, options.rows, n);
  if (!options.fit_rows.empty()) with.fit = rows_of({"vrda score", "--fit-rows"}, options.fit_rows, n);
  return with;
}

/// Everything that is printed.
struct Outcome {
  const ScoreCommandOptions& options;
  analysis::Convention convention;
  std::string match, line;
  analysis::Sequence measured;
  analysis::Score score;
};

const char* name_of(const Outcome& o, std::size_t c)
{
  return o.options.follower.empty() ? joint_coordinate_names[c] : follower_coordinate_names[c];
}

/// "3-5, 12", counted from 1.
std::string row_list(const std::vector<std::size_t>& rows)
{
  std::vector<std::string> runs;
  for (std::size_t k = 0; k < rows.size();) {
    std::size_t end = k;
    while (end + 1 < rows.size() && rows[end + 1] == rows[end] + 1) ++end;
    runs.push_back(std::to_string(rows[k] + 1) + (end > k ? "-" + std::to_string(rows[end] + 1) : ""));
    k = end + 1;
  }
  return joined(runs);
}

std::vector<std::size_t> from_one(std::vector<std::size_t> rows)
{
  for (std::size_t& row : rows) ++row;
  return rows;
}

/// A transform as rotation about an axis through the rotation centre and a shift of that point.
struct ShownTransform {
  double rotation_deg = 0.0;
  Eigen::Vector3d axis = Eigen::Vector3d::Zero();
  Eigen::Vector3d shift_mm = Eigen::Vector3d::Zero();
};

ShownTransform shown_transform(const Pose& X, const Eigen::Vector3d& centre_mm)
{
  ShownTransform shown;
  shown.shift_mm = X * centre_mm - centre_mm;
  const std::optional<HelicalAxis> axis = helical_axis(Pose::Identity(), X, centre_mm);
  if (!axis) return shown;
  shown.rotation_deg = deg_from_rad(axis->rotation_rad);
  shown.axis = axis->direction;
  return shown;
}

Json json_of(const Pose& X, const Eigen::Vector3d& centre_mm)
{
  const ShownTransform shown = shown_transform(X, centre_mm);
  Json matrix = Json::array();
  for (Eigen::Index row = 0; row < 4; ++row)
    matrix.push_back({X.matrix()(row, 0), X.matrix()(row, 1), X.matrix()(row, 2), X.matrix()(row, 3)});
  return {{"rotation_deg", shown.rotation_deg},
          {"axis", json_value(shown.axis)},
          {"shift_of_rotation_centre_mm", json_value(shown.shift_mm)},
          {"matrix_mm", matrix}};
}

Json json_of(const analysis::CoordinateScore& s, std::size_t c, const analysis::Sequence& measured)
{
  const analysis::Statistics& of = s.statistics;
  Json json = {
      {"unit", unit_name(c)},
      {"frames", of.n},
      {"rms", in_file(of.rms, c)},
      {"bias", in_file(of.bias, c)},
      {"shape", in_file(of.shape, c)},
      {"correlation", of.correlation},
      {"largest", in_file(of.largest, c)},
      {"largest_row", Json()},
      {"largest_key", Json()},
      {"offset", in_file(s.offset, c)},
      {"baselines", {{"constant_rms", in_file(s.constant_rms, c)}, {"line_rms", in_file(s.line_rms, c)}}},
      {"undetermined_rows", from_one(s.undetermined)}};
  if (of.n == 0) return json;
  json["largest_row"] = s.largest_row + 1;
  json["largest_key"] = measured.key[s.largest_row];
  return json;
}

Json json_of(const Outcome& o)
{
  Json align = {{"kind", o.options.align}, {"fit_frames", o.score.n_fit_rows}};
  if (o.score.rigid) {
    const analysis::RigidAlignment& rigid = *o.score.rigid;
    align["status"] = rigid.is_converged ? "converged" : "iteration_limit";
    align["rms_mm"] = rigid.rms_mm;
    align["determined_directions"] = rigid.n_determined;
    align["reference"] = json_of(rigid.X_reference, o.convention.rotation_centre_mm);
    align["moving"] = json_of(rigid.X_moving, o.convention.rotation_centre_mm);
  }
  Json missing = Json::object(), coordinates = Json::object();
  for (const auto& [reason, rows] : o.score.missing) missing[reason] = from_one(rows);
  for (std::size_t c = 0; c < analysis::n_scored; ++c)
    coordinates[name_of(o, c)] = json_of(o.score.coordinates[c], c, o.measured);
  return {{"file", o.options.model},
          {"set", o.options.set},
          {"follower", o.options.follower.empty() ? Json() : Json(o.options.follower)},
          {"against", o.options.against},
          {"side", o.convention.side == Side::left ? "left" : "right"},
          {"rotation_centre_mm", json_value(o.convention.rotation_centre_mm)},
          {"translations", o.options.translations},
          {"long_axis", json_value(o.convention.long_axis)},
          {"match", o.match},
          {"key", o.measured.key_name},
          {"line_over", o.line},
          {"bridged", o.options.bridges},
          {"frames", {{"measured", o.measured.rows.size()}, {"scored", o.score.n_scored_rows}}},
          {"not_scored_rows", missing},
          {"align", align},
          {"coordinates", coordinates}};
}

std::string three_decimals(double value)
{
  return formatted("%.3f", value);
}

void print_transform(const char* body, const Pose& X, const Eigen::Vector3d& centre_mm)
{
  const ShownTransform s = shown_transform(X, centre_mm);
  std::printf(
      "  %s: %.3f degrees about (%.3f, %.3f, %.3f), rotation centre shifted by (%.3f, %.3f, %.3f) mm\n", body,
      s.rotation_deg, s.axis.x(), s.axis.y(), s.axis.z(), s.shift_mm.x(), s.shift_mm.y(), s.shift_mm.z());
}

void print_alignment(const Outcome& o)
{
  std::printf("aligned: %s", o.options.align.c_str());
  if (!o.options.fit_rows.empty()) std::printf(", fitted to %zu frames", o.score.n_fit_rows);
  std::printf("\n");
  if (!o.score.rigid) return;
  const analysis::RigidAlignment& rigid = *o.score.rigid;
  print_transform("reference", rigid.X_reference, o.convention.rotation_centre_mm);
  print_transform("moving", rigid.X_moving, o.convention.rotation_centre_mm);
  std::printf("  %.3f mm left, %d of 12 directions determined\n", rigid.rms_mm, rigid.n_determined);
}

void print_table(const Outcome& o)
{
  std::printf("  %-18s %6s %8s %8s %8s %8s %8s %8s %11s %9s %9s\n", "", "frames", "RMS", "bias", "shape",
              "offset", "largest", "in row", "correlation", "constant", "line");
  for (std::size_t c = 0; c < analysis::n_scored; ++c) {
    const analysis::CoordinateScore& s = o.score.coordinates[c];
    const analysis::Statistics& of = s.statistics;
    const auto cell = [&](double value) { return three_decimals(in_file(value, c)); };
    const std::string name = std::string(name_of(o, c)) + ", " + unit_name(c);
    const std::string row = of.n == 0 ? "-" : std::to_string(s.largest_row + 1);
    std::printf("  %-18s %6zu %8s %8s %8s %8s %8s %8s %11s %9s %9s\n", name.c_str(), of.n,
                cell(of.rms).c_str(), cell(of.bias).c_str(), cell(of.shape).c_str(), cell(s.offset).c_str(),
                cell(of.largest).c_str(), row.c_str(), three_decimals(of.correlation).c_str(),
                cell(s.constant_rms).c_str(), cell(s.line_rms).c_str());
  }
}

void print(const Outcome& o)
{
  std::printf("%s (%s%s) against %s\n", o.options.model.c_str(), o.options.set.c_str(),
              o.options.follower.empty() ? "" : (", " + o.options.follower).c_str(),
              o.options.against.c_str());
  std::printf("%zu of %zu frames scored, matched by %s; line over %s\n", o.score.n_scored_rows,
              o.measured.rows.size(), o.match == "key" ? o.measured.key_name.c_str() : "flexion",
              o.line == "key" ? o.measured.key_name.c_str() : "flexion");
  for (const auto& [reason, rows] : o.score.missing)
    std::printf("not scored: %zu %s, rows %s\n", rows.size(), reason.c_str(), row_list(rows).c_str());
  print_alignment(o);
  print_table(o);
  for (std::size_t c = 0; c < analysis::n_scored; ++c) {
    const std::vector<std::size_t>& rows = o.score.coordinates[c].undetermined;
    if (rows.empty()) continue;
    std::printf("%s: %zu undetermined, rows %s\n", name_of(o, c), rows.size(), row_list(rows).c_str());
  }
}

// Prints a table or JSON. Throws InputError for files that are refused, for options that do not fit them,
// and if no frame can be scored.
core::ExitCode score_command(const ScoreCommandOptions& options)
{
  Source found = source_of(options.model), against = source_of(options.against);
  require_set(found, options.set);
  const bool is_follower = !options.follower.empty();
  if (is_follower) require_follower_options(found, options);
  const analysis::Convention convention = convention_of(found, against, options);
  read_tables(found, against, options, convention);
  const analysis::Sequence measured =
      is_follower && against.model
          ? analysis::follower_sequence(against.file, *against.model, "raw", options.follower)
          : sequence_of(against, "raw", convention);
  const std::string match = is_follower ? "key" : match_of(found, options);
  const std::vector<analysis::Row> rows = is_follower
                                              ? follower_rows(found, measured, options)
                                              : matched_rows(found, measured, match, options, convention);
  const analysis::ScoreOptions with = score_options(options, convention, match, measured.rows.size());
  const Outcome outcome{options,  convention,
                        match,    options.line.empty() ? match : options.line,
                        measured, analysis::score(rows, measured, with)};
  if (outcome.score.rigid && !outcome.score.rigid->is_converged)
    core::log_warning("the rigid alignment did not converge within its iteration limit");
  if (options.as_json) return print_json(json_of(outcome));
  print(outcome);
  return core::ExitCode::done;
}

}  // namespace

void declare_score(Command& c)
{
  auto& o = c.options<ScoreCommandOptions>();
  c.option("model", o.model, "Motion model (HDF5), or a table of a motion").required();
  c.option("--against", o.against, "Measured motion: a table, or a motion model (HDF5)").required();
  c.option("--set", o.set, "Motion of a model: raw, two_sided, degree_N, ...").shows_default();
  c.option("--follower", o.follower,
           "Score a body that follows the joint: its flexion, rotation, tilt and displacement "
           "(schemas/followers.md), which --column names as flexion, varus, internal, anterior, proximal, "
           "lateral");
  c.option("--match", o.match, "Match frames by flexion or by key; default: flexion for a grid, else key")
      .one_of({"flexion", "key"});
  c.option("--align", o.align,
           "Fitted before scoring: none, constant (an offset of each coordinate) or rigid (a transform "
           "of each body's frame)")
      .one_of({"none", "constant", "rigid"})
      .shows_default();
  c.option("--rows", o.rows,
           "Rows of the measurement to score: A:B (from 1, both included), first-half or "
           "second-half; default: all");
  c.option("--fit-rows", o.fit_rows,
           "Rows that fit the alignment and the baselines, like --rows; default: those scored");
  c.option("--line", o.line,
           "The straight line of the baseline is over flexion or key; default: as the frames match")
      .one_of({"flexion", "key"});
  c.option("--translations", o.translations,
           "rotation-centre (Grood-Suntay axes) or mesh-origin (of the moving meshes, along the "
           "reference's axes)")
      .one_of({"rotation-centre", "mesh-origin"})
      .shows_default();
  c.option("--centre", o.centre_mm, "X,Y,Z: rotation centre, canonical mm; default: the model's")
      .separated_by_commas()
      .takes(3)
      .any_number();
  c.option("--long-axis", o.long_axis,
           "push (the model's Delta) or X,Y,Z: coordinates about axes turned so that this direction "
           "is the long axis; default: the joint's own axes");
  c.option("--side", o.side, "Side of two tables: right (default) or left; a model states its side")
      .one_of({"right", "left"});
  c.option("--angles", o.angles, "Unit of the angles of a table: deg or rad; default: as it states, else deg")
      .one_of({"deg", "rad"});
  c.option("--column", o.columns,
           "COORDINATE=COLUMN of a table, as of vrda import: flexion=-knee_angle_r has the opposite "
           "sign; may be repeated")
      .repeatable();
  c.flag("--bridge", o.bridges,
         "Score frames across unsolved flexions too, on the line between the "
         "nearest solved ones");
  c.json(o.as_json);
  c.runs([&o] { return score_command(o); });
}

}  // namespace vrda::app
