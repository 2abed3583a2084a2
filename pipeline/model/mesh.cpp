#include "model/mesh.hpp"

#include <Eigen/Cholesky>

#include <algorithm>
#include <utility>

#include "core/bucket_sort.hpp"
#include "core/text.hpp"

namespace vrda::inline model {
namespace {

Eigen::Vector3d doubled_area_vector(const Mesh& mesh, Eigen::Index t)
{
  const auto [a, b, c] = corners(mesh, t);
  return (b - a).cross(c - a);
}

// An undirected edge with the direction in which a face traverses it.
struct EdgeUse {
  std::int32_t low = 0;
  std::int32_t high = 0;
  bool is_forward = true;
};

std::vector<EdgeUse> sorted_edge_uses(const Mesh& mesh)
{
  std::vector<EdgeUse> uses;
  uses.reserve(static_cast<std::size_t>(3 * mesh.triangles.rows()));
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const std::int32_t from = mesh.triangles(t, k);
      const std::int32_t to = mesh.triangles(t, (k + 1) % 3);
      uses.push_back({std::min(from, to), std::max(from, to), from < to});
    }
  }
  core::sort_by_row(
      uses, static_cast<std::size_t>(mesh.vertices_mm.rows()), [](const EdgeUse& use) { return use.low; },
      [](const EdgeUse& l, const EdgeUse& r) { return l.high < r.high; });
  return uses;
}

}  // namespace

std::array<Eigen::Vector3d, 3> corners(const Mesh& mesh, Eigen::Index t)
{
  return {Eigen::Vector3d(mesh.vertices_mm.row(mesh.triangles(t, 0))),
          Eigen::Vector3d(mesh.vertices_mm.row(mesh.triangles(t, 1))),
          Eigen::Vector3d(mesh.vertices_mm.row(mesh.triangles(t, 2)))};
}

Eigen::Vector3d face_normal(const Mesh& mesh, Eigen::Index t)
{
  const Eigen::Vector3d n = doubled_area_vector(mesh, t);
  const double length = n.norm();
  return length > 0.0 ? Eigen::Vector3d(n / length) : Eigen::Vector3d::Zero();
}

Points vertex_normals(const Mesh& mesh)
{
  Points normals = Points::Zero(mesh.vertices_mm.rows(), 3);
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    const Eigen::Vector3d n = doubled_area_vector(mesh, t);
    for (int k = 0; k < 3; ++k) normals.row(mesh.triangles(t, k)) += n.transpose();
  }
  for (Eigen::Index v = 0; v < normals.rows(); ++v) {
    const double length = normals.row(v).norm();
    if (length > 0.0) normals.row(v) /= length;
  }
  return normals;
}

double signed_volume_mm3(const Mesh& mesh)
{
  if (mesh.vertices_mm.rows() == 0) return 0.0;
  // Relative to a vertex of the mesh, so that a distant origin loses no digits.
  const Eigen::Vector3d origin = mesh.vertices_mm.row(0);
  double six_volumes = 0.0;
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    const auto [a, b, c] = corners(mesh, t);
    six_volumes += (a - origin).dot((b - origin).cross(c - origin));
  }
  return six_volumes / 6.0;
}

double area_mm2(const Mesh& mesh)
{
  double doubled = 0.0;
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) doubled += doubled_area_vector(mesh, t).norm();
  return 0.5 * doubled;
}

double mean_edge_length_mm(const Mesh& mesh)
{
  if (mesh.triangles.rows() == 0) return 0.0;
  double sum = 0.0;
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    const auto [a, b, c] = corners(mesh, t);
    sum += (b - a).norm() + (c - b).norm() + (a - c).norm();
  }
  return sum / static_cast<double>(3 * mesh.triangles.rows());
}

EdgeCounts edge_counts(const Mesh& mesh)
{
  const std::vector<EdgeUse> uses = sorted_edge_uses(mesh);
  EdgeCounts counts;
  for (std::size_t first = 0; first < uses.size();) {
    std::size_t last = first;
    int forward = 0;
    while (last < uses.size() && uses[last].low == uses[first].low && uses[last].high == uses[first].high) {
      forward += uses[last].is_forward ? 1 : 0;
      ++last;
    }
    const std::size_t n = last - first;
    if (n == 1) counts.boundary_vertex.push_back(uses[first].low);
    if (n > 2 || (n == 2 && forward != 1)) counts.non_manifold_vertex.push_back(uses[first].low);
    first = last;
  }
  counts.boundary = static_cast<Eigen::Index>(counts.boundary_vertex.size());
  counts.non_manifold = static_cast<Eigen::Index>(counts.non_manifold_vertex.size());
  return counts;
}

