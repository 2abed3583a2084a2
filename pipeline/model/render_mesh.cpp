#include "model/render_mesh.hpp"

#include "core/trig.hpp"

namespace vrda::inline model {
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
