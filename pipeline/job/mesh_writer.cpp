#include "job/mesh_writer.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>

#include "core/error.hpp"
#include "core/text.hpp"
#include "core/document.hpp"
#include "job/clean_mesh.hpp"

namespace vrda::job {
namespace {

std::string point_text(const Points& points, Eigen::Index row)
{
  return shortest_decimal(points(row, 0)) + ' ' + shortest_decimal(points(row, 1)) + ' ' +
         shortest_decimal(points(row, 2));
}

// Calls `act` with the number of corners of each face and a pointer to the first.
template <typename Act>
void for_each_face(const job::RawMesh& mesh, const Act& act)
{
  const std::int32_t* corner = mesh.corner.data();
  for (const std::int32_t n : mesh.size) {
    act(n, corner);
    corner += n;
  }
}

std::string counted_face(std::int32_t n, const std::int32_t* corner)
{
  std::string line = std::to_string(n);
  for (std::int32_t k = 0; k < n; ++k) line += ' ' + std::to_string(corner[k]);
  return line + '\n';
}

void put_vector(std::array<char, 50>& record, std::size_t slot, const Eigen::Vector3d& v)
{
  for (std::size_t k = 0; k < 3; ++k) {
    const auto value = static_cast<float>(v[static_cast<Eigen::Index>(k)]);
    std::memcpy(record.data() + 12 * slot + 4 * k, &value, sizeof value);
  }
}

Mesh triangle_mesh(const job::RawMesh& raw)
{
  std::vector<std::int32_t> corners;
  for_each_face(raw, [&](std::int32_t n, const std::int32_t* corner) {
    Points points(n, 3);
    for (std::int32_t k = 0; k < n; ++k) points.row(k) = raw.vertices.row(corner[k]);
    for (const std::array<std::int32_t, 3>& triangle : job::triangulate(points)) {
      for (const std::int32_t k : triangle) corners.push_back(corner[k]);
    }
  });
  Mesh mesh;
  mesh.vertices_mm = raw.vertices;
  mesh.triangles =
      Eigen::Map<const Triangles>(corners.data(), static_cast<Eigen::Index>(corners.size() / 3), 3);
  return mesh;
}

void check_single_precision(const std::string& file, const job::RawMesh& mesh)
{
  constexpr double largest = std::numeric_limits<float>::max();
  for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) {
    if (mesh.vertices.row(v).cwiseAbs().maxCoeff() <= largest) continue;
    throw InputError({file, "vertex " + std::to_string(v), "(" + point_text(mesh.vertices, v) + ")",
                      "coordinates within single precision, up to " + shortest_decimal(largest)});
  }
}

}  // namespace

std::string vertices_faces_bytes(const job::RawMesh& mesh)
{
  std::string bytes = std::to_string(mesh.vertices.rows()) + ' ' + std::to_string(mesh.size.size()) + '\n';
  for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) bytes += point_text(mesh.vertices, v) + '\n';
  for_each_face(mesh, [&](std::int32_t n, const std::int32_t* corner) { bytes += counted_face(n, corner); });
  return bytes;
}

std::string vertex_normals_bytes(const job::RawMesh& mesh)
{
  std::string bytes = std::to_string(mesh.normals.rows()) + '\n';
  for (Eigen::Index v = 0; v < mesh.normals.rows(); ++v) bytes += point_text(mesh.normals, v) + '\n';
  return bytes;
}

std::string wavefront_bytes(const job::RawMesh& mesh)
{
  const bool has_normals = mesh.normals.rows() > 0;
  std::string bytes;
  for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) bytes += "v " + point_text(mesh.vertices, v) + '\n';
  for (Eigen::Index v = 0; v < mesh.normals.rows(); ++v) bytes += "vn " + point_text(mesh.normals, v) + '\n';
  for_each_face(mesh, [&](std::int32_t n, const std::int32_t* corner) {
    bytes += 'f';
    for (std::int32_t k = 0; k < n; ++k) {
      const std::string index = std::to_string(corner[k] + 1);
      bytes += ' ' + index + (has_normals ? "//" + index : "");
    }
    bytes += '\n';
  });
  return bytes;
}

std::string ply_bytes(const job::RawMesh& mesh)
{
  constexpr std::int32_t largest_uchar = 255;
  const bool has_normals = mesh.normals.rows() > 0;
  const bool is_short =
      std::all_of(mesh.size.begin(), mesh.size.end(), [](std::int32_t n) { return n <= largest_uchar; });
  std::string bytes = "ply\nformat ascii 1.0\nelement vertex " + std::to_string(mesh.vertices.rows()) +
                      "\nproperty double x\nproperty double y\nproperty double z\n";
  if (has_normals) bytes += "property double nx\nproperty double ny\nproperty double nz\n";
  bytes += "element face " + std::to_string(mesh.size.size()) + "\nproperty list " +
           (is_short ? "uchar" : "int") + " int vertex_indices\nend_header\n";
  for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) {
    bytes += point_text(mesh.vertices, v) + (has_normals ? ' ' + point_text(mesh.normals, v) : "") + '\n';
  }
  for_each_face(mesh, [&](std::int32_t n, const std::int32_t* corner) { bytes += counted_face(n, corner); });
  return bytes;
}

// 80 bytes of header, a count, 50 bytes for each triangle; little-endian, like all supported machines.
std::string stl_bytes(const Mesh& mesh, const std::string& header)
{
  constexpr std::size_t header_bytes = 80;
  std::string bytes = header.substr(0, header_bytes);
  bytes.resize(header_bytes, '\0');
  const auto n = static_cast<std::uint32_t>(mesh.triangles.rows());
  bytes.append(reinterpret_cast<const char*>(&n), sizeof n);
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    std::array<char, 50> record{};
    put_vector(record, 0, face_normal(mesh, t));
    const auto corner = corners(mesh, t);
    for (std::size_t k = 0; k < 3; ++k) put_vector(record, k + 1, corner[k]);
    bytes.append(record.data(), record.size());
  }
  return bytes;
}

std::string mesh_bytes(const std::string& file, const job::RawMesh& mesh)
{
  const std::string extension = std::filesystem::path(file).extension().string();
  if (extension == ".vf") return vertices_faces_bytes(mesh);
  if (extension == ".obj") return wavefront_bytes(mesh);
  if (extension == ".ply") return ply_bytes(mesh);
  if (extension == ".stl") {
    check_single_precision(file, mesh);
    return stl_bytes(triangle_mesh(mesh), "vrda convert");
  }
  throw InputError({file, "", "the extension \"" + extension + "\"", "an output .vf, .stl, .ply or .obj"});
}

job::RawMesh merge_equal_vertices(const job::RawMesh& mesh)
{
  job::WeldedVertices welded = job::weld_vertices(mesh);
  job::RawMesh out;
  out.size = mesh.size;
  out.corner.reserve(mesh.corner.size());
  for (const std::int32_t corner : mesh.corner)
    out.corner.push_back(welded.index_of_raw[static_cast<std::size_t>(corner)]);
  out.vertices = std::move(welded.vertices);
  out.normals = std::move(welded.normal_sums);
  for (Eigen::Index v = 0; v < out.normals.rows(); ++v) {
    const double length = out.normals.row(v).norm();
    if (!std::isfinite(length) || length == 0.0) {
      out.normals.resize(0, 3);
      break;
    }
    out.normals.row(v) /= length;
  }
  return out;
}

}  // namespace vrda::job
