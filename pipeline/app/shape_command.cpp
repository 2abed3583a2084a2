#include "app/shape_command.hpp"

#include <charconv>
#include <cstdio>
#include <filesystem>

#include "convert/mesh_writer.hpp"
#include "core/error.hpp"
#include "core/whole_file.hpp"
#include "run/output_file.hpp"
#include "shapes/shapes.hpp"

namespace vrda {
namespace {

namespace fs = std::filesystem;

ShapeRequest request_of(const ShapeOptions& options)
{
  ShapeRequest request;
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

}  // namespace

ExitCode shape_command(const ShapeOptions& options)
{
  const ShapeRequest request = request_of(options);
  // A shape without ligaments is refused before anything is written.
  const std::string table = options.has_ligaments ? fibre_table(request) : "";
  const Shape shape = generate_shape(request);
  make_folder(options.folder);
  for (const std::vector<ShapePart>* parts : {&shape.reference, &shape.moving}) {
    for (const ShapePart& part : *parts) {
      const fs::path path = fs::path(options.folder) / (part.name + ".stl");
      write_whole(path.string(), {stl_bytes(part.mesh, "vrda shape, mm")});
      std::printf("%s\n", path.c_str());
      say(part.name + ": " + std::to_string(part.mesh.triangles.rows()) + " triangles, " + part.material +
          (part.has_contact ? "" : ", drawn only"));
    }
  }
  if (options.has_ligaments) {
    const fs::path path = fs::path(options.folder) / "ligaments.csv";
    write_whole(path.string(), {table});
    std::printf("%s\n", path.c_str());
    say("ligaments: " + std::to_string(generate_fibres(request).size()) + " fibres");
  }
  return ExitCode::done;
}

std::string shape_help()
{
  std::string text = "Shapes and their parameters (name=value):\n";
  for (const std::string& shape : shape_names()) {
    text += "  " + shape + ": " + shape_summary(shape) + '\n';
    for (const ShapeParameter& p : shape_parameters(shape)) {
      char line[160];
      if (p.choices.empty()) {
        std::snprintf(line, sizeof line, "    %-18s %g %s (%g to %g)", p.name.c_str(), p.default_number,
                      p.unit.c_str(), p.lowest, p.highest);
      } else {
        std::snprintf(line, sizeof line, "    %-18s %s", p.name.c_str(), p.choices.front().c_str());
      }
      text += std::string(line) + ": " + p.meaning + '\n';
    }
  }
  return text;
}

}  // namespace vrda
