#include "contact/sticking_out.hpp"

namespace vrda {
namespace {

// How far out of its neighbour's plane, in parts of the largest coordinate, a face may stand and still be
// called flat: a few roundings of vertices that were turned and shifted.
constexpr double flat_share = 1e-13;

// Whether `other` stands behind the plane of `face` by more than rounding at some corner, as across an edge
// that sticks out.
bool falls_back(const Mesh& mesh, std::int32_t face, std::int32_t other, double flat_mm)
{
  const Eigen::Vector3d normal = face_normal(mesh, face), at = corners(mesh, face)[0];
  for (const Eigen::Vector3d& p : corners(mesh, other)) {
    if (normal.dot(p - at) < -flat_mm) return true;
  }
  return false;
}

}  // namespace

std::vector<bool> sticking_out(const Mesh& mesh, const SurfaceFeatures& features)
{
  std::vector<bool> sticks(static_cast<std::size_t>(mesh.vertices_mm.rows()), false);
  const double flat_mm =
      mesh.vertices_mm.rows() > 0 ? flat_share * mesh.vertices_mm.cwiseAbs().maxCoeff() : 0.0;
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const std::int32_t edge = features.edge_of(static_cast<std::int32_t>(t), k);
      const std::vector<std::int32_t> faces = features.star({FeatureKind::edge, edge});
      const bool is_inner = faces.size() == 2 && !falls_back(mesh, faces[0], faces[1], flat_mm) &&
                            !falls_back(mesh, faces[1], faces[0], flat_mm);
      if (is_inner) continue;
      for (const std::int32_t v : features.edge_vertices(edge)) sticks[static_cast<std::size_t>(v)] = true;
    }
  }
  return sticks;
}

}  // namespace vrda