double largest_offset_mm(const Mesh& mesh)
{
  return mesh.offset_mm.empty() ? 0.0 : *std::max_element(mesh.offset_mm.begin(), mesh.offset_mm.end());
}

Box bounding_box(const Mesh& mesh)
{
  if (mesh.vertices_mm.rows() == 0) return {};
  return {Eigen::Vector3d(mesh.vertices_mm.colwise().minCoeff()),
          Eigen::Vector3d(mesh.vertices_mm.colwise().maxCoeff())};
}

Mesh transformed(const Mesh& mesh, const Pose& X_to_from)
{
  Mesh result = mesh;
  for (Eigen::Index v = 0; v < mesh.vertices_mm.rows(); ++v) {
    result.vertices_mm.row(v) = (X_to_from * Eigen::Vector3d(mesh.vertices_mm.row(v))).transpose();
  }
  for (Eigen::Index v = 0; v < mesh.normals.rows(); ++v) {
    result.normals.row(v) = (X_to_from.linear() * Eigen::Vector3d(mesh.normals.row(v))).transpose();
  }
  return result;
}

Mesh mirrored_z(const Mesh& mesh)
{
  Mesh result = mesh;
  for (auto row : result.vertices_mm.rowwise()) row[2] = -row[2];
  for (auto row : result.normals.rowwise()) row[2] = -row[2];
  for (auto row : result.triangles.rowwise()) std::swap(row[1], row[2]);
  return result;
}

void append(Mesh& mesh, const Mesh& extra)
{
  const Eigen::Index n_vertices = mesh.vertices_mm.rows();
  const Eigen::Index n_triangles = mesh.triangles.rows();
  const bool keeps_normals = (n_vertices == 0 || mesh.normals.rows() == n_vertices) &&
                             extra.normals.rows() == extra.vertices_mm.rows();
  mesh.vertices_mm.conservativeResize(n_vertices + extra.vertices_mm.rows(), 3);
  mesh.vertices_mm.bottomRows(extra.vertices_mm.rows()) = extra.vertices_mm;
  mesh.triangles.conservativeResize(n_triangles + extra.triangles.rows(), 3);
  mesh.triangles.bottomRows(extra.triangles.rows()) =
      extra.triangles.array() + static_cast<std::int32_t>(n_vertices);
  if (!mesh.offset_mm.empty() || !extra.offset_mm.empty()) {
    mesh.offset_mm.resize(static_cast<std::size_t>(n_triangles), 0.0);
    for (Eigen::Index t = 0; t < extra.triangles.rows(); ++t)
      mesh.offset_mm.push_back(vrda::offset_mm(extra, t));
  }
  if (!mesh.overlap_mm.empty() || !extra.overlap_mm.empty()) {
    mesh.overlap_mm.resize(static_cast<std::size_t>(n_triangles), 0.0);
    for (Eigen::Index t = 0; t < extra.triangles.rows(); ++t)
      mesh.overlap_mm.push_back(vrda::overlap_mm(extra, t));
  }
  if (!keeps_normals) {
    mesh.normals.resize(0, 3);
    return;
  }
  mesh.normals.conservativeResize(mesh.vertices_mm.rows(), 3);
  mesh.normals.bottomRows(extra.vertices_mm.rows()) = extra.normals;
}

Mesh select_triangles(const Mesh& mesh, const std::vector<Eigen::Index>& kept)
{
  Mesh result = mesh;
  result.triangles.resize(static_cast<Eigen::Index>(kept.size()), 3);
  for (std::size_t k = 0; k < kept.size(); ++k) {
    check(kept[k] >= 0 && kept[k] < mesh.triangles.rows(), "with_triangles: index out of range");
    result.triangles.row(static_cast<Eigen::Index>(k)) = mesh.triangles.row(kept[k]);
  }
  result.offset_mm.clear();
  result.overlap_mm.clear();
  for (const Eigen::Index t : kept) {
    if (!mesh.offset_mm.empty()) result.offset_mm.push_back(offset_mm(mesh, t));
    if (!mesh.overlap_mm.empty()) result.overlap_mm.push_back(overlap_mm(mesh, t));
  }
  return result;
}

