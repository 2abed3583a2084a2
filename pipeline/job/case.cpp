#include "job/case.hpp"

#include <utility>

#include "core/text.hpp"
#include "job/auto_frame.hpp"
#include "job/case_warnings.hpp"
#include "job/component_loader.hpp"
#include "job/job.hpp"
#include "job/job_parts.hpp"
#include "job/ligament_files.hpp"
#include "job/slicer_files.hpp"

namespace vrda::job {
namespace {

// A mean of unit vectors shorter than this has no usable direction.
constexpr double smallest_direction = 1e-6;

void check_overlaps(const Job& job)
{
  for (const BodyJob* body : {&job.reference, &job.moving}) {
    for (const ComponentJob& component : body->components) {
      if (component.overlap_mm == 0.0) continue;
      const std::string key = component.key + ".overlap_mm";
      throw InputError({job.document.source_of_conflict({key, "solver.method"}), key,
                        shortest_decimal(component.overlap_mm),
                        "0, or solver.method = \"equilibrium\": \"stability-search\" allows no overlap"});
    }
  }
}

void check_method(const Job& job)
{
  if (job.method == SolverMethod::stability_search) check_overlaps(job);
  if (job.method == SolverMethod::equilibrium || !job.is_varus_free) return;
  throw InputError({job.document.source_of_conflict({"grid.varus", "solver.method"}), "grid.varus",
                    "\"free\"", "a table { from, to, step }: \"stability-search\" cannot leave varus free"});
}

std::vector<Push> push_rows(const Job& job, const PushJob& push, const std::vector<double>& flexions_deg)
{
  std::vector<Push> rows;
  for (const double flexion_deg : flexions_deg) {
    const double flexion_rad = rad_from_deg(flexion_deg);
    const Eigen::Vector3d direction = value_at_flexion(push.delta, flexion_rad);
    if (!(direction.norm() > smallest_direction)) {
      throw InputError(
          {job.document.source_of("push.delta"), "push.delta",
           "directions that cancel out at " + shortest_decimal(flexion_deg) + " degrees of flexion",
           "directions of neighbouring rows less than 180 degrees apart"});
    }
    rows.push_back(push_at(push, direction.normalized(), flexion_rad, rows.size()));
  }
  return rows;
}

void check_fixed_push(const Job& job, const std::optional<LoadedCoordinates>& coordinates)
{
  const auto is_free = [&](std::size_t k) { return coordinates->rows.role[k] == CoordinateRole::free; };
  if (job.method == SolverMethod::equilibrium && coordinates && coordinates->rows.is_sequence() &&
      !is_free(0) && !is_free(1) && !is_free(2))
    return;
  throw InputError({job.document.source_of_conflict({"push.frame", "coordinates"}), "push.frame",
                    "\"reference\" (the default of joint = \"hip\") without three known rotations",
                    "[coordinates] with one rotation driven and the other two given, or frame = \"world\""});
}

// Delta and forces from axes of the reference to axes of the moving object.
void turn_with_reference(const Case& loaded, std::vector<Push>& pushes)
{
  const Eigen::Vector3d mirror(1.0, 1.0, loaded.frame.side == Side::left ? -1.0 : 1.0);
  for (std::size_t i = 0; i < pushes.size(); ++i) {
    JointCoordinates rotations = JointCoordinates::Zero();
    rotations.head<3>() = loaded.coordinates->rows.at(i).head<3>();
    const Eigen::Matrix3d R = mirror.asDiagonal() * joint_pose(rotations).linear() * mirror.asDiagonal();
    pushes[i].delta = (R.transpose() * pushes[i].delta).normalized();
    pushes[i].force_n = R.transpose() * pushes[i].force_n;
  }
}

std::optional<LoadedCoordinates> coordinates_of(const Job& job, const std::string& data_directory)
{
  if (!job.coordinates) return std::nullopt;
  return load_coordinates(job, *job.coordinates, data_directory);
}

// The offset changes every step, so a job is loaded with a number only.
void require_offsets(const Job& job)
{
  for (const BodyJob* body : {&job.reference, &job.moving}) {
    for (const ComponentJob& component : body->components) {
      if (!component.is_offset_fitted) continue;
      job.document.refuse(component.key + ".offset_mm", "\"fit\"",
                          "a number; vrda fit JOB --motion FILE finds it from a measured motion");
    }
  }
}

void append_part(Part& part, const Mesh& mesh, std::int32_t component)
{
  append(part.mesh, mesh);
  part.component.insert(part.component.end(), static_cast<std::size_t>(mesh.triangles.rows()), component);
}

// The part of the case that depends on the job file and the tables of its coordinates.
Case settings_of(const Job& job, const std::optional<LoadedCoordinates>& coordinates)
{
  check_method(job);
  require_offsets(job);
  Case loaded;
  static_cast<CaseSettings&>(loaded) = job;
  loaded.frame.side = job.side;
  loaded.frame.rotation_centre_mm = axis_map(job)(job.frame.origin_native);
  if (coordinates) {
    loaded.grid = coordinates->grid;
    loaded.coordinates = coordinates->rows;
    loaded.path_flexion_deg = coordinates->path_flexion_deg;
    // Its varus then belongs to the cell instead of the axis.
    loaded.is_varus_free =
        coordinates->rows.role[1] != CoordinateRole::driven || coordinates->rows.is_sequence();
  } else {
    loaded.path_flexion_deg =
        job.method == SolverMethod::equilibrium ? path_of(job.grid.flexion_deg) : job.grid.flexion_deg;
  }
  const PushJob& push = coordinates ? coordinates->push : job.push;
  loaded.push = push_rows(job, push, loaded.grid.flexion_deg);
  loaded.path_push = push_rows(job, push, loaded.path_flexion_deg);
  loaded.push_at_meshes = loaded.push.front();
  loaded.is_push_fixed_in_reference = push.is_fixed_in_reference;
  if (push.is_fixed_in_reference) {
    check_fixed_push(job, coordinates);
    loaded.push_at_meshes = push_at(push, value_at_flexion(push.delta, 0.0).normalized(), 0.0);
    turn_with_reference(loaded, loaded.push);
    turn_with_reference(loaded, loaded.path_push);
  }
  loaded.push_point_mm = job.push.point_mm;
  for (const LoadJob& load : job.push.loads) loaded.loads.push_back(load.at);
  for (const LineJob& line : job.push.lines) loaded.lines.push_back(line.path);
  loaded.frame.delta = loaded.push.front().delta;
  loaded.method = job.method == SolverMethod::equilibrium ? "equilibrium" : "stability-search";
  loaded.job_text = job.text;
  loaded.resolved_job = job.resolved_text;
  return loaded;
}

// Of [laxity] and [fit], whose commands may run long after a check.
void check_fibre_names(const Job& job, const Case& loaded)
{
  // One without fibres is refused by the command.
  const auto check_name = [&](const std::string& name, const model::Ligaments& ligaments,
                              std::string model::Fibre::*of, const std::string& key) {
    std::vector<std::string> known;
    for (const model::Fibre& fibre : ligaments.fibres) known.push_back(fibre.*of);
    if (name.empty() || known.empty() || std::find(known.begin(), known.end(), name) != known.end()) return;
    job.document.refuse(key, '"' + name + '"',
                        "one of the job; the nearest is \"" + nearest_word(name, known) + '"');
  };
  for (std::size_t k = 0; job.laxity && k < job.laxity->cuts.size(); ++k) {
    for (const std::string& bundle : job.laxity->cuts[k].bundles)
      check_name(bundle, loaded.ligaments, &model::Fibre::bundle,
                 "laxity.cut." + std::to_string(k) + ".bundles");
  }
  for (std::size_t k = 0; job.fit && k < job.fit->parameters.size(); ++k) {
    const FitParameterJob& parameter = job.fit->parameters[k];
    const auto own = std::ranges::find(loaded.followers, parameter.follower, &Follower::name);
    const model::Ligaments& ligaments = own == loaded.followers.end() ? loaded.ligaments : own->ligaments;
    const std::string key = "fit.parameter." + std::to_string(k);
    check_name(parameter.bundle, ligaments, &model::Fibre::bundle, key + ".bundle");
    check_name(parameter.fibre, ligaments, &model::Fibre::name, key + ".fibre");
  }
}

}  // namespace

Body loaded_body(const Job& job, const BodyJob& body_job, ComponentLoader& source, Case& loaded,
                 std::vector<std::vector<Eigen::Index>>& small_shells)
{
  const AxisMap map = body_map(job, body_job);
  Body body;
  body.name = body_job.name;
  for (const ComponentJob& component : body_job.components) {
    LoadedComponent part = source.load(component, map);
    part.survey.body = body.name;
    const auto index = static_cast<std::int32_t>(body.components.size());
    if (component.has_contact && !component.generate) {
      for (std::vector<Eigen::Index>& shell : part.clean.small_shells) {
        for (Eigen::Index& t : shell) t += body.contact.mesh.triangles.rows();
        small_shells.push_back(std::move(shell));
      }
    }
    append_part(component.has_contact ? body.contact : body.visual, part.clean.mesh, index);
    body.components.push_back({component.name, component.material});
    loaded.inputs.push_back(part.input);
    if (part.normals) loaded.inputs.push_back(*part.normals);
    loaded.survey.push_back(part.survey);
    const std::string coordinates = coordinate_warning(part.survey, part.native, map.unit_mm);
    if (!coordinates.empty()) loaded.warnings.push_back(coordinates);
  }
  return body;
}

Case case_with_joint(const Job& given, const std::string& data_directory, const Case& joint)
{
  const Job job = joint.found_frames ? with_found_frames(given, *joint.found_frames) : given;
  Case loaded = settings_of(job, coordinates_of(job, data_directory));
  loaded.found_frames = joint.found_frames;
  loaded.ligaments = joint.ligaments;
  loaded.followers = joint.followers;
  for (Follower& follower : loaded.followers) follower.body = {};  // as the bodies of the joint
  loaded.inputs = joint.inputs;
  loaded.compartment_of_triangle = joint.compartment_of_triangle;
  loaded.uncertainty = joint.uncertainty;
  if (job.is_start_auto) loaded.initial.translation_mm = joint.initial.translation_mm;
  apply_scaling(loaded, job, load_scaling(job, data_directory, axis_map(job)));
  return loaded;
}

Case with_one_delta(Case loaded, const std::string& job_file)
{
  if (!loaded.is_push_fixed_in_reference) {
    for (const Push& push : loaded.push) {
      if (push.delta != loaded.frame.delta)
        throw InputError({job_file, "push.delta", "directions that differ over flexion",
                          "one direction for a measured motion"});
    }
    return loaded;
  }
  for (std::vector<Push>* rows : {&loaded.push, &loaded.path_push}) {
    for (Push& push : *rows) {
      push.delta = loaded.push_at_meshes.delta;
      push.force_n = loaded.push_at_meshes.force_n;
    }
  }
  loaded.frame.delta = loaded.push_at_meshes.delta;
  loaded.is_push_fixed_in_reference = false;
  return loaded;
}

Case load_case(const std::string& job_file, const LoadOptions& options)
{
  return load_case(read_job(job_file, options.overrides), options.data_directory);
}

Case load_case(const Job& given, const std::string& data_directory)
{
  using Warnings = std::vector<std::string>;
  ComponentLoader source(given, data_directory);
  const std::optional<AutoFrames> found = auto_frames(given, source);
  const Job job = found ? with_found_frames(given, found->frames) : given;
  const std::optional<LoadedCoordinates> coordinates = coordinates_of(job, data_directory);
  Case loaded = settings_of(job, coordinates);
  if (coordinates) loaded.inputs = coordinates->inputs;
  if (found) loaded.found_frames = found->frames;
  const LoadedLigaments ligaments = load_ligaments(job, data_directory, body_maps(job));
  const RequestedScaling scaling = load_scaling(job, data_directory, axis_map(job));
  require_one_space(job, data_directory);
  SmallShells small_shells;
  loaded.reference = loaded_body(job, job.reference, source, loaded, small_shells.reference);
  loaded.moving = loaded_body(job, job.moving, source, loaded, small_shells.moving);
  check_unit(job, loaded.survey);  // before the fibres: a wrong unit also misplaces attachments
  check_attachments(ligaments, {&loaded.reference, &loaded.moving});
  loaded.ligaments = ligaments.ligaments;
  loaded.inputs.insert(loaded.inputs.end(), ligaments.inputs.begin(), ligaments.inputs.end());
  loaded.followers = load_followers(job, data_directory, source, loaded);
  loaded.compartment_of_triangle = compartments_of(job, loaded.moving, loaded.frame.rotation_centre_mm.z());
  if (job.is_start_auto)
    loaded.initial.translation_mm = start_travel_mm(loaded) * loaded.push_at_meshes.delta;
  check_fibre_names(job, loaded);
  LoadedUncertainty uncertainty = load_uncertainty(job, data_directory, loaded, ligaments);
  loaded.uncertainty = std::move(uncertainty.uncertainty);
  loaded.inputs.insert(loaded.inputs.end(), uncertainty.inputs.begin(), uncertainty.inputs.end());
  const Warnings meshes = mesh_warnings(job, loaded);
  const Warnings anatomy = anatomy_warnings(job, loaded);
  const Warnings surfaces = surface_warnings(job, loaded, small_shells);
  const Warnings fibres = fibre_warnings(ligaments, loaded);
  apply_scaling(loaded, job, scaling);
  const Warnings coordinates_of_files = loaded.warnings;
  loaded.warnings = case_warnings(job, scaled_to_subject(loaded));
  const Warnings frames = found ? found->warnings : Warnings{};
  for (const Warnings& more :
       {frames, coordinates_of_files, meshes, anatomy, surfaces, fibres, scaling.warnings})
    loaded.warnings.insert(loaded.warnings.end(), more.begin(), more.end());
  return loaded;
}

}  // namespace vrda::job
