#include "app/shape_command.hpp"

#include <array>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "core/error.hpp"
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

void put_vector(std::array<char, 50>& record, std::size_t slot, const Eigen::Vector3d& v)
{
  for (std::size_t k = 0; k < 3; ++k) {
    const auto value = static_cast<float>(v[static_cast<Eigen::Index>(k)]);
    std::memcpy(record.data() + 12 * slot + 4 * k, &value, sizeof value);
  }
}

// Binary STL: 80 bytes of header, a count, 50 bytes a triangle; little-endian like every machine this runs
// on.
void write_stl(const fs::path& path, const Mesh& mesh)
{
  std::ofstream file(path, std::ios::binary);
  std::array<char, 80> header{};
  std::memcpy(header.data(), "vrda shape, mm", 14);
  file.write(header.data(), header.size());
  const auto n = static_cast<std::uint32_t>(mesh.triangles.rows());
  file.write(reinterpret_cast<const char*>(&n), sizeof n);
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    std::array<char, 50> record{};
    put_vector(record, 0, face_normal(mesh, t));
    const auto corner = corners(mesh, t);
    for (std::size_t k = 0; k < 3; ++k) put_vector(record, k + 1, corner[k]);
    file.write(record.data(), record.size());
  }
  if (!file.flush())
    throw InputError({path.string(), "", "a file that cannot be written", "room and permission to write"});
}

}  // namespace

ExitCode shape_command(const ShapeOptions& options)
{
  const Shape shape = generate_shape(request_of(options));
  std::error_code error;
  fs::create_directories(options.folder, error);
  if (error) throw InputError({options.folder, "folder", error.message(), "a folder that can be written"});
  for (const std::vector<ShapePart>* parts : {&shape.reference, &shape.moving}) {
    for (const ShapePart& part : *parts) {
      const fs::path path = fs::path(options.folder) / (part.name + ".stl");
      write_stl(path, part.mesh);
      std::printf("%s\n", path.c_str());
      say(part.name + ": " + std::to_string(part.mesh.triangles.rows()) + " triangles, " + part.material +
          (part.has_contact ? "" : ", drawn only"));
    }
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
