#include "job/mesh_text.hpp"

#include <cstring>
#include <numeric>
#include <sstream>

namespace vrda::test {
namespace {

template <class Value>
void put(std::string& bytes, Value value)
{
  char buffer[sizeof(Value)];
  std::memcpy(buffer, &value, sizeof(Value));
  bytes.append(buffer, sizeof(Value));
}

void put_point(std::string& bytes, const Eigen::Vector3d& p)
{
  for (int k = 0; k < 3; ++k) put(bytes, static_cast<float>(p[k]));
}

std::ostringstream stream()
{
  std::ostringstream out;
  out.precision(9);  // enough for any float
  return out;
}

}  // namespace

std::string binary_stl(const Mesh& mesh)
{
  std::string bytes(80, ' ');
  put(bytes, static_cast<std::uint32_t>(mesh.triangles.rows()));
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    put_point(bytes, face_normal(mesh, t));
    for (const Eigen::Vector3d& corner : corners(mesh, t)) put_point(bytes, corner);
    put(bytes, std::uint16_t{0});
  }
  return bytes;
}

std::string ascii_stl(const Mesh& mesh)
{
  std::ostringstream out = stream();
  out << "solid made by code\n";
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    out << "facet normal " << face_normal(mesh, t).transpose() << "\n outer loop\n";
    for (const Eigen::Vector3d& corner : corners(mesh, t)) out << "  vertex " << corner.transpose() << "\n";
    out << " endloop\nendfacet\n";
  }
  out << "endsolid made by code\n";
  return out.str();
}

std::string ascii_ply(const Mesh& mesh, bool with_normals)
{
  std::ostringstream out = stream();
  out << "ply\nformat ascii 1.0\nelement vertex " << mesh.vertices_mm.rows()
      << "\nproperty float x\nproperty float y\nproperty float z\n";
  if (with_normals) out << "property float nx\nproperty float ny\nproperty float nz\n";
  out << "element face " << mesh.triangles.rows() << "\nproperty list uchar int vertex_indices\nend_header\n";
  for (Eigen::Index v = 0; v < mesh.vertices_mm.rows(); ++v) {
    out << mesh.vertices_mm.row(v);
    if (with_normals) out << " " << mesh.normals.row(v);
    out << "\n";
  }
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) out << "3 " << mesh.triangles.row(t) << "\n";
  return out.str();
}

std::string binary_ply(const Mesh& mesh)
{
  std::ostringstream header;
  header << "ply\nformat binary_little_endian 1.0\nelement vertex " << mesh.vertices_mm.rows()
         << "\nproperty float x\nproperty float y\nproperty float z\nelement face " << mesh.triangles.rows()
         << "\nproperty list uchar int vertex_indices\nend_header\n";
  std::string bytes = header.str();
  for (Eigen::Index v = 0; v < mesh.vertices_mm.rows(); ++v) put_point(bytes, mesh.vertices_mm.row(v));
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    put(bytes, std::uint8_t{3});
    for (int k = 0; k < 3; ++k) put(bytes, mesh.triangles(t, k));
  }
  return bytes;
}

std::string wavefront(const Mesh& mesh)
{
  std::ostringstream out = stream();
  out << "# made by code\nmtllib nowhere.mtl\n";
  for (Eigen::Index v = 0; v < mesh.vertices_mm.rows(); ++v) out << "v " << mesh.vertices_mm.row(v) << "\n";
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t)
    out << "f " << (mesh.triangles.row(t).array() + 1) << "\n";
  return out.str();
}

std::string vertices_faces(const Mesh& mesh, int first_index)
{
  std::ostringstream out = stream();
  out << mesh.vertices_mm.rows() << " " << mesh.triangles.rows() << "\n";
  for (Eigen::Index v = 0; v < mesh.vertices_mm.rows(); ++v) out << mesh.vertices_mm.row(v) << "\n";
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    out << "3 " << (mesh.triangles.row(t).array() + first_index) << "\n";
  }
  return out.str();
}

std::string small_job(const std::string& head, const std::string& tail)
{
  return head + R"(
[[reference.component]]
name = "upper"
file = "reference.stl"

[[moving.component]]
name = "lower"
file = "moving.stl"
)" + tail;
}

job::RawMesh raw_of(const Mesh& mesh)
{
  job::RawMesh raw;
  raw.vertices = mesh.vertices_mm;
  raw.corner.assign(mesh.triangles.data(), mesh.triangles.data() + mesh.triangles.size());
  raw.size.assign(static_cast<std::size_t>(mesh.triangles.rows()), 3);
  return raw;
}

job::RawMesh soup_of(const Mesh& mesh)
{
  job::RawMesh raw = raw_of(mesh);
  raw.vertices = mesh.vertices_mm(raw.corner, Eigen::all);
  std::iota(raw.corner.begin(), raw.corner.end(), 0);
  return raw;
}

JobFolder::JobFolder(const std::string& text, const Mesh& reference, const Mesh& moving)
{
  scratch.write("reference.stl", binary_stl(reference));
  scratch.write("moving.stl", binary_stl(moving));
  job = scratch.write("job.toml", text).string();
}

job::Case JobFolder::load(const std::vector<std::string>& overrides) const
{
  return job::load_case(job, {"", overrides});
}

InputError::Facts JobFolder::refused(const std::vector<std::string>& overrides) const
{
  return input_error([&] { load(overrides); });
}

}  // namespace vrda::test
