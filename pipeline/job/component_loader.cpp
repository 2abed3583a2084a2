#include "job/component_loader.hpp"

#include <cstring>
#include <filesystem>
#include <utility>

#include "core/error.hpp"
#include "core/text.hpp"
#include "job/input_file.hpp"
#include "job/job_schema.hpp"
#include "job/vf_file.hpp"

namespace vrda::job {
namespace {

const geometry::ShapePart* part_named(const geometry::Shape& shape, const std::string& name)
{
  for (const std::vector<geometry::ShapePart>* parts : {&shape.reference, &shape.moving}) {
    for (const geometry::ShapePart& part : *parts) {
      if (part.name == name) return &part;
    }
  }
  return nullptr;
}

std::vector<std::string> part_names(const geometry::Shape& shape)
{
  std::vector<std::string> names;
  for (const std::vector<geometry::ShapePart>* parts : {&shape.reference, &shape.moving}) {
    for (const geometry::ShapePart& part : *parts) names.push_back(part.name);
  }
  return names;
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

ComponentSurvey survey_of(const ComponentJob& component, const CleanMesh& clean, const std::string& source)
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
  out.survey = survey_of(component, out.clean, out.input.name);
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
  const geometry::ShapePart* part = part_named(shape, generate.part);
  if (part == nullptr) {
    const std::string key = component.key + ".generate.part";
    throw InputError({job_.document.source_of(key), key, "\"" + generate.part + "\"",
                      "a part of \"" + generate.shape + "\"; the nearest is \"" +
                          nearest_word(generate.part, part_names(shape)) + "\""});
  }
  input = {shape_request_text(generate) + " part=" + generate.part, sha256_of(bytes_of(part->mesh))};
  return clean_mesh(raw_of(part->mesh), component.winding, job_.side);
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
  for (const std::vector<geometry::ShapePart>* parts : {&shape.reference, &shape.moving}) {
    for (const geometry::ShapePart& part : *parts) n_generated_ += part.mesh.triangles.rows();
  }
  if (n_generated_ > most_generated) {
    job_.document.refuse(component.key + ".generate",
                         "generated shapes of " + std::to_string(n_generated_) + " triangles in all",
                         "at most " + std::to_string(most_generated));
  }
  return shapes_.emplace(request, std::move(shape)).first->second;
}

}  // namespace vrda::job
