// `vrda convert` and `vrda shape`: files of the thesis into meshes and jobs; generated shapes into mesh
// files.
#include <algorithm>
#include <charconv>
#include <cstdio>
#include <filesystem>

#include "app/commands.hpp"
#include "core/text.hpp"
#include "geometry/shapes.hpp"
#include "job/clean_mesh.hpp"
#include "job/component_loader.hpp"
#include "job/job.hpp"
#include "job/thesis_files.hpp"
#include "run/run_output.hpp"

namespace vrda::app {
namespace {

namespace fs = std::filesystem;

/// `vrda convert`: converts the thesis's formats to VRDA's, and mesh files between formats.
struct ConvertObjectOptions {
  std::string prefix;  ///< PREFIX.coor, PREFIX.norm, PREFIX.elem
  std::string folder;
};

struct ConvertMeshOptions {
  std::string input;
  std::string output;
};

struct ConvertConfigOptions {
  std::string file;
  std::string output;
  std::string unit = "m";  ///< unit of the meshes and of all lengths in the file: m, cm or mm
};

/// `vrda shape`: writes a generated joint as STL files and its ligaments as a CSV table.
struct ShapeOptions {
  std::string shape;
  std::string folder;
  std::vector<std::string> parameters;  ///< "name=value"
  bool has_ligaments = false;           ///< write ligaments.csv too
};

struct TableRow {
  std::string name;
  std::size_t n_polygons = 0;
  Eigen::Index n_triangles = 0;
};

// The columns of thesis 5.2.
void print_table(const std::vector<TableRow>& rows)
{
  const std::string head = "Components";
  std::size_t width = head.size();
  for (const TableRow& row : rows) width = std::max(width, row.name.size());
  const int name_width = static_cast<int>(width);
  std::printf("%-*s  %9s  %9s\n", name_width, head.c_str(), "Polygons", "Triangles");
  for (const TableRow& row : rows) {
    std::printf("%-*s  %9zu  %9ld\n", name_width, row.name.c_str(), row.n_polygons,
                static_cast<long>(row.n_triangles));
  }
}

/// The paths and contents of a result's files; the first is its main file.
using ResultFiles = std::vector<std::pair<std::string, std::string>>;

core::ExitCode publish(const std::string& folder, const std::string& command, const ResultFiles& files)
{
  check(!files.empty(), "a result has a file");
  run::make_folder(folder);
  std::optional<Publication> result = run::begin_result(files.front().first, command);
  if (!result) return core::ExitCode::interrupted;
  for (std::size_t k = 1; k < files.size(); ++k) result->add(files[k].first, files[k].second);
  result->publish(files.front().second);
  return core::ExitCode::done;
}

TableRow counted_component(const job::ObjectComponent& component, const std::string& stem)
{
  const job::CleanMesh clean = job::clean_mesh(component.mesh, job::Winding::outward, Side::right);
  core::log_info(stem + ".obj, " + stem + ".normals: " + std::to_string(component.mesh.vertices.rows()) +
                 " vertices");
  if (clean.n_degenerate > 0) {
    core::log_warning(component.name + ": " + std::to_string(clean.n_degenerate) +
                      " faces or triangles without area are not counted as triangles");
  }
  if (clean.n_identical > 0) {
    core::log_warning(component.name + ": " + std::to_string(clean.n_identical) +
                      " identical triangles are counted once");
  }
  return {component.name, component.mesh.size.size(), clean.mesh.triangles.rows()};
}

// The folder `models` of the thesis's layout: next to the configuration, or next to its folder.
fs::path models_folder(const fs::path& configuration)
{
  const fs::path folder = fs::absolute(configuration).lexically_normal().parent_path();
  const fs::path beside = folder / "models", above = folder.parent_path() / "models";
  return !fs::exists(beside) && fs::is_directory(above) ? above : beside;
}

void warn_of_missing_models(const job::KeywordConfiguration& configuration, const fs::path& models)
{
  for (const std::vector<std::string>* names : {&configuration.reference, &configuration.moving}) {
    for (const std::string& name : *names) {
      const fs::path file = models / (name + ".obj");
      if (!fs::exists(file)) core::log_warning("missing file \"" + file.string() + "\", which the job needs");
    }
  }
}

core::ExitCode convert_object_command(const ConvertObjectOptions& options)
{
  const std::vector<job::ObjectComponent> components =
      job::parse_object_set(job::read_object_set(options.prefix));
  const auto stem_of = [&](const job::ObjectComponent& component) {
    return (fs::path(options.folder) / component.name).string();
  };
  ResultFiles files;
  for (const job::ObjectComponent& component : components) {
    const std::string stem = stem_of(component);
    files.emplace_back(stem + ".obj", job::vertices_faces_bytes(component.mesh));
    files.emplace_back(stem + ".normals", job::vertex_normals_bytes(component.mesh));
  }
  const core::ExitCode code = publish(options.folder, "vrda convert", files);
  std::vector<TableRow> rows;
  for (const job::ObjectComponent& component : components)
    rows.push_back(counted_component(component, stem_of(component)));
  print_table(rows);
  return code;
}

core::ExitCode convert_mesh_command(const ConvertMeshOptions& options)
{
  std::error_code no_such_file;
  if (fs::equivalent(options.input, options.output, no_such_file))
    throw InputError({options.output, "output", "the input file", "another file"});
  std::string bytes =
      job::file_bytes(options.input, {options.input, "", "", "a mesh file"}, job::largest_mesh_bytes);
  const job::RawMesh raw = job::read_mesh(options.input, std::move(bytes));
  const job::RawMesh mesh = job::merge_equal_vertices(raw);
  const core::ExitCode code =
      run::publish(options.output, "vrda convert", job::mesh_bytes(options.output, mesh));
  for (const std::string& note : raw.notes) core::log_warning(options.input + ": " + note);
  std::printf("%s\n", options.output.c_str());
  core::log_info(std::to_string(mesh.vertices.rows()) + " vertices, " + std::to_string(mesh.size.size()) +
                 " faces");
  return code;
}

core::ExitCode convert_config_command(const ConvertConfigOptions& options)
{
  run::require_plain_text("file", options.file);
  const job::NamedText source = job::read_configuration(options.file);
  const job::KeywordConfiguration configuration =
      job::parse_configuration(source, job::mm_per_unit(options.unit));
  const fs::path models = models_folder(options.file);
  std::error_code no_such_file;
  if (fs::equivalent(options.file, options.output, no_such_file))
    throw InputError({options.output, "output", "the configuration file", "another file"});
  const fs::path job_folder = fs::absolute(options.output).lexically_normal().parent_path();
  const fs::path file = options.file;
  const std::string text =
      job::job_text(configuration, {file.stem().string(), file.filename().string(),
                                    models.lexically_relative(job_folder).generic_string(), options.unit});
  job::checked_job(
      {options.output, core::parse_toml(text, options.output), {}});  // a name may be invalid UTF-8
  const core::ExitCode code = run::publish(options.output, "vrda convert", text);
  std::printf("%s\n", options.output.c_str());
  warn_of_missing_models(configuration, models);
  return code;
}

geometry::ShapeRequest request_of(const ShapeOptions& options)
{
  geometry::ShapeRequest request;
  request.shape = options.shape;
  for (const std::string& parameter : options.parameters) {
    const std::size_t equals = parameter.find('=');
    if (equals == std::string::npos) {
      throw InputError({"vrda shape " + options.shape, "", parameter, "name=value"});
    }
    const std::string name = parameter.substr(0, equals), value = parameter.substr(equals + 1);
    double number = 0.0;
    const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), number);
    if (error == std::errc() && end == value.data() + value.size()) {
      request.numbers[name] = number;
    } else {
      request.words[name] = value;
    }
  }
  return request;
}

