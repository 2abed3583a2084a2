#include "job/component_loader.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <tuple>
#include <utility>

#include "contact/contacts.hpp"
#include "core/units.hpp"
#include "geometry/gap_query.hpp"
#include "job/auto_frame.hpp"
#include "job/case_warnings.hpp"
#include "job/mesh_file.hpp"

namespace vrda::job {
namespace {

Eigen::Vector3d axis_of(const std::string& word)
{
  Eigen::Vector3d axis = Eigen::Vector3d::Zero();
  axis[word.at(1) - 'X'] = word.at(0) == '-' ? -1.0 : 1.0;
  return axis;
}

std::string opposite(const std::string& word)
{
  return (word.at(0) == '-' ? "+" : "-") + word.substr(1);
}

}  // namespace

double mm_per_unit(const std::string& unit)
{
  return unit == "m" ? 1000.0 : unit == "cm" ? 10.0 : 1.0;
}

const char* unit_of_mm(double mm)
{
  return mm == 1.0 ? "mm" : mm == 10.0 ? "cm" : "m";
}

namespace {

// The axes of the files' names, as rows.
Eigen::Matrix3d named_axes(const Job& job, const FrameJob& frame)
{
  const std::string words = "anterior = \"" + frame.anterior + "\", proximal = \"" + frame.proximal +
                            "\", right = \"" + frame.right + "\"";
  Eigen::Matrix3d R_canonical_native;
  R_canonical_native.row(0) = axis_of(frame.anterior).transpose();
  R_canonical_native.row(1) = axis_of(frame.proximal).transpose();
  R_canonical_native.row(2) = axis_of(frame.right).transpose();
  const std::string source = job.document.source_of_conflict(
      {frame.key + ".anterior", frame.key + ".proximal", frame.key + ".right"});
  const double handedness =
      R_canonical_native.row(0).cross(R_canonical_native.row(1)).dot(R_canonical_native.row(2));
  if (handedness == 0.0) throw InputError({source, frame.key, words, "each of X, Y and Z once"});
  if (handedness < 0.0) {
    throw InputError({source, frame.key, words + ", a left-handed map",
                      "a right-handed map; if anterior and proximal are correct: right = \"" +
                          opposite(frame.right) + "\""});
  }
  return R_canonical_native;
}

AxisMap map_of(const Job& job, const FrameJob& frame)
{
  const Eigen::Matrix3d R_canonical_native = named_axes(job, frame);
  const Eigen::Matrix3d R_align = rotation_z(frame.align_rotation_rad.z()) *
                                  rotation_y(frame.align_rotation_rad.y()) *
                                  rotation_x(frame.align_rotation_rad.x());
  AxisMap map;
  map.unit_mm = mm_per_unit(frame.unit);
  map.X_canonical_native.linear() = R_canonical_native * R_align;
  map.X_canonical_native.translation() = R_canonical_native * frame.align_translation_mm;
  return map;
}

}  // namespace

AxisMap axis_map(const Job& job)
{
  return map_of(job, job.frame);
}

AxisMap body_map(const Job& job, const BodyJob& body)
{
  const AxisMap joint = axis_map(job);
  if (!body.frame) return joint;
  AxisMap map = map_of(job, *body.frame);
  const Eigen::Vector3d origin_mm = map.unit_mm * body.frame->origin_native;
  map.X_canonical_native.translation() +=
      joint(job.frame.origin_native) - map.X_canonical_native.linear() * origin_mm;
  return map;
}

BodyMaps body_maps(const Job& job)
{
  return {body_map(job, job.reference), body_map(job, job.moving)};
}

namespace {

std::vector<const geometry::ShapePart*> parts_of(const geometry::Shape& shape)
{
  std::vector<const geometry::ShapePart*> all;
  for (const std::vector<geometry::ShapePart>* parts : {&shape.reference, &shape.moving, &shape.followers}) {
    for (const geometry::ShapePart& part : *parts) all.push_back(&part);
  }
  return all;
}

// Vertices as doubles, then triangles as 32-bit integers, in memory byte order (little-endian).
std::string bytes_of(const Mesh& mesh)
{
  const std::size_t n_vertex_bytes = static_cast<std::size_t>(mesh.vertices_mm.size()) * sizeof(double);
  const std::size_t n_triangle_bytes = static_cast<std::size_t>(mesh.triangles.size()) * sizeof(std::int32_t);
  std::string bytes(n_vertex_bytes + n_triangle_bytes, '\0');
  std::memcpy(bytes.data(), mesh.vertices_mm.data(), n_vertex_bytes);
  std::memcpy(bytes.data() + n_vertex_bytes, mesh.triangles.data(), n_triangle_bytes);
  return bytes;
}

RawMesh raw_of(const Mesh& mesh)
{
  RawMesh raw;
  raw.vertices = mesh.vertices_mm;
  raw.normals = mesh.normals;
  raw.corner.assign(mesh.triangles.data(), mesh.triangles.data() + mesh.triangles.size());
  raw.size.assign(static_cast<std::size_t>(mesh.triangles.rows()), 3);
  return raw;
}

Mesh canonical(const Mesh& native, const AxisMap& map)
{
  Mesh mesh = native;
  mesh.vertices_mm *= map.unit_mm;
  return transformed(mesh, map.X_canonical_native);
}

// Normals stay unchanged: each vertex moves along its own normal.
void move_surface(Mesh& mesh, const ComponentJob& component)
{
  if (component.inset_mm != 0.0) mesh.vertices_mm -= component.inset_mm * vertex_normals(mesh);
  if (!component.shift_mm.isZero(0.0)) mesh.vertices_mm.rowwise() += component.shift_mm.transpose();
}

// `vertices_mm` are those of the mesh in the axes of its file, `unit_mm` is the unit of the file.
ComponentSurvey survey_of(const ComponentJob& component, const CleanMesh& clean, const std::string& source,
                          const Points& vertices_mm, double unit_mm)
{
  const EdgeCounts edges = edge_counts(clean.mesh);
  ComponentSurvey survey;
  survey.name = component.name;
  survey.source = source;
  survey.has_contact = component.has_contact;
  survey.n_vertices = clean.mesh.vertices_mm.rows();
  survey.n_triangles = clean.mesh.triangles.rows();
  survey.n_welded = clean.n_welded;
  survey.n_degenerate = clean.n_degenerate;
  survey.n_identical = clean.n_identical;
  const auto places_at = [&](std::vector<Eigen::Vector3d> points) {
    for (Eigen::Vector3d& p_mm : points) p_mm *= unit_mm;
    return places_text(points);
  };
  survey.degenerate_places = places_at(clean.degenerate_at);
  if (!clean.fold_at.empty() && !component.generate)
    survey.notes.push_back("folds, edges at which the surface turns back on itself: " +
                           std::to_string(clean.fold_at.size()) + ", " + places_at(clean.fold_at));
  if (!clean.needle_at.empty() && !component.generate)
    survey.notes.push_back("needles, triangles narrower than 1 % of their length: " +
                           std::to_string(clean.needle_at.size()) + ", " + places_at(clean.needle_at));
  const auto places_of = [&](const std::vector<std::int32_t>& rows) {
    std::vector<Eigen::Vector3d> places_mm;
    for (const std::int32_t row : rows) places_mm.emplace_back(vertices_mm.row(row));
    return places_text(places_mm);
  };
  survey.boundary_places = places_of(edges.boundary_vertex);
  survey.non_manifold_places = places_of(edges.non_manifold_vertex);
  survey.n_boundary_edges = edges.boundary;
  survey.n_non_manifold_edges = edges.non_manifold;
  survey.was_flipped = clean.was_flipped;
  survey.has_sheet = clean.has_sheet;
  survey.box = bounding_box(clean.mesh);
  survey.mean_edge_mm = mean_edge_length_mm(clean.mesh);
  survey.area_mm2 = area_mm2(clean.mesh);
  survey.volume_mm3 = signed_volume_mm3(clean.mesh);
  return survey;
}

}  // namespace

std::string shape_request_text(const GenerateJob& generate)
{
  std::string text = generate.shape;
  std::map<std::string, std::string> parameters(generate.words.begin(), generate.words.end());
  for (const auto& [key, number] : generate.numbers) parameters[key] = shortest_decimal(number);
  for (const auto& [key, value] : parameters) text.append(" ").append(key).append("=").append(value);
  return text;
}

ComponentLoader::ComponentLoader(const Job& job, const std::string& data_directory)
    : job_(job), data_directory_(data_directory)
{
}

LoadedComponent ComponentLoader::load(const ComponentJob& component, const AxisMap& map)
{
  LoadedComponent out;
  out.clean = component.generate ? generated(component, out.input) : from_file(component, map, out);
  if (out.clean.mesh.triangles.rows() == 0) {
    throw InputError({out.input.name, "",
                      std::to_string(out.clean.n_degenerate) + " faces, all with zero area",
                      "a mesh with faces"});
  }
  move_surface(out.clean.mesh, component);
  if (component.has_contact && component.offset_mm > 0.0) {
    out.clean.mesh.offset_mm.assign(static_cast<std::size_t>(out.clean.mesh.triangles.rows()),
                                    component.offset_mm);
  }
  if (component.has_contact && component.overlap_mm > 0.0) {
    out.clean.mesh.overlap_mm.assign(static_cast<std::size_t>(out.clean.mesh.triangles.rows()),
                                     component.overlap_mm);
  }
  const bool is_generated = component.generate.has_value();
  const double unit_mm = is_generated ? 1.0 : map.unit_mm;
  const Points vertices_mm = is_generated ? out.clean.mesh.vertices_mm : Points(unit_mm * out.native);
  out.survey = survey_of(component, out.clean, out.input.name, vertices_mm, unit_mm);
  out.survey.notes.insert(out.survey.notes.begin(), out.notes.begin(), out.notes.end());
  return out;
}

CleanMesh ComponentLoader::from_file(const ComponentJob& component, const AxisMap& map,
                                     LoadedComponent& out) const
{
  namespace fs = std::filesystem;
  InputFile file =
      input_file(job_, data_directory_, {component.key + ".file", component.file, "a mesh file"});
  out.input = {component.file, sha256_of(file.bytes)};
  const fs::path normals_path = fs::path(file.path).replace_extension(".normals");
  const bool has_normals_file =
      fs::path(file.path).extension() != ".stl" && is_vertices_faces(file.bytes) && fs::exists(normals_path);
  RawMesh mesh = read_mesh(file.path, std::move(file.bytes));
  out.notes = mesh.notes;
  if (has_normals_file) {
    const std::string path = normals_path.string();
    const std::string bytes = file_bytes(path, {path, "", "", "a file of normals"}, largest_mesh_bytes);
    mesh.normals = read_vertex_normals(path, bytes, mesh.vertices.rows());
    out.normals = {fs::path(component.file).replace_extension(".normals").string(), sha256_of(bytes)};
  }
  CleanMesh clean = clean_mesh(mesh, component.winding, job_.side);
  out.native = clean.mesh.vertices_mm;
  clean.mesh = canonical(clean.mesh, map);
  return clean;
}

CleanMesh ComponentLoader::generated(const ComponentJob& component, LoadedInput& input)
{
  const geometry::Shape& shape = shape_of(component);
  const GenerateJob& generate = *component.generate;
  const std::vector<const geometry::ShapePart*> parts = parts_of(shape);
  const auto found = std::ranges::find(parts, generate.part, &geometry::ShapePart::name);
  if (found == parts.end()) {
    std::vector<std::string> names;
    for (const geometry::ShapePart* part : parts) names.push_back(part->name);
    const std::string key = component.key + ".generate.part";
    throw InputError({job_.document.source_of(key), key, "\"" + generate.part + "\"",
                      "a part of \"" + generate.shape + "\"; the nearest is \"" +
                          nearest_word(generate.part, names) + "\""});
  }
  input = {shape_request_text(generate) + " part=" + generate.part, sha256_of(bytes_of((*found)->mesh))};
  return clean_mesh(raw_of((*found)->mesh), component.winding, job_.side);
}

const geometry::Shape& ComponentLoader::shape_of(const ComponentJob& component)
{
  const GenerateJob& generate = *component.generate;
  const std::string request = shape_request_text(generate);
  if (const auto found = shapes_.find(request); found != shapes_.end()) return found->second;
  geometry::Shape shape = with_job_key(job_, component.key + ".generate", generate, [&] {
    return geometry::generate_shape({generate.shape, generate.numbers, generate.words});
  });
  constexpr Eigen::Index most_generated = 5'000'000;
  for (const geometry::ShapePart* part : parts_of(shape)) n_generated_ += part->mesh.triangles.rows();
  if (n_generated_ > most_generated) {
    job_.document.refuse(component.key + ".generate",
                         "generated shapes of " + std::to_string(n_generated_) + " triangles in all",
                         "at most " + std::to_string(most_generated));
  }
  return shapes_.emplace(request, std::move(shape)).first->second;
}

// The frames of a job: of the joint and of a body (schemas/frames.md).

namespace {

constexpr const char* automatic = "auto";

bool is_automatic(const core::DocumentValue& root, const std::string& key)
{
  return core::value_at(root, key) == automatic;
}

// A frame that is found has no axes to name.
void check_automatic(const core::Document& document, const FrameJob& frame)
{
  if (!frame.is_origin_auto && !frame.is_align_auto) return;
  if (core::text_at(document.root, "joint") != "knee")
    document.refuse(frame.key, "\"auto\" with joint = \"" + core::text_at(document.root, "joint") + "\"",
                    "numbers: only the frames of a knee are found");
  if (!frame.is_align_auto) return;
  for (const auto& [key, word, preset] :
       {std::tuple(".anterior", &frame.anterior, "+X"), std::tuple(".proximal", &frame.proximal, "+Y"),
        std::tuple(".right", &frame.right, "+Z")}) {
    if (*word != preset)
      document.refuse(frame.key + key, "\"" + *word + "\" with align = \"auto\"",
                      "no axes, or align with numbers");
  }
}

core::DocumentValue list_of(const Eigen::Vector3d& v)
{
  return {v.x(), v.y(), v.z()};
}

}  // namespace

FrameJob frame_at(const core::DocumentValue& root, const std::string& key)
{
  FrameJob frame;
  frame.key = key;
  frame.unit = core::text_at(root, key + ".unit");
  frame.anterior = core::text_at(root, key + ".anterior");
  frame.proximal = core::text_at(root, key + ".proximal");
  frame.right = core::text_at(root, key + ".right");
  frame.is_origin_auto = is_automatic(root, key + ".origin");
  frame.is_align_auto = is_automatic(root, key + ".align");
  if (!frame.is_origin_auto) frame.origin_native = core::vector3_at(root, key + ".origin");
  if (frame.is_align_auto) return frame;
  const Eigen::Vector3d rotation_deg = core::vector3_at(root, key + ".align.rotation_deg");
  for (int k = 0; k < 3; ++k) frame.align_rotation_rad[k] = rad_from_deg(rotation_deg[k]);
  frame.align_translation_mm = core::vector3_at(root, key + ".align.translation_mm");
  return frame;
}

std::optional<FrameJob> body_frame_at(const core::Document& document, const std::string& body)
{
  const std::string key = body + ".frame";
  if (core::find_at(document.root, key) == nullptr) return std::nullopt;
  FrameJob frame = frame_at(document.root, key);
  check_automatic(document, frame);
  return frame;
}

void set_found_frame(core::Document& document, BodyJob& body, const FoundFrame& found)
{
  if (!body.frame) return;
  const std::string key = body.frame->key;
  core::DocumentValue& frame = *core::find_at(document.root, key);
  if (body.frame->is_origin_auto) frame["origin"] = list_of(found.origin_native);
  if (body.frame->is_align_auto)
    frame["align"] = {{"rotation_deg", list_of(found.rotation_deg)},
                      {"translation_mm", list_of(Eigen::Vector3d::Zero())}};
  body.frame = frame_at(document.root, key);
}

// Assigns the triangles of the moving object to compartments.

namespace {

std::vector<std::string> contact_names(const Body& moving)
{
  std::vector<std::string> names;
  for (std::size_t c = 0; c < moving.components.size(); ++c) {
    const auto& of_triangle = moving.contact.component;
    const bool has_triangles =
        std::find(of_triangle.begin(), of_triangle.end(), static_cast<std::int32_t>(c)) != of_triangle.end();
    if (has_triangles) names.push_back(moving.components[c].name);
  }
  return names;
}

using Assignment = std::vector<Compartment>;  // [n components] compartment of each, by name

Assignment with_named(Assignment assigned, const Job& job, const Body& moving, Compartment which)
{
  const std::string key = std::string("compartments.") + name_of(which) + ".components";
  const std::vector<std::string> known = contact_names(moving);
  const auto refuse = [&](const std::string& found, const std::string& wanted) {
    throw InputError({job.document.source_of(key), key, found, wanted});
  };
  for (const std::string& name : (*job.compartments)[which].components) {
    if (std::find(known.begin(), known.end(), name) == known.end()) {
      refuse("\"" + name + "\"",
             "a moving contact component; the nearest is \"" + nearest_word(name, known) + "\"");
    }
    std::size_t c = 0;
    while (moving.components[c].name != name) ++c;
    if (assigned[c] != Compartment::none)
      refuse("\"" + name + "\" a second time", "each component in one compartment");
    assigned[c] = which;
  }
  return assigned;
}

Assignment assigned_by_name(const Job& job, const Body& moving)
{
  const Assignment none(moving.components.size(), Compartment::none);
  return with_named(with_named(none, job, moving, Compartment::medial), job, moving, Compartment::lateral);
}

bool is_in(const std::string& half_space, double z_mm, double centre_z_mm)
{
  return (half_space == "left" && z_mm < centre_z_mm) || (half_space == "right" && z_mm > centre_z_mm);
}

}  // namespace

std::vector<Compartment> compartments_of(const Job& job, const Body& moving, double centre_z_mm)
{
  if (!job.compartments) return {};
  const std::string& half_space = (*job.compartments)[0].half_space;
  if (!half_space.empty() && half_space == (*job.compartments)[1].half_space) {
    throw InputError({job.document.source_of("compartments"), "compartments",
                      "medial and lateral both \"" + half_space + "\"", "one half-space each"});
  }
  const Assignment assigned = assigned_by_name(job, moving);
  const Mesh& mesh = moving.contact.mesh;
  std::vector<Compartment> out;
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    const auto [a, b, c] = corners(mesh, t);
    const double z_mm = (a.z() + b.z() + c.z()) / 3.0;
    Compartment compartment =
        assigned[static_cast<std::size_t>(moving.contact.component[static_cast<std::size_t>(t)])];
    for (const Compartment side : all_compartments)
      if (compartment == Compartment::none && is_in((*job.compartments)[side].half_space, z_mm, centre_z_mm))
        compartment = side;
    out.push_back(compartment);
  }
  return out;
}

