#include "job/job.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <limits>
#include <utility>

#include "core/schema.hpp"
#include "job/auto_frame.hpp"
#include "job/job_parts.hpp"
#include "job/mesh_file.hpp"
#include "model/coordinates.hpp"

namespace vrda::job {
GenerateJob generate_of(const core::DocumentValue& value)
{
  GenerateJob generate;
  generate.shape = core::text_at(value, "shape");
  generate.part = core::text_or_empty(value, "part");
  for (const auto& [key, parameter] : value.items()) {
    if (key == "shape" || key == "part") continue;
    if (parameter.is_string()) {
      generate.words[key] = core::text_at(parameter, "");
    } else {
      generate.numbers[key] = core::number_at(parameter, "");
    }
  }
  return generate;
}

namespace {

constexpr std::uintmax_t largest_job_bytes = 16U << 20U;  // a job with ten thousand fibres is 2 MiB
constexpr double largest_grid_cells = 1e6;                // more is probably a mistake

ComponentJob component_of(const Job& job, const core::DocumentValue& value, const std::string& key)
{
  ComponentJob component;
  component.key = key;
  component.name = core::text_at(value, "name");
  component.file = core::text_or_empty(value, "file");
  if (const core::DocumentValue* generate = core::find_at(value, "generate"))
    component.generate = generate_of(*generate);
  if (component.file.empty() == !component.generate) {
    job.document.refuse(key, component.generate ? "both file and generate" : "neither file nor generate",
                        "one of file = \"mesh.stl\" and generate = { shape = \"knee\", part = \"femur\" }");
  }
  component.material = core::text_at(value, "material");
  component.has_contact = core::flag_at(value, "contact");
  component.winding = core::text_at(value, "winding") == "inward" ? Winding::inward : Winding::outward;
  if (const core::DocumentValue* offset = core::find_at(value, "offset_mm")) {
    component.is_offset_fitted = offset->is_string();
    if (!component.is_offset_fitted) component.offset_mm = core::number_at(*offset, "");
  }
  if (core::find_at(value, "overlap_mm") != nullptr)
    component.overlap_mm = core::number_at(value, "overlap_mm");
  component.inset_mm = core::number_at(value, "inset_mm");
  component.shift_mm = core::vector3_at(value, "shift_mm");
  return component;
}

BodyJob body_of(const Job& job, const core::DocumentValue& root, const std::string& key,
                const std::string& name)
{
  BodyJob body;
  body.name = name;
  body.frame = body_frame_at(job.document, key);
  std::vector<std::string> names;
  bool has_contact = false;
  for (const core::DocumentValue& value : core::value_at(root, key + ".component")) {
    const std::string item = key + ".component." + std::to_string(body.components.size());
    ComponentJob component = component_of(job, value, item);
    if (std::find(names.begin(), names.end(), component.name) != names.end()) {
      job.document.refuse(item + ".name", "\"" + component.name + "\" a second time",
                          "a unique name for each component");
    }
    if (body.frame && component.generate)
      job.document.refuse(item + ".generate",
                          "a generated part, which has canonical axes, in an object with a frame",
                          "mesh files, or no [" + key + ".frame]");
    names.push_back(component.name);
    has_contact = has_contact || component.has_contact;
    body.components.push_back(std::move(component));
  }
  if (!has_contact)
    job.document.refuse(key + ".component", "no component in contact", "at least one with contact = true");
  return body;
}

std::optional<ScalingJob> scaling_of(const Job& job, const core::DocumentValue& root)
{
  const core::DocumentValue* table = core::find_at(root, "scaling");
  if (table == nullptr) return std::nullopt;
  ScalingJob scaling;
  scaling.landmarks_file = core::text_or_empty(*table, "landmarks");
  const core::DocumentValue* factor = core::find_at(*table, "factor");
  if (factor == nullptr) return scaling;
  if (!scaling.landmarks_file.empty()) {
    throw InputError({job.document.source_of_conflict({"scaling.landmarks", "scaling.factor"}), "scaling",
                      "both factor and landmarks", "one of factor = 1.07 and landmarks = \"landmarks.csv\""});
  }
  scaling.factor = factor->is_array() ? core::vector3_at(*factor, "")
                                      : Eigen::Vector3d::Constant(core::number_at(*factor, ""));
  return scaling;
}

void read_grid(Job& job, const core::DocumentValue& root)
{
  job.coordinates = coordinates_of(job);
  resolve_driving_tables(job);
  if (job.coordinates) {
    // The short form of the same job.
    if (!is_plain_grid(*job.coordinates)) return;
    const auto& coordinate = job.coordinates->coordinate;
    job.grid.flexion_deg = coordinate[0].driven;
    job.is_varus_free = coordinate[1].role == CoordinateRole::free;
    job.grid.varus_deg = job.is_varus_free ? std::vector<double>{0.0} : coordinate[1].driven;
    job.coordinates.reset();
  } else {
    job.grid.flexion_deg = range_at(job.document, "grid.flexion");
    job.is_varus_free = core::value_at(root, "grid.varus").is_string();
    job.grid.varus_deg = job.is_varus_free ? std::vector<double>{0.0} : range_at(job.document, "grid.varus");
  }
  const double n_cells =
      static_cast<double>(job.grid.flexion_deg.size()) * static_cast<double>(job.grid.varus_deg.size());
  if (n_cells > largest_grid_cells) {
    job.document.refuse("grid", std::to_string(static_cast<std::int64_t>(n_cells)) + " attitudes",
                        "at most 1000000");
  }
}

SearchOptions search_of(const core::DocumentValue& root)
{
  const core::DocumentValue& search = core::value_at(root, "solver.search");
  SearchOptions options;
  options.approach_step_mm = core::number_at(search, "approach_step_mm");
  options.translation_step_mm = core::number_at(search, "translation_step_mm");
  options.translation_resolution_mm = core::number_at(search, "translation_resolution_mm");
  options.rotation_step_rad = rad_from_deg(core::number_at(search, "rotation_step_deg"));
  options.rotation_resolution_rad = rad_from_deg(core::number_at(search, "rotation_resolution_deg"));
  options.points =
      core::text_at(search, "points") == "exact" ? ContactPoints::exact : ContactPoints::triangle_centre;
  const std::string& normals = core::text_at(search, "normals");
  options.normals = normals == "reference" ? ContactNormals::reference
                    : normals == "moving"  ? ContactNormals::moving
                                           : ContactNormals::least_curvature;
  options.max_steps = static_cast<int>(core::integer_at(search, "max_steps"));
  return options;
}

// Throws if the resolution exceeds its step.
void check_step(const Job& job, const std::string& kind, const std::string& unit)
{
  const std::string resolution = "solver.search." + kind + "_resolution_" + unit;
  const std::string step_name = kind + "_step_" + unit, step = "solver.search." + step_name;
  const core::DocumentValue& root = job.document.root;
  if (core::number_at(root, resolution) <= core::number_at(root, step)) return;
  throw InputError({job.document.source_of_conflict({resolution, step}), resolution,
                    core::shown(core::value_at(root, resolution)),
                    "at most " + step_name + ", " + core::shown(core::value_at(root, step))});
}

FibreJob fibre_of(const Job& job, const core::DocumentValue& value, const std::string& key)
{
  const auto optional_number = [&](const char* name) {
    const core::DocumentValue* number = core::find_at(value, name);
    return number == nullptr ? std::nullopt : std::optional(core::number_at(*number, ""));
  };
  FibreJob fibre{core::text_at(value, "name"),
                 core::text_at(value, "bundle"),
                 core::vector3_at(value, "reference_mm"),
                 core::vector3_at(value, "moving_mm"),
                 core::number_at(value, "stiffness_n"),
                 optional_number("slack_length_mm"),
                 optional_number("reference_strain"),
                 core::text_at(value, "wrap"),
                 job.document.source_of(key),
                 key};
  if (fibre.slack_length_mm.has_value() == fibre.reference_strain.has_value()) {
    job.document.refuse(key, fibre.slack_length_mm ? "both slack_length_mm and reference_strain" : "neither",
                        "one of slack_length_mm and reference_strain");
  }
  return fibre;
}

std::optional<LigamentsJob> ligaments_at(const Job& job, const core::DocumentValue& root)
{
  const core::DocumentValue* table = core::find_at(root, "ligaments");
  if (table == nullptr) return std::nullopt;
  LigamentsJob ligaments;
  ligaments.fibres_file = core::text_or_empty(*table, "fibres");
  ligaments.wraps_file = core::text_or_empty(*table, "wraps");
  ligaments.transition_strain = core::number_at(*table, "transition_strain");
  const core::DocumentValue* fibres = core::find_at(*table, "fibre");
  const core::DocumentValue* generate = core::find_at(*table, "generate");
  std::string given;
  int n_given = 0;
  for (const char* key : {"fibres", "fibre", "generate"}) {
    if (!table->contains(key)) continue;
    given.append(n_given++ == 0 ? "both " : " and ").append(key);
  }
  if (n_given != 1) {
    job.document.refuse(
        "ligaments", n_given == 0 ? "neither fibres nor fibre nor generate" : given,
        "one of fibres = \"ligaments.csv\", [[ligaments.fibre]] and generate = { shape = \"knee\" }");
  }
  if (generate != nullptr) ligaments.generate = generate_of(*generate);
  if (fibres == nullptr) return ligaments;
  for (const core::DocumentValue& fibre : *fibres) {
    const std::string key = "ligaments.fibre." + std::to_string(ligaments.fibres.size());
    ligaments.fibres.push_back(fibre_of(job, fibre, key));
  }
  return ligaments;
}

CompartmentJob compartment_of(const core::DocumentValue& value)
{
  CompartmentJob compartment;
  compartment.half_space = core::text_or_empty(value, "half_space");
  compartment.components = core::texts_at(value, "components");
  return compartment;
}

// Of a shape that is made for a side.
void complete_side(core::DocumentValue* generate, const std::string& joint, const std::string& side)
{
  if (generate == nullptr || generate->contains("side")) return;
  const std::string shape = core::text_at(*generate, "shape");
  if (shape == "knee" || shape == joint) (*generate)["side"] = side;
}

// Defaults of joints other than a knee. The start of a knee, 20 mm distal, suits no other joint.
void complete_kind(core::DocumentValue& root, bool is_start_given, bool is_push_given)
{
  const JointKind& kind = joint_kind(core::text_at(root, "joint"));
  if (!is_start_given && kind.name != std::string("knee"))
    root["moving"]["initial"]["translation_mm"] = "auto";
  if (kind.name != std::string("hip")) return;
  core::DocumentValue& push = root["push"];
  if (!push.contains("frame")) push["frame"] = "reference";
  if (is_push_given) return;
  // Into an acetabulum that opens 45 degrees to the side and then 20 degrees forwards (the middle of what
  // Murray (1993), J Bone Joint Surg Br 75:228-232, reports of healthy hips).
  const double to_left = core::text_at(root, "side") == "right" ? -1.0 : 1.0;
  push["delta"] = {-0.342, 0.6645, 0.6645 * to_left};
}

// Defaults that depend on other keys: compartments of a knee, side of a generated knee, and factor 1 for an
// empty [scaling].
void complete(core::DocumentValue& root)
{
  const std::string side = core::text_at(root, "side");
  if (!root.contains("compartments") && joint_kind(core::text_at(root, "joint")).has_compartments) {
    root["compartments"]["medial"]["half_space"] = side == "right" ? "left" : "right";
    root["compartments"]["lateral"]["half_space"] = side;
  }
  for (const char* body : {"reference", "moving"}) {
    for (core::DocumentValue& component : root[body]["component"])
      complete_side(core::find_at(component, "generate"), core::text_at(root, "joint"), side);
  }
  if (root.contains("scaling") && root["scaling"].empty()) root["scaling"]["factor"] = 1.0;
  complete_side(core::find_at(root, "ligaments.generate"), "knee", side);
  for (std::size_t k = 0; k < core::list_or_empty(root, "follower").size(); ++k) {
    core::DocumentValue& follower = root["follower"][k];
    complete_side(core::find_at(follower, "generate"), "knee", side);
    for (core::DocumentValue& component : follower["component"])
      complete_side(core::find_at(component, "generate"), core::text_at(root, "joint"), side);
  }
}

// [player] is kept as given. Checks what the schema cannot express: unique view numbers.
void check_views(const Job& job)
{
  std::vector<std::int64_t> numbers;
  for (const core::DocumentValue& view : core::list_or_empty(job.document.root, "player.view")) {
    const std::int64_t number = core::integer_at(view, "number");
    if (std::find(numbers.begin(), numbers.end(), number) != numbers.end()) {
      job.document.refuse("player.view." + std::to_string(numbers.size()) + ".number",
                          std::to_string(number) + " a second time", "a unique number for each view");
    }
    numbers.push_back(number);
  }
}

void read_contact(Job& job, const core::DocumentValue& root)
{
  const std::string key = "solver.equilibrium.contact";
  const core::DocumentValue* contact = core::find_at(root, key);
  if (contact == nullptr) return;
  const auto refuse = [&](const std::string& found, const std::string& wanted) {
    job.document.refuse(key + ".model", "\"compliant\" with " + found, wanted);
  };
  if (job.method != SolverMethod::equilibrium)
    refuse("solver.method = \"stability-search\"", "\"exact\", or the method \"equilibrium\"");
  if (job.coordinates) refuse("[coordinates] or [frames]", "\"exact\", or a job with [grid]");
  job.equilibrium.contact_stiffness_n_per_mm3 = core::number_at(*contact, "stiffness_n_per_mm3");
  job.equilibrium.contact_thickness_mm = core::number_at(*contact, "thickness_mm");
}

void read_settings(Job& job)
{
  const core::DocumentValue& root = job.document.root;
  job.title = core::text_at(root, "title");
  job.joint = core::text_at(root, "joint");
  job.side = side_named(core::text_at(root, "side"));
  job.frame = frame_at(root, "frame");
  job.scaling = scaling_of(job, root);
  job.reference = body_of(job, root, "reference", core::text_at(root, "reference.name"));
  job.moving = body_of(job, root, "moving", core::text_at(root, "moving.name"));
  job.is_start_auto = core::value_at(root, "moving.initial.translation_mm").is_string();
  if (!job.is_start_auto)
    job.initial.translation_mm = core::vector3_at(root, "moving.initial.translation_mm");
  job.initial.theta_rad = rad_from_deg(core::number_at(root, "moving.initial.theta_deg"));
  job.push = push_of(job.document);
  job.method = core::text_at(root, "solver.method") == "equilibrium" ? SolverMethod::equilibrium
                                                                     : SolverMethod::stability_search;
  read_grid(job, root);
  job.search = search_of(root);
  check_step(job, "translation", "mm");
  check_step(job, "rotation", "deg");
  check_views(job);
  job.equilibrium = {core::number_at(root, "solver.equilibrium.tolerance_mm"),
                     static_cast<int>(core::integer_at(root, "solver.equilibrium.max_iterations")),
                     core::number_at(root, "solver.equilibrium.contact_resolution_mm")};
  read_contact(job, root);
  job.spine = {static_cast<int>(core::integer_at(root, "solver.equilibrium.restarts")),
               core::number_at(root, "solver.equilibrium.band_moment_nmm"),
               core::text_or_empty(root, "solver.equilibrium.branch") == "continuous" ? BranchRule::continuous
                                                                                      : BranchRule::lowest};
  job.prior = prior_of(job.document, job.push, job.spine.band_moment_nmm);
  job.ligaments = ligaments_at(job, root);
  job.followers = followers_of(
      job, [&](const std::string& key, const std::string& name) { return body_of(job, root, key, name); });
  if (const core::DocumentValue* compartments = core::find_at(root, "compartments")) {
    job.compartments.emplace();
    for (const auto& [side, name, meaning] : compartment_names)
      (*job.compartments)[side] = compartment_of(core::value_at(*compartments, name));
  }
  for (const double degree : core::numbers_at(root, "smooth.degrees")) {
    job.smooth_degrees.push_back(static_cast<std::int32_t>(degree));
  }
  job.smooth_recontact = core::flag_at(root, "smooth.recontact");
  job.smooth_robust = core::flag_at(root, "smooth.robust");
  job.unsolved_fraction = core::number_at(root, "limits.unsolved_fraction");
  job.laxity = laxity_of(job.document);
  job.fit = fit_of(job.document);
}

// An offset of 0 is no offset: the job is that without the key. So is the lowest branch.
void remove_zero_offsets(core::DocumentValue& root)
{
  core::DocumentValue& equilibrium = root["solver"]["equilibrium"];
  if (equilibrium.contains("branch") && equilibrium["branch"] == "lowest") equilibrium.erase("branch");
  for (const char* body : {"reference", "moving"}) {
    for (core::DocumentValue& component : root[body]["component"]) {
      for (const char* key : {"offset_mm", "overlap_mm"}) {
        if (component.contains(key) && component[key] == 0.0) component.erase(key);
      }
    }
  }
}

// The default: the job is that without the key.
void remove_exact_contact(core::DocumentValue& root)
{
  core::DocumentValue& equilibrium = root["solver"]["equilibrium"];
  if (equilibrium.contains("contact") && equilibrium["contact"]["model"] == "exact")
    equilibrium.erase("contact");
}

void set_texts(Job& job)
{
  core::DocumentValue steps = job.document.root;
  job.resolved_text = core::toml_text(steps);
  for (const char* key : {"laxity", "fit"}) steps.erase(key);
  job.steps_text = core::toml_text(steps);
  steps.erase("scaling");
  job.unscaled_text = core::toml_text(steps);
}

// grid.varus = 0 is the one angle 0.
void expand_angles(core::DocumentValue& root)
{
  for (const char* key : {"grid.flexion", "grid.varus"}) {
    core::DocumentValue* angle = core::find_at(root, key);
    if (angle != nullptr && angle->is_number()) *angle = {{"from", *angle}, {"to", *angle}, {"step", 1}};
  }
}

}  // namespace

std::vector<double> range_at(const core::Document& document, const std::string& key)
{
  constexpr double rounding = 1e-9;  // of (to - from) / step
  const double from_deg = core::number_at(document.root, key + ".from");
  const double to_deg = core::number_at(document.root, key + ".to");
  const double step_deg = core::number_at(document.root, key + ".step");
  if (step_deg == 0.0) document.refuse(key + ".step", "0", "a step that is not zero");
  const double n_steps = (to_deg - from_deg) / step_deg;
  if (n_steps < 0.0) {
    document.refuse(key,
                    "from " + shortest_decimal(from_deg) + " to " + shortest_decimal(to_deg) + " by " +
                        shortest_decimal(step_deg),
                    "a step with the sign of to - from");
  }
  if (!(n_steps < largest_grid_cells))
    document.refuse(key + ".step", shortest_decimal(step_deg), "at most 1000000 attitudes");
  std::vector<double> angles_deg;
  const auto n = static_cast<int>(std::floor(n_steps + rounding));
  for (int i = 0; i <= n; ++i) angles_deg.push_back(from_deg + i * step_deg + 0.0);
  return angles_deg;
}

Job parse_job(const std::string& file, std::string text, const std::vector<std::string>& overrides)
{
  Job job;
  job.file = file;
  job.text = std::move(text);
  job.document = core::read_toml(job.text, file);
  for (const std::string& override_text : overrides) core::apply_override(job.document, override_text);
  job.has_campaign = job.document.root.contains("campaign");
  const bool is_start_given = core::find_at(job.document.root, "moving.initial.translation_mm") != nullptr;
  const bool is_push_given = core::find_at(job.document.root, "push.delta") != nullptr;
  const bool has_grid = job.document.root.contains("grid");
  job.document.root = checked_job(job.document);
  expand_angles(job.document.root);
  complete(job.document.root);
  complete_kind(job.document.root, is_start_given, is_push_given);
  job.document.root = checked_job(job.document);  // again, to restore the order of keys
  for (const char* key : {"coordinates", "frames"}) {
    if (!job.document.root.contains(key)) continue;
    if (has_grid) job.document.refuse("grid", std::string("both [grid] and [") + key + "]", "one of them");
    job.document.root.erase("grid");
  }
  remove_zero_offsets(job.document.root);
  remove_exact_contact(job.document.root);
  set_texts(job);
  read_settings(job);
  return job;
}

Job with_found_frames(const Job& job, const FoundFrames& found)
{
  Job numeric = job;
  set_found_frame(numeric.document, numeric.reference, found.reference);
  set_found_frame(numeric.document, numeric.moving, found.moving);
  set_texts(numeric);
  return numeric;
}

bool has_mesh_file(const Job& job)
{
  const auto is_file = [](const ComponentJob& component) { return !component.generate; };
  return std::any_of(job.reference.components.begin(), job.reference.components.end(), is_file) ||
         std::any_of(job.moving.components.begin(), job.moving.components.end(), is_file);
}

Job read_job(const std::string& file, const std::vector<std::string>& overrides)
{
  return parse_job(file, file_bytes(file, {file, "", "", "a job file"}, largest_job_bytes), overrides);
}

const core::DocumentSchema& campaign_schema();  // schemas/campaign.schema.json
const core::DocumentSchema& job_schema();       // schemas/job.schema.json

namespace {

constexpr const char* campaign_key = "campaign";

// The [campaign] table only, the subject of its schema.
core::Document campaign_part(const core::Document& document)
{
  core::Document part = document;
  part.root = {{campaign_key, core::value_at(document.root, campaign_key)}};
  return part;
}

// Checks the names of the job keys that the levels of an axis set.
void check_settings(const core::Document& document, const std::string& axis,
                    const core::DocumentValue& levels)
{
  for (std::size_t i = 0; levels.is_array() && i < levels.size(); ++i) {
    const core::DocumentValue* settings = core::find_at(levels[i], "set");
    const std::string at = "campaign." + axis + "." + std::to_string(i) + ".set.";
    if (settings != nullptr)
      job_schema().check_known_keys({document.file, *settings, {}, at, document.lines});
  }
}

}  // namespace

core::DocumentValue checked_job(const core::Document& document)
{
  if (is_campaign_only(document.root)) {
    throw InputError({document.file, "reference", "a campaign without a joint",
                      "a job with [reference] and [moving]; run a campaign with vrda plan and vrda submit"});
  }
  core::DocumentValue job = job_schema().checked(document);
  if (document.root.contains(campaign_key)) campaign_schema().checked(campaign_part(document));
  job.erase(campaign_key);
  return job;
}

bool is_campaign_only(const core::DocumentValue& root)
{
  return root.contains(campaign_key) && !root.contains("reference") && !root.contains("moving");
}

void check_campaign(const core::Document& document)
{
  for (const auto& [key, value] : document.root.items()) {
    if (key == campaign_key || !is_campaign_only(document.root)) continue;
    document.refuse(key, "a key next to [campaign] in a file without a joint",
                    "only [campaign], or a complete job with [reference] and [moving]");
  }
  campaign_schema().checked(campaign_part(document));
  for (const auto& [axis, levels] : core::value_at(document.root, campaign_key).items())
    check_settings(document, axis, levels);
}

namespace {

namespace fs = std::filesystem;

fs::path path_of(const Job& job, const std::string& data_directory, const std::string& name)
{
  const fs::path in_data = fs::path(data_directory) / name;
  std::error_code ignored;
  if (!data_directory.empty() && fs::exists(in_data, ignored)) return in_data;
  return fs::path(job.file).parent_path() / name;
}

}  // namespace

std::uintmax_t mesh_bytes(const Job& job, const std::string& data_directory)
{
  std::uintmax_t n_bytes = 0;
  for (const BodyJob* body : {&job.reference, &job.moving}) {
    for (const ComponentJob& component : body->components) {
      if (component.generate) continue;
      std::error_code error;
      const std::uintmax_t size = fs::file_size(path_of(job, data_directory, component.file), error);
      if (!error) n_bytes += size;
    }
  }
  return n_bytes;
}

InputFile input_file(const Job& job, const std::string& data_directory, const FileReference& named)
{
  const std::string wanted = data_directory.empty() ? named.what + " in the folder of the job or of --data"
                                                    : named.what + " in \"" + data_directory +
                                                          "\" (--data) or in the folder of the job";
  const std::string path = path_of(job, data_directory, named.name).string();
  return {path,
          file_bytes(path, {job.document.source_of(named.key), named.key, "", wanted}, largest_mesh_bytes)};
}

namespace {

template <class Number>
std::optional<Number> number_in(std::string_view word)
{
  const bool has_plus = word.size() > 1 && word[0] == '+' && word[1] != '-';
  if (has_plus) word.remove_prefix(1);
  Number value{};
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (end != word.data() + word.size()) {
    // Of Microsoft's older libraries, "-1.#IND00" for example.
    const std::string_view size = word.substr(word.starts_with('-') ? 1 : 0);
    const bool is_no_number =
        std::is_floating_point_v<Number> && (size.starts_with("1.#IND") || size.starts_with("1.#QNAN") ||
                                             size.starts_with("1.#SNAN") || size.starts_with("1.#INF"));
    return is_no_number ? std::optional(std::numeric_limits<Number>::quiet_NaN()) : std::nullopt;
  }
  // from_chars reports 1e-400 like 1e400, which is no number.
  if (error == std::errc::result_out_of_range && std::is_floating_point_v<Number> &&
      std::abs(std::strtod(std::string(word).c_str(), nullptr)) < 1.0)
    return Number{};
  return error == std::errc() ? std::optional(value) : std::nullopt;
}

}  // namespace

bool is_space(char c)
{
  return c == ' ' || c == '\t' || c == '\n' || c == '\r';
}

std::string_view trimmed(std::string_view text, std::string_view characters)
{
  const std::size_t begin = text.find_first_not_of(characters);
  if (begin == text.npos) return {};
  return text.substr(begin, text.find_last_not_of(characters) + 1 - begin);
}

char separator_of(std::string_view names)
{
  names = trimmed(names);
  for (const char separator : {',', ';', '\t', '|'}) {
    if (names.find(separator) != names.npos) return separator;
  }
  return ',';
}

std::vector<std::string_view> split_fields(std::string_view line, char separator)
{
  std::vector<std::string_view> fields;
  while (true) {
    const std::size_t end = std::min(line.find(separator), line.size());
    std::string_view field = trimmed(line.substr(0, end));
    const bool is_quoted = field.size() > 1 && field.front() == '"' && field.back() == '"';
    fields.push_back(is_quoted ? trimmed(field.substr(1, field.size() - 2)) : field);
    if (end == line.size()) return fields;
    line.remove_prefix(end + 1);
  }
}

std::string wanted_number(std::string_view field)
{
  return field.find(',') == field.npos ? "a number" : "a number with a decimal point, not a comma";
}

std::vector<TableLine> table_lines(std::string_view text)
{
  if (text.starts_with(byte_order_mark)) text.remove_prefix(byte_order_mark.size());
  std::vector<TableLine> lines;
  const char line_end = text.find('\n') == text.npos ? '\r' : '\n';
  for (std::size_t number = 1; !text.empty(); ++number) {
    const std::size_t end = std::min(text.find(line_end), text.size());
    const std::string_view words = trimmed(text.substr(0, end));
    // A spreadsheet may name its separator in the first line, "sep=;".
    const bool is_data =
        !words.empty() && words.front() != '#' && !(number == 1 && words.starts_with("sep="));
    // Tabs at the ends may separate empty fields.
    if (is_data) lines.push_back({trimmed(text.substr(0, end), " \r"), number});
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return lines;
}

std::vector<std::string_view> split_words(std::string_view line)
{
  constexpr std::string_view separators = " \t";
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  std::vector<std::string_view> words;
  std::size_t begin = line.find_first_not_of(separators);
  while (begin != std::string_view::npos) {
    const std::size_t end = std::min(line.find_first_of(separators, begin), line.size());
    words.push_back(line.substr(begin, end - begin));
    begin = line.find_first_not_of(separators, end);
  }
  return words;
}

std::optional<double> parse_real(std::string_view word)
{
  return number_in<double>(word);
}
std::optional<std::int64_t> parse_integer(std::string_view word)
{
  return number_in<std::int64_t>(word);
}

}  // namespace vrda::job