core::ExitCode shape_command(const ShapeOptions& options)
{
  const geometry::ShapeRequest request = request_of(options);
  // A shape without ligaments is refused before anything is written.
  const std::string table = options.has_ligaments ? geometry::fibre_table(request) : "";
  const geometry::Shape shape = geometry::generate_shape(request);
  ResultFiles files;
  std::vector<std::string> remarks;
  for (const std::vector<geometry::ShapePart>* parts : {&shape.reference, &shape.moving, &shape.followers}) {
    for (const geometry::ShapePart& part : *parts) {
      files.emplace_back((fs::path(options.folder) / (part.name + ".stl")).string(),
                         job::stl_bytes(part.mesh, "vrda shape, mm"));
      remarks.push_back(part.name + ": " + std::to_string(part.mesh.triangles.rows()) + " triangles, " +
                        part.material + (part.has_contact ? "" : ", drawn only"));
    }
  }
  if (options.has_ligaments) {
    files.emplace_back((fs::path(options.folder) / "ligaments.csv").string(), table);
    remarks.push_back("ligaments: " + std::to_string(geometry::generate_fibres(request).size()) + " fibres");
    if (!shape.followers.empty()) {
      const geometry::FollowerTexts texts = geometry::follower_texts(request);
      const std::string& name = shape.followers.front().name;
      files.emplace_back((fs::path(options.folder) / (name + "_fibres.csv")).string(), texts.fibres);
      files.emplace_back((fs::path(options.folder) / (name + "_wraps.json")).string(), texts.wraps);
    }
  }
  const core::ExitCode code = publish(options.folder, "vrda shape", files);
  for (const auto& [path, bytes] : files) std::printf("%s\n", path.c_str());
  for (const std::string& remark : remarks) core::log_info(remark);
  return code;
}