Box box_of(const Body& body)
{
  // Either part may be empty, not both.
  const Mesh& contact = body.contact.mesh;
  const Mesh& visual = body.visual.mesh;
  if (visual.vertices_mm.rows() == 0) return bounding_box(contact);
  if (contact.vertices_mm.rows() == 0) return bounding_box(visual);
  const Box a = bounding_box(contact), b = bounding_box(visual);
  return {a.min_mm.cwiseMin(b.min_mm), a.max_mm.cwiseMax(b.max_mm)};
}

// The start of a joint whose job gives none.

namespace {

// Ahead of the first contact: far more than rounding, less than the space of any joint.
constexpr double start_clearance_mm = 0.1;
// Of the retreat from an overlap; doubled until the objects are apart or farther than any two bones.
constexpr double first_retreat_mm = 0.1;
constexpr double last_retreat_mm = 1000.0;

}  // namespace

double start_travel_mm(const Case& loaded)
{
  SolverFrame frame = loaded.frame;
  frame.delta = loaded.push_at_meshes.delta;
  const geometry::TreeMesh reference =
      geometry::make_tree_mesh(solver_mesh(loaded.reference.contact.mesh, frame));
  const geometry::TreeMesh moving = geometry::make_tree_mesh(solver_mesh(loaded.moving.contact.mesh, frame));
  contact::NarrowPhase narrow_phase;
  MovingPose pose;
  pose.theta_rad = loaded.initial.theta_rad;
  for (double retreat_mm = first_retreat_mm; contact::find_collision(reference, moving, pose, narrow_phase);
       retreat_mm *= 2.0) {
    if (retreat_mm > last_retreat_mm) return 0.0;
    pose.translation_mm.y() = -retreat_mm;
  }
  geometry::GapQuery query(geometry::GapTree(reference.mesh), geometry::GapTree(moving.mesh));
  const double travel_mm = query.next_contact(pose).travel_mm;
  if (!std::isfinite(travel_mm)) return 0.0;
  return pose.translation_mm.y() + travel_mm - start_clearance_mm;
}

}  // namespace vrda::job
