#include "load/clean_mesh.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "load/shells.hpp"

namespace vrda::load {
namespace {

// The corners of a face after welding, without consecutive duplicates.
std::vector<std::int32_t> distinct_corners(const std::vector<std::int32_t>& of_raw,
                                           const std::int32_t* corner, std::int32_t n)
{
  std::vector<std::int32_t> corners;
  for (std::int32_t k = 0; k < n; ++k) {
    const std::int32_t v = of_raw[static_cast<std::size_t>(corner[k])];
    if (corners.empty() || corners.back() != v) corners.push_back(v);
  }
  while (corners.size() > 1 && corners.front() == corners.back()) corners.pop_back();
  return corners;
}

bool has_area(const Points& vertices, const std::array<std::int32_t, 3>& t)
{
  const Eigen::Vector3d a = vertices.row(t[0]), b = vertices.row(t[1]), c = vertices.row(t[2]);
  return (b - a).cross(c - a).squaredNorm() > 0.0;
}

Triangles triangles_of(const RawMesh& raw, const WeldedVertices& merged, Eigen::Index& n_degenerate)
{
  std::vector<std::array<std::int32_t, 3>> kept;
  std::size_t first = 0;
  for (const std::int32_t size : raw.size) {
    const std::vector<std::int32_t> face =
        distinct_corners(merged.index_of_raw, raw.corner.data() + first, size);
    first += static_cast<std::size_t>(size);
    const std::size_t n_before = kept.size();
    if (face.size() >= 3) {
      Points corners_mm(static_cast<Eigen::Index>(face.size()), 3);
      for (std::size_t k = 0; k < face.size(); ++k)
        corners_mm.row(static_cast<Eigen::Index>(k)) = merged.vertices.row(face[k]);
      for (const std::array<std::int32_t, 3>& t : triangulate(corners_mm)) {
        const std::array<std::int32_t, 3> triangle{face[static_cast<std::size_t>(t[0])],
                                                   face[static_cast<std::size_t>(t[1])],
                                                   face[static_cast<std::size_t>(t[2])]};
        if (has_area(merged.vertices, triangle)) kept.push_back(triangle);
      }
    }
    // A polygon of n corners has n - 2 triangles. If none is kept, one degenerate face is counted.
    if (kept.size() == n_before)
      ++n_degenerate;
    else
      n_degenerate += static_cast<Eigen::Index>(face.size() - 2 - (kept.size() - n_before));
  }
  Triangles triangles(static_cast<Eigen::Index>(kept.size()), 3);
  for (std::size_t t = 0; t < kept.size(); ++t) {
    for (int k = 0; k < 3; ++k)
      triangles(static_cast<Eigen::Index>(t), k) = kept[t][static_cast<std::size_t>(k)];
  }
  return triangles;
}

// Vertices in the order of first use; unused vertices are removed.
Mesh renumbered(const Mesh& mesh, Side side)
{
  constexpr std::int32_t unused = -1;
  std::vector<std::int32_t> place(static_cast<std::size_t>(mesh.vertices_mm.rows()), unused);
  const std::array<int, 3> corner_order = side == Side::right ? std::array{0, 1, 2} : std::array{0, 2, 1};
  Mesh out = mesh;
  std::int32_t n_used = 0;
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    for (const int k : corner_order) {
      const std::int32_t from = mesh.triangles(t, k);
      std::int32_t& to = place[static_cast<std::size_t>(from)];
      if (to == unused) {
        to = n_used++;
        out.vertices_mm.row(to) = mesh.vertices_mm.row(from);
        if (mesh.normals.rows() > 0) out.normals.row(to) = mesh.normals.row(from);
      }
      out.triangles(t, k) = to;
    }
  }
  out.vertices_mm.conservativeResize(n_used, 3);
  if (mesh.normals.rows() > 0) out.normals.conservativeResize(n_used, 3);
  return out;
}

// Reverses shells to point outward. Returns whether any was reversed.
bool turn_outward(Mesh& mesh, Winding winding)
{
  const std::vector<Shell> shells = shells_of(mesh);
  const std::vector<bool> is_inward = inward_shells(mesh, shells);
  bool was_flipped = false;
  for (std::size_t s = 0; s < shells.size(); ++s) {
    const bool is_reversed = shells[s].is_closed ? is_inward[s] : winding == Winding::inward;
    if (!is_reversed) continue;
    was_flipped = true;
    for (const Eigen::Index t : shells[s].triangles) std::swap(mesh.triangles(t, 1), mesh.triangles(t, 2));
  }
  return was_flipped;
}

// The file's normals as outward unit vectors; computed normals if any of the file's is zero or not finite.
Points outward_normals(const Mesh& mesh)
{
  Points computed = vertex_normals(mesh);
  Points normals = mesh.normals;
  for (Eigen::Index v = 0; v < normals.rows(); ++v) {
    const double length = normals.row(v).norm();
    if (!std::isfinite(length) || length == 0.0) return computed;
    normals.row(v) /= normals.row(v).dot(computed.row(v)) < 0.0 ? -length : length;
  }
  return normals.rows() == 0 ? computed : normals;
}

}  // namespace

CleanMesh clean_mesh(const RawMesh& raw, Winding winding, Side side)
{
  CleanMesh out;
  WeldedVertices merged = weld_vertices(raw);
  out.n_welded = raw.vertices.rows() - merged.vertices.rows();
  Mesh mesh;
  mesh.triangles = triangles_of(raw, merged, out.n_degenerate);
  mesh.vertices_mm = std::move(merged.vertices);
  mesh.normals = std::move(merged.normal_sums);
  out.was_flipped = turn_outward(mesh, winding);
  out.mesh = renumbered(mesh, side);
  out.mesh.normals = outward_normals(out.mesh);
  return out;
}

}  // namespace vrda::load
