#include "job/clean_mesh.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "job/shells.hpp"

namespace vrda::job {
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

using Triangle = std::array<std::int32_t, 3>;

bool has_area(const Points& vertices, const Triangle& t)
{
  const Eigen::Vector3d a = vertices.row(t[0]), b = vertices.row(t[1]), c = vertices.row(t[2]);
  return (b - a).cross(c - a).squaredNorm() > 0.0;
}

// Polygons by their corners from the smallest on, in the direction of its smaller neighbour; with the
// triangles of the first one. A copy must not be divided along other diagonals.
class Polygons {
 public:
  const std::vector<Triangle>& triangles_of(const std::vector<std::int32_t>& face, const Points& vertices)
  {
    std::vector<std::int32_t> key = face;
    std::rotate(key.begin(), std::min_element(key.begin(), key.end()), key.end());
    const bool is_reversed = key.back() < key[1];
    if (is_reversed) std::reverse(key.begin() + 1, key.end());
    const auto [at, is_new] = first_.try_emplace(std::move(key), First{is_reversed, {}});
    if (is_new) at->second.triangles = triangulated(face, vertices);
    triangles_ = at->second.triangles;
    if (at->second.is_reversed == is_reversed) return triangles_;
    for (Triangle& triangle : triangles_) std::swap(triangle[1], triangle[2]);
    return triangles_;
  }

  static std::vector<Triangle> triangulated(const std::vector<std::int32_t>& face, const Points& vertices)
  {
    Points corners(static_cast<Eigen::Index>(face.size()), 3);
    for (std::size_t k = 0; k < face.size(); ++k)
      corners.row(static_cast<Eigen::Index>(k)) = vertices.row(face[k]);
    std::vector<Triangle> triangles = triangulate(corners);
    for (Triangle& triangle : triangles) {
      for (std::int32_t& corner : triangle) corner = face[static_cast<std::size_t>(corner)];
    }
    return triangles;
  }

 private:
  struct First {
    bool is_reversed = false;
    std::vector<Triangle> triangles;
  };
  std::map<std::vector<std::int32_t>, First> first_;
  std::vector<Triangle> triangles_;
};

std::vector<Triangle> triangles_of(const RawMesh& raw, const WeldedVertices& merged,
                                   Eigen::Index& n_degenerate)
{
  std::vector<Triangle> kept;
  Polygons polygons;
  std::size_t first = 0;
  for (const std::int32_t size : raw.size) {
    const std::vector<std::int32_t> face =
        distinct_corners(merged.index_of_raw, raw.corner.data() + first, size);
    first += static_cast<std::size_t>(size);
    const std::size_t n_before = kept.size();
    const auto keep = [&](const std::vector<Triangle>& triangles) {
      for (const Triangle& triangle : triangles) {
        if (has_area(merged.vertices, triangle)) kept.push_back(triangle);
      }
    };
    if (face.size() == 3) keep(Polygons::triangulated(face, merged.vertices));
    if (face.size() > 3) keep(polygons.triangles_of(face, merged.vertices));
    // A polygon of n corners has n - 2 triangles. If none is kept, one degenerate face is counted.
    if (kept.size() == n_before)
      ++n_degenerate;
    else
      n_degenerate += static_cast<Eigen::Index>(face.size() - 2 - (kept.size() - n_before));
  }
  return kept;
}

Triangles matrix_of(const std::vector<Triangle>& triangles)
{
  Triangles matrix(static_cast<Eigen::Index>(triangles.size()), 3);
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k)
      matrix(static_cast<Eigen::Index>(t), static_cast<Eigen::Index>(k)) = triangles[t][k];
  }
  return matrix;
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

// Reverses shells to point outward and lists the small ones.
void survey_shells(CleanMesh& out, Mesh& mesh, Winding winding)
{
  const std::vector<Shell> shells = shells_of(mesh);
  const std::vector<std::size_t> outermost = outermost_shells(mesh, shells);
  out.small_shells = small_shells(shells, outermost);
  for (std::size_t s = 0; s < shells.size(); ++s) {
    const Shell& shell = shells[s];
    if (!shell.has_inside) out.has_sheet = true;
    const bool is_reversed =
        shell.has_inside ? shells[outermost[s]].signed_volume < 0.0 : winding == Winding::inward;
    if (!is_reversed) continue;
    out.was_flipped = true;
    for (const Eigen::Index t : shell.triangles) std::swap(mesh.triangles(t, 1), mesh.triangles(t, 2));
  }
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
  const std::vector<Triangle> all = triangles_of(raw, merged, out.n_degenerate);
  const std::vector<Triangle> each_once = without_copies(all);
  out.n_identical = static_cast<Eigen::Index>(all.size() - each_once.size());
  mesh.triangles = matrix_of(each_once);
  mesh.vertices_mm = std::move(merged.vertices);
  mesh.normals = std::move(merged.normal_sums);
  survey_shells(out, mesh, winding);
  out.mesh = renumbered(mesh, side);
  out.mesh.normals = outward_normals(out.mesh);
  return out;
}

}  // namespace vrda::job
