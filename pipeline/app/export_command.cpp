// `vrda export`: a motion over flexion as CSV, VTK series, animated glTF, OpenSim table or OpenSim joint.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "analysis/flexion_curves.hpp"
#include "app/commands.hpp"
#include "app/option_values.hpp"
#include "app/printing.hpp"
#include "core/document.hpp"
#include "core/text.hpp"
#include "job/thesis_files.hpp"
#include "run/run_output.hpp"
#include "store/motion_model.hpp"
#include "tables/formats.hpp"
#include "tables/motion_table.hpp"
#include "tables/osim_model.hpp"
#include "tables/scan_files.hpp"

namespace vrda::app {
namespace {

namespace fs = std::filesystem;

struct Format {
  const char* name;
  const char* extension;
};
constexpr const char* driven_varus = "driven";
constexpr std::array<Format, 8> formats{{{"sto", ".sto"},
                                         {"mot", ".mot"},
                                         {"osim", ".osim"},
                                         {"csv", ".csv"},
                                         {"gltf", ".glb"},
                                         {"vtk", ".pvd"},
                                         {"stl", ".stl"},
                                         {"mrk", ".json"}}};

bool is_opensim(const ExportOptions& options)
{
  return options.format == "sto" || options.format == "mot";
}

/// One pose in the frame of the scan.
bool is_in_scan(const ExportOptions& options)
{
  return options.format == "stl" || options.format == "mrk";
}

void refuse(const std::string& option, const std::string& found, const std::string& wanted)
{
  throw InputError({"vrda export", option, found, wanted});
}

void require_useful(const ExportOptions& options)
{
  const bool is_osim = options.format == "osim";
  if (!is_opensim(options) && options.in_degrees)
    refuse("--degrees", "--to " + options.format, "--to sto or --to mot");
  if (!is_opensim(options) && options.translations != ExportOptions().translations)
    refuse("--translations", "--to " + options.format, "--to sto or --to mot");
  if (!is_opensim(options) && !is_osim && !options.coordinates.empty())
    refuse("--coordinate", "--to " + options.format, "--to sto, --to mot or --to osim");
  if (options.varus == driven_varus && !is_osim)
    refuse("--varus", "driven with --to " + options.format, "--to osim");
  if (options.varus == driven_varus && !options.flexion.empty())
    refuse("--flexion", options.flexion + " with --varus driven",
           "no value: the joint has the range of the model");
  if (is_in_scan(options) == options.pose.empty())
    refuse("--pose", options.pose.empty() ? "nothing" : "--to " + options.format,
           "flexion=DEGREES, with --to stl and --to mrk");
  if (is_in_scan(options) && !options.flexion.empty())
    refuse("--flexion", "--to " + options.format, "--pose");
  if (!is_osim && options.only_joint) refuse("--joint-only", "--to " + options.format, "--to osim");
  if (!options.every_cell) return;
  if (options.format != "csv") refuse("--full", "--to " + options.format, "--to csv");
  if (options.set.empty() && options.flexion.empty() && options.varus.empty()) return;
  refuse("--full", "--set, --flexion or --varus", "none of these: every cell is written");
}

/// The extension check prevents overwriting a model, a job or a mesh.
void require_output(const ExportOptions& options)
{
  const auto format =
      std::find_if(formats.begin(), formats.end(), [&](const Format& f) { return options.format == f.name; });
  if (format == formats.end()) refuse("--to", options.format, "sto, mot, osim, csv, gltf, vtk, stl or mrk");
  const fs::path output = options.output;
  if (output.extension() != format->extension) {
    refuse("--output", options.output, std::string("a name that ends in ") + format->extension);
  }
  std::error_code error;
  const bool is_there = fs::exists(output, error);
  if (is_there && !fs::is_regular_file(output, error)) {
    throw InputError({options.output, "output", "not a regular file", "a new name, or a file to replace"});
  }
  if (is_there && fs::equivalent(output, options.file, error)) {
    throw InputError({options.output, "output", "the input motion model", "another name"});
  }
}

/// The smoothed set of the highest degree, without recontact, whose travel has kinks.
std::string smoothed_set(const store::MotionModel& model, const std::string& file)
{
  if (model.smoothed.empty())
    throw InputError({file, "--varus", "driven without a smoothed set", "one, by vrda smooth"});
  return "degree_" + std::to_string(model.smoothed.back().degree);
}

tables::FlexionPlan plan_of(const ExportOptions& options, const store::MotionModel& model)
{
  tables::FlexionPlan plan;
  plan.set = options.set;
  if (is_in_scan(options)) {
    constexpr std::string_view key = "flexion=";
    const std::optional<double> flexion_deg =
        options.pose.starts_with(key) ? finite_number(options.pose.substr(key.size())) : std::nullopt;
    if (!flexion_deg) refuse("--pose", options.pose, "flexion=DEGREES");
    plan.flexion_deg = {*flexion_deg};
    if (plan.set.empty()) plan.set = "raw";  // which has contacts
  }
  if (!options.flexion.empty()) plan.flexion_deg = angle_range({"vrda export", "--flexion"}, options.flexion);
  if (options.format == "osim" && options.flexion.empty() && !model.frames)
    plan.flexion_deg = tables::osim_flexions_deg(model, options.set);
  plan.varus = tables::default_varus(model, plan.set);
  if (options.varus == driven_varus) {
    if (plan.set.empty()) plan.set = smoothed_set(model, options.file);
    plan.flexion_deg.clear();
    plan.varus = tables::VarusRule::spine;
    return plan;
  }
  if (options.varus == core::name_of(tables::VarusRule::spine)) plan.varus = tables::VarusRule::spine;
  if (options.varus == core::name_of(tables::VarusRule::zero)) plan.varus = tables::VarusRule::zero;
  if (options.varus.empty() || options.varus == core::name_of(plan.varus)) return plan;
  const std::optional<double> varus_deg = finite_number(options.varus);
  if (!varus_deg) refuse("--varus", options.varus, "degrees, spine or zero");
  plan.varus = tables::VarusRule::given;
  plan.varus_deg = *varus_deg;
  return plan;
}

/// Not "--knee" nor a typographic minus before the name, which would be a sign lost in it.
bool is_column_name(const std::string& name)
{
  for (const char* sign : {"-", "+", "\u2212", "\u2010", "\u2013", "\u2014"})
    if (name.starts_with(sign)) return false;
  return !name.empty() && name != "time" && std::none_of(name.begin(), name.end(), [](char c) {
    return static_cast<unsigned char>(c) <= 0x20 || c == 0x7f || c == ',' || c == ';';
  });
}

/// The names of [opensim] in the job that the command does not give, then those of the command.
std::vector<std::string> named_coordinates(const ExportOptions& options, const store::MotionModel& model)
{
  std::vector<std::string> names;
  if (model.job.resolved.empty()) return options.coordinates;
  const core::DocumentValue job = core::parse_toml(model.job.resolved, options.file);
  const core::DocumentValue of_job = job.value("opensim", core::DocumentValue::object());
  for (const auto& [coordinate, name] : of_job.items()) {
    const bool is_used = options.format != "osim" || coordinate == "flexion" ||
                         (coordinate == "varus" && options.varus == driven_varus);
    const auto is_given = [start = coordinate + "="](const std::string& one) {
      return one.starts_with(start);
    };
    if (is_used && std::none_of(options.coordinates.begin(), options.coordinates.end(), is_given))
      names.push_back(coordinate + "=" + name.get<std::string>());
  }
  names.insert(names.end(), options.coordinates.begin(), options.coordinates.end());
  return names;
}

tables::OpenSimOptions opensim_options(const ExportOptions& options, const store::MotionModel& model,
                                       Side side)
{
  const std::string& joint = model.joint;
  tables::OpenSimOptions opensim{tables::opensim_columns(joint, side), options.in_degrees,
                                 options.degrees_per_second, options.translations == "mesh-origin"};
  const bool has_two = options.varus == driven_varus;
  for (const auto& [coordinate, column] :
       tables::names_by_coordinate("vrda export", "--coordinate", named_coordinates(options, model))) {
    const auto* found =
        std::find(tables::opensim_coordinates.begin(), tables::opensim_coordinates.end(), coordinate);
    const bool has_sign = column[0] == '-' || column[0] == '+';
    const std::string name = has_sign ? column.substr(1) : column;
    if (found == tables::opensim_coordinates.end() || !is_column_name(name)) {
      refuse("--coordinate", coordinate + "=" + column,
             "COORDINATE=NAME, one of flexion, varus, internal, tx, ty, tz; -NAME negates it");
    }
    if (options.format == "osim" && coordinate != "flexion" && !(has_two && coordinate == "varus"))
      refuse("--coordinate", coordinate + " with --to osim", "flexion, and varus with --varus driven");
    const auto k = static_cast<std::size_t>(found - tables::opensim_coordinates.begin());
    opensim.columns[k] = name;
    if (column[0] == '-') opensim.sign[k] = -1.0;
  }
  for (std::size_t k = 0; k < opensim.columns.size(); ++k) {
    const auto rest = opensim.columns.begin() + static_cast<std::ptrdiff_t>(k) + 1;
    if (std::find(rest, opensim.columns.end(), opensim.columns[k]) == opensim.columns.end()) continue;
    refuse("--coordinate", "two columns " + opensim.columns[k], "unique column names");
  }
  return opensim;
}

/// For example "knee/knee_0007.vtp", relative to knee.pvd.
std::string piece_name(const fs::path& output, const char* kind, std::size_t frame)
{
  const std::string stem = output.stem().string();
  return stem + "/" + stem + kind + printed("_%04zu.vtp", frame);
}

/// Empty when interrupted.
std::optional<Publication> begin_export(const std::string& output)
{
  run::make_parent_folder(output);
  return run::begin_result(output, "vrda export");
}

std::vector<std::string> write_single(const std::string& output, const std::string& bytes)
{
  std::optional<Publication> result = begin_export(output);
  if (!result) return {};
  result->publish(bytes);
  return {output};
}

std::vector<std::string> write_series(const store::MotionModel& model, const tables::FlexionMotion& motion,
                                      const fs::path& output)
{
  std::optional<Publication> result = begin_export(output.string());
  if (!result) return {};
  std::vector<std::string> files;
  std::vector<tables::SeriesEntry> entries;
  const auto write = [&](const tables::FlexionFrame& frame, int part, const std::string& name,
                         const std::string& bytes) {
    const std::string path = (output.parent_path() / name).string();
    result->add(path, bytes);
    files.push_back(path);
    entries.push_back({tables::abscissa(motion, frame), part, name});
  };
  run::make_folder((output.parent_path() / output.stem()).string());
  for (std::size_t k = 0; k < motion.frames.size(); ++k) {
    const tables::FlexionFrame& frame = motion.frames[k];
    write(frame, 0, piece_name(output, "", k), tables::posed_vtp(model, frame));
    const std::string contacts = motion.set == "raw" ? tables::contacts_vtp(model, frame) : "";
    if (!contacts.empty()) write(frame, 1, piece_name(output, "_contacts", k), contacts);
  }
  result->publish(tables::series_pvd(motion, entries));
  files.insert(files.begin(), output.string());
  return files;
}

std::vector<std::string> write_osim(const ExportOptions& options, const store::MotionModel& model,
                                    const tables::FlexionMotion& motion)
{
  const fs::path output = options.output, folder = output.parent_path() / "Geometry";
  const tables::OpenSimOptions opensim = opensim_options(options, model, motion.side);
  tables::OsimOptions osim{options.file, opensim.columns[0], output.stem().string()};
  osim.flexion_sign = opensim.sign[0];
  if (options.varus == driven_varus) {
    osim.surfaces = tables::osim_surfaces(model, options.file, motion.set);
    osim.varus_coordinate = opensim.columns[1];
    osim.varus_sign = opensim.sign[1];
  }
  if (options.only_joint) return write_single(options.output, tables::osim_joint(model, motion, osim));
  const tables::OsimModel exported = tables::osim_model(model, motion, osim);
  std::optional<Publication> result = begin_export(options.output);
  if (!result) return {};
  run::make_folder(folder.string());
  std::vector<std::string> files{options.output};
  for (const tables::OsimMesh& mesh : exported.meshes) {
    files.push_back((folder / mesh.file).string());
    result->add(files.back(), job::stl_bytes(mesh.mesh_m, "vrda export, metres"));
  }
  result->publish(exported.xml);
  return files;
}

/// For example knee_femur.stl and knee_tibia.stl of knee.stl.
std::vector<std::string> write_stl(const ExportOptions& options, const store::MotionModel& model,
                                   const tables::FlexionMotion& motion)
{
  const tables::ScanFrame scan = tables::scan_frame(model, options.file);
  const fs::path output = options.output;
  std::vector<std::string> files, contents;
  for (const auto& [name, mesh] : tables::meshes_in_scan(model, motion.frames.front(), scan)) {
    run::require_plain_text("name", name);
    files.push_back((output.parent_path() / (output.stem().string() + "_" + name + ".stl")).string());
    contents.push_back(
        job::stl_bytes(mesh, "vrda export" + (scan.space.empty() ? "" : " SPACE=" + scan.space)));
  }
  std::optional<Publication> result = begin_export(files.front());
  if (!result) return {};
  for (std::size_t k = 1; k < files.size(); ++k) result->add(files[k], contents[k]);
  result->publish(contents.front());
  return files;
}

std::string file_of(const ExportOptions& options, const store::MotionModel& model,
                    const tables::FlexionMotion& motion)
{
  if (options.format == "mrk")
    return tables::markups_in_scan(model, motion, tables::scan_frame(model, options.file));
  if (options.format == "gltf") return tables::animated_glb(model, motion, options.degrees_per_second);
  std::vector<store::JointPose> poses;
  for (const tables::FlexionFrame& frame : motion.frames) poses.push_back(frame.pose);
  if (options.format == "csv")
    return tables::flexion_csv(motion, analysis::flexion_curves(model, poses, run::thread_count_or_all(0)));
  return tables::opensim_table(motion, opensim_options(options, model, motion.side),
                               analysis::follower_curves(model, poses, 1));
}

void warn_of_left_out(const tables::FlexionMotion& motion)
{
  if (motion.omitted.empty()) return;
  std::string list;
  constexpr std::size_t most_shown = 10;
  for (std::size_t k = 0; k < std::min(most_shown, motion.omitted.size()); ++k) {
    const tables::OmittedFlexion& out = motion.omitted[k];
    list += (k > 0 ? ", " : "") + shortest_decimal(motion.key_name.empty() ? out.flexion_deg : out.key) +
            " (" + out.reason + ")";
  }
  if (motion.omitted.size() > most_shown) list += ", ...";
  core::log_warning(std::to_string(motion.omitted.size()) +
                    (motion.key_name.empty() ? " flexions" : " frames") + " omitted: " + list);
}

nlohmann::ordered_json report_of(const ExportOptions& options, const tables::FlexionMotion* motion,
                                 const std::vector<std::string>& files)
{
  nlohmann::ordered_json json{{"to", options.format}, {"files", files}};
  if (motion == nullptr) return json;
  json["set"] = motion->set;
  if (!motion->reason.empty()) json["reason"] = motion->reason;
  json["attitudes"] = motion->frames.size();
  json["left_out"] = nlohmann::ordered_json::array();
  for (const tables::OmittedFlexion& out : motion->omitted) {
    nlohmann::ordered_json& entry = json["left_out"].emplace_back();
    if (!motion->key_name.empty()) entry[motion->key_name] = out.key;
    entry.update({{"flexion_deg", out.flexion_deg}, {"why", out.reason}});
  }
  return json;
}

}  // namespace

nlohmann::ordered_json write_export(const ExportOptions& options)
{
  require_useful(options);
  require_output(options);
  const store::MotionModel model = store::read_motion_model(options.file);
  const fs::path output = options.output;
  if (options.every_cell) {
    if (!(model.status == status_stable).any()) {
      throw InputError({options.file, "status", "no stable cell", "at least one to export"});
    }
    return report_of(options, nullptr, write_single(options.output, tables::cells_csv(model)));
  }
  const tables::FlexionMotion motion = tables::flexion_motion(model, options.file, plan_of(options, model));
  std::vector<std::string> files;
  if (options.format == "vtk" || options.format == "osim")
    run::require_plain_text("--output", output.filename().string());
  if (options.format == "vtk") {
    files = write_series(model, motion, output);
  } else if (options.format == "stl") {
    files = write_stl(options, model, motion);
  } else if (options.format == "osim") {
    files = write_osim(options, model, motion);
  } else {
    files = write_single(options.output, file_of(options, model, motion));
  }
  warn_of_left_out(motion);
  const store::DefaultMotion shown = store::default_motion(model);
  if (options.set.empty() && !shown.reason.empty())
    core::log_warning(options.file + ": " + motion.set + " is exported; " + shown.reason);
  const std::string lock = gimbal_lock_text(motion.n_locked);
  if (!lock.empty()) core::log_warning(lock);
  core::log_info(motion.set + ": " + std::to_string(motion.frames.size()) + " attitudes");
  return report_of(options, &motion, files);
}

core::ExitCode export_command(const ExportOptions& options)
{
  const nlohmann::ordered_json report = write_export(options);
  if (options.as_json) {
    print_json(report);
  } else {
    for (const auto& file : report["files"]) std::printf("%s\n", file.get<std::string>().c_str());
  }
  return report["files"].empty() ? core::ExitCode::interrupted : core::ExitCode::done;
}

void declare_export(Command& c)
{
  auto& o = c.options<ExportOptions>();
  c.model(o.file);
  c.option("--to", o.format,
           "sto or mot (OpenSim motion), osim (OpenSim model), csv, gltf (.glb), vtk (.pvd, ParaView), or "
           "one pose in "
           "the frame of the scan: stl, mrk (.mrk.json, points and axes for 3D Slicer)")
      .required()
      .one_of({"sto", "mot", "osim", "csv", "gltf", "vtk", "stl", "mrk"});
  c.option("-o,--output", o.output, "Output file, with the extension of the format").required();
  c.option("--set", o.set,
           "two_sided, raw, degree_N, ...; default: the default motion of the model (vrda info)");
  c.option("--flexion", o.flexion, "FROM:TO:STEP, degrees; default: the flexions of the model");
  c.option("--pose", o.pose, "flexion=DEGREES: the pose of stl and mrk");
  c.option("--varus", o.varus,
           "Degrees, spine (balanced) or zero (the zero-varus table); default: spine for the raw poses, "
           "else zero if the table exists; in osim also driven: a second coordinate of the joint");
  c.option("--coordinate", o.coordinates,
           "COORDINATE=NAME: column name of flexion, varus, internal, tx, ty or tz in sto and mot, "
           "coordinate name of flexion in osim; -NAME negates it; may be repeated")
      .repeatable();
  c.flag("--degrees", o.in_degrees, "Angles of sto and mot in degrees; default: radians");
  c.option(
       "--translations", o.translations,
       "Point of tx, ty, tz in sto and mot: rotation-centre, or mesh-origin for joints without offset frames")
      .one_of({"rotation-centre", "mesh-origin"})
      .shows_default();
  c.option("--rate", o.degrees_per_second,
           "Flexion rate that sets time in sto, mot and gltf, degrees per second")
      .number(1e-3, 1e6)
      .shows_default();
  c.flag("--joint-only", o.only_joint, "osim: write only the joint, to paste into a model");
  c.flag("--full", o.every_cell, "csv: one row per grid cell, with all of its values");
  c.json(o.as_json);
  c.runs([&o] { return export_command(o); });
}

}  // namespace vrda::app