namespace {

// Weight of the displacement along the vertex normal, which decides what the faces' planes leave open.
constexpr double tie_share = 1e-6;
constexpr double most_overlaps = 2.0;  // by which a vertex of a sharp edge moves

// Of each vertex, by which the planes of its faces move inward by their overlap.
Points inward_displacements(const Mesh& mesh)
{
  const auto n_vertices = static_cast<std::size_t>(mesh.vertices_mm.rows());
  const Points normals = vertex_normals(mesh);
  std::vector<Eigen::Matrix3d> A(n_vertices, Eigen::Matrix3d::Zero());
  std::vector<double> depth_mm(n_vertices, 0.0);
  Points moved = Points::Zero(mesh.vertices_mm.rows(), 3);
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    const Eigen::Vector3d area = doubled_area_vector(mesh, t);
    const double size = area.norm(), depth = overlap_mm(mesh, t);
    if (!(size > 0.0 && depth > 0.0)) continue;
    for (int k = 0; k < 3; ++k) {
      const auto v = static_cast<std::size_t>(mesh.triangles(t, k));
      A[v] += area * area.transpose() / size;
      moved.row(mesh.triangles(t, k)) -= depth * area.transpose();
      depth_mm[v] = std::max(depth_mm[v], depth);
    }
  }
  for (std::size_t v = 0; v < n_vertices; ++v) {
    if (depth_mm[v] == 0.0) continue;
    const auto row = static_cast<Eigen::Index>(v);
    const double tie = tie_share * A[v].trace();
    const Eigen::Vector3d along = -depth_mm[v] * normals.row(row).transpose();
    const Eigen::Vector3d wanted = moved.row(row).transpose() + tie * along;
    const Eigen::Vector3d d = (A[v] + tie * Eigen::Matrix3d::Identity()).ldlt().solve(wanted);
    moved.row(row) = d.transpose() * std::min(1.0, most_overlaps * depth_mm[v] / d.norm());
  }
  return moved;
}

}  // namespace

Mesh inward_limit(const Mesh& mesh)
{
  if (mesh.overlap_mm.empty()) return mesh;
  Mesh limit = mesh;
  limit.vertices_mm += inward_displacements(mesh);
  std::vector<bool> is_on_limit(static_cast<std::size_t>(mesh.vertices_mm.rows()), false);
  std::vector<Eigen::Index> turned_over;
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    if (overlap_mm(mesh, t) == 0.0) continue;
    const bool is_kept = doubled_area_vector(mesh, t).dot(doubled_area_vector(limit, t)) > 0.0;
    if (!is_kept) turned_over.push_back(t);
    for (int k = 0; k < 3 && is_kept; ++k) is_on_limit[static_cast<std::size_t>(mesh.triangles(t, k))] = true;
  }
  for (const Eigen::Index t : turned_over) {
    std::int32_t point = mesh.triangles(t, 0);
    for (const std::int32_t v : mesh.triangles.row(t))
      if (is_on_limit[static_cast<std::size_t>(v)]) point = v;
    limit.triangles.row(t).setConstant(point);
  }
  return limit;
}

std::vector<std::vector<Eigen::Index>> triangles_by_component(const Body& body, const Part& part)
{
  check(part.component.size() == static_cast<std::size_t>(part.mesh.triangles.rows()),
        "a part has one component index per triangle");
  std::vector<std::vector<Eigen::Index>> triangles(body.components.size());
  for (std::size_t t = 0; t < part.component.size(); ++t) {
    const auto component = static_cast<std::size_t>(part.component[t]);
    check(component < triangles.size(), "a triangle's component index is within its body");
    triangles[component].push_back(static_cast<Eigen::Index>(t));
  }
  return triangles;
}

Body mirrored_z(const Body& body)
{
  Body result = body;
  result.contact.mesh = mirrored_z(body.contact.mesh);
  result.visual.mesh = mirrored_z(body.visual.mesh);
  return result;
}