std::string shape_help()
{
  std::string text = "Shapes and their parameters (name=value):\n";
  for (const std::string& shape : geometry::shape_names()) {
    text += "  " + shape + ": " + geometry::shape_summary(shape) + '\n';
    for (const geometry::ShapeParameter& p : geometry::shape_parameters(shape)) {
      const std::string value = p.choices.empty() ? printed("%g %s (%g to %g)", p.default_number,
                                                            p.unit.c_str(), p.lowest, p.highest)
                                                  : p.choices.front();
      text += printed("    %-18s %s: ", p.name.c_str(), value.c_str()) + p.meaning + '\n';
    }
  }
  return text;
}

}  // namespace

void declare_shape(Command& c)
{
  auto& o = c.options<ShapeOptions>();
  c.footer("Example:\n  vrda shape knee -o knee side=left resolution=2\n\n" + shape_help());
  c.option("shape", o.shape, "Name of the shape").required();
  c.option("parameters", o.parameters, "name=value");
  c.option("-o,--output", o.folder, "Output folder").required();
  c.flag("--ligaments", o.has_ligaments, "Also write ligaments.csv (knee)");
  c.runs([&o] { return shape_command(o); });
}

void declare_convert(Command& c)
{
  Command object = c.add("object",
                         "Split an Object set (PREFIX.coor, .norm, .elem) into one Vertices-Faces file per "
                         "component; print the counts of polygons and triangles.",
                         "vrda convert object knee -o models");
  auto& set = object.options<ConvertObjectOptions>();
  object.option("prefix", set.prefix, "Common path of the three files, without extension").required();
  object.option("-o,--output", set.folder, "Output folder").required();
  object.runs([&set] { return convert_object_command(set); });

  Command mesh = c.add("mesh", "Write a mesh in another format, selected by the extension.",
                       "vrda convert mesh femur.stl femur.vf");
  auto& file = mesh.options<ConvertMeshOptions>();
  mesh.option("input", file.input, "STL, PLY, OBJ (Wavefront or Vertices-Faces), VF, VTP or VTK").required();
  mesh.option("output", file.output, ".vf, .stl, .ply or .obj (Wavefront)").required();
  mesh.runs([&file] { return convert_mesh_command(file); });

  Command config = c.add("config", "Convert a keyword configuration (thesis, appendix B) to a job.",
                         "vrda convert config knee.cfg -o knee.toml");
  auto& words = config.options<ConvertConfigOptions>();
  config.model(words.file, "Configuration file");
  config.option("-o,--output", words.output, "Job file (TOML) to write").required();
  config.option("--unit", words.unit, "Unit of the configuration's lengths and of the meshes: m, cm or mm")
      .one_of({"m", "cm", "mm"})
      .shows_default();
  config.runs([&words] { return convert_config_command(words); });

  declare_convert_osim(c);
}

}  // namespace vrda::app