namespace {

/// At a vertex with more faces all are averaged, since the comparison is quadratic in their number.
constexpr std::size_t most_faces_compared = 1000;

struct Face {
  std::array<std::int32_t, 3> vertex{};
  Eigen::Vector3d normal;       ///< unit
  Eigen::Vector3d area_normal;  ///< length is twice the area
};

std::vector<Face> faces_of(const Mesh& mesh, const std::vector<Eigen::Index>& triangles)
{
  std::vector<Face> faces;
  faces.reserve(triangles.size());
  for (const Eigen::Index t : triangles) {
    const std::array<Eigen::Vector3d, 3> p = corners(mesh, t);
    const Eigen::Vector3d area_normal = (p[1] - p[0]).cross(p[2] - p[0]);
    const double length = area_normal.norm();
    if (!(length > 0.0)) continue;
    const Eigen::Vector3d normal = area_normal / length;
    faces.push_back(
        {{mesh.triangles(t, 0), mesh.triangles(t, 1), mesh.triangles(t, 2)}, normal, area_normal});
  }
  return faces;
}

/// Corner c of face f is 3 f + c; those at vertex v are corner[start[v]] to corner[start[v + 1] - 1].
struct Incidence {
  std::vector<std::size_t> start, corner;
};

Incidence incidence_of(const std::vector<Face>& faces, std::size_t n_vertices)
{
  Incidence around{std::vector<std::size_t>(n_vertices + 1, 0), std::vector<std::size_t>(3 * faces.size())};
  for (const Face& face : faces) {
    for (const std::int32_t v : face.vertex) ++around.start[static_cast<std::size_t>(v) + 1];
  }
  for (std::size_t v = 0; v < n_vertices; ++v) around.start[v + 1] += around.start[v];
  std::vector<std::size_t> next(around.start.begin(), around.start.end() - 1);
  for (std::size_t f = 0; f < faces.size(); ++f) {
    for (std::size_t c = 0; c < 3; ++c)
      around.corner[next[static_cast<std::size_t>(faces[f].vertex[c])]++] = 3 * f + c;
  }
  return around;
}

std::array<float, 3> single(const Eigen::Vector3d& v)
{
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

}  // namespace

RenderMesh make_render_mesh(const Mesh& mesh, const std::vector<Eigen::Index>& triangles,
                            const Eigen::Vector3d& origin_mm, double crease_rad)
{
  const std::vector<Face> faces = faces_of(mesh, triangles);
  const auto n_vertices = static_cast<std::size_t>(mesh.vertices_mm.rows());
  const Incidence around = incidence_of(faces, n_vertices);
  const double least_cosine = cosine(crease_rad);
  RenderMesh result;
  result.triangles.resize(3 * faces.size());
  for (std::size_t v = 0; v < n_vertices; ++v) {
    const std::size_t begin = around.start[v], end = around.start[v + 1];
    const std::size_t first_made = result.vertices.size();
    const Eigen::Vector3d p_mm = mesh.vertices_mm.row(static_cast<Eigen::Index>(v)).transpose() - origin_mm;
    for (std::size_t k = begin; k < end; ++k) {
      const Face& own = faces[around.corner[k] / 3];
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      for (std::size_t other = begin; other < end; ++other) {
        const Face& face = faces[around.corner[other] / 3];
        const bool is_smooth =
            end - begin > most_faces_compared || face.normal.dot(own.normal) >= least_cosine;
        if (is_smooth) sum += face.area_normal;
      }
      const double length = sum.norm();
      const std::array<float, 3> normal = single(length > 0.0 ? Eigen::Vector3d(sum / length) : own.normal);
      // Corners with the same faces have bitwise equal normals, because the sums have the same order.
      std::size_t index = first_made;
      while (index < result.vertices.size() && result.vertices[index].normal != normal) ++index;
      if (index == result.vertices.size()) result.vertices.push_back({single(p_mm), normal});
      result.triangles[around.corner[k]] = static_cast<std::uint32_t>(index);
    }
  }
  return result;
}

double crease_rad_of(const std::string& material)
{
  constexpr double tissue_crease_rad = rad_from_deg(150.0);
  return material == "meniscus" ? tissue_crease_rad : default_crease_rad;
}

Material material_of(const std::string& name)
{
  if (name == "bone") return {Eigen::Vector3f(0.839F, 0.745F, 0.591F), 1.0F, 0.10F, 24.0F, 0.13F};
  if (name == "cartilage") return {Eigen::Vector3f(0.617F, 0.730F, 0.776F), 1.0F, 0.30F, 60.0F, 0.03F};
  if (name == "meniscus") return {Eigen::Vector3f(0.617F, 0.231F, 0.168F), 1.0F, 0.22F, 24.0F, 0.09F};
  return {Eigen::Vector3f(0.402F, 0.456F, 0.503F), 1.0F, 0.12F, 30.0F, 0.0F};
}

}  // namespace vrda::inline model
