#include "geometry/gap_scenes.hpp"

#include <algorithm>
#include <numeric>

#include "geometry/shapes.hpp"
#include "support/directional_gap.hpp"
#include "support/meshes.hpp"

namespace vrda::test {
namespace {

GapBodies coarse_knee()
{
  GapBodies knee;
  knee.depth_mm = -5;
  const geometry::Shape shape = geometry::generate_shape({"knee", {{"resolution", 0.5}}, {}});
  for (const geometry::ShapePart& part : shape.reference) {
    if (part.has_contact) append(knee.reference, part.mesh);
  }
  for (const geometry::ShapePart& part : shape.moving) {
    if (part.has_contact) append(knee.moving, part.mesh);
  }
  return knee;
}

}  // namespace

MovingPose GapRandom::pose(double across_mm, double depth_mm)
{
  const double x = across_mm * unit(), y = depth_mm + 3 * unit(), z = across_mm * unit();
  return {{x, y, z}, 3 * unit()};
}

Mesh GapRandom::soup(int n_triangles, double size_mm)
{
  Mesh mesh;
  mesh.vertices_mm.resize(3 * n_triangles, 3);
  mesh.triangles.resize(n_triangles, 3);
  for (int t = 0; t < n_triangles; ++t) {
    Eigen::RowVector3d centre;
    for (double& value : centre) value = unit();
    centre = centre.cwiseProduct(Eigen::RowVector3d(10, 3, 10));
    for (int k = 0; k < 3; ++k) {
      Eigen::RowVector3d corner;
      for (double& value : corner) value = size_mm * unit();
      mesh.vertices_mm.row(3 * t + k) = centre + corner;
      mesh.triangles(t, k) = 3 * t + k;
    }
  }
  return mesh;
}

Mesh GapRandom::dented(Mesh mesh, double share)
{
  for (Eigen::Index v = 0; v < mesh.vertices_mm.rows(); ++v) mesh.vertices_mm.row(v) *= 1.0 + share * unit();
  return mesh;
}

std::vector<Eigen::Index> GapRandom::permutation(Eigen::Index n)
{
  std::vector<Eigen::Index> order(static_cast<std::size_t>(n));
  std::iota(order.begin(), order.end(), Eigen::Index{0});
  std::shuffle(order.begin(), order.end(), engine_);
  return order;
}

Mesh GapRandom::renumbered(const Mesh& mesh)
{
  Mesh result = mesh;
  const std::vector<Eigen::Index> vertex = permutation(mesh.vertices_mm.rows());
  for (Eigen::Index v = 0; v < mesh.vertices_mm.rows(); ++v) {
    result.vertices_mm.row(vertex[static_cast<std::size_t>(v)]) = mesh.vertices_mm.row(v);
  }
  const std::vector<Eigen::Index> triangle = permutation(mesh.triangles.rows());
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    for (Eigen::Index k = 0; k < 3; ++k) {
      const auto old = static_cast<std::size_t>(mesh.triangles(t, (t + k) % 3));
      result.triangles(triangle[static_cast<std::size_t>(t)], k) = static_cast<std::int32_t>(vertex[old]);
    }
  }
  return result;
}

std::vector<GapBodies> gap_bodies(GapRandom& random)
{
  return {{ball(10, 10, 16), ball(7, 9, 14)},
          {random.dented(ball(10, 14, 22), 0.1), random.dented(ball(8, 13, 20), 0.1)},
          {box({0, 0, 0}, {12, 4, 12}), box({0, 0, 0}, {5, 5, 5})},
          {random.soup(60, 3), random.soup(50, 4)},
          coarse_knee()};
}

GapBodies rounded(GapBodies bodies)
{
  bodies.reference.offset_mm.assign(static_cast<std::size_t>(bodies.reference.triangles.rows()), 1.0);
  bodies.moving.offset_mm.assign(static_cast<std::size_t>(bodies.moving.triangles.rows()), 0.6);
  Mesh bare = box({4, 6, 3}, {3, 3, 3});
  bare.offset_mm.assign(12, 0.0);
  append(bodies.moving, bare);
  return bodies;
}

double dense_gap_mm(const GapBodies& bodies, const Attitude& attitude, const MovingPose& pose)
{
  const geometry::TreeMesh there =
      geometry::rotated_reference(geometry::make_tree_mesh(bodies.reference), attitude);
  const geometry::Placement place(pose);
  double least = std::numeric_limits<double>::infinity();
  for (Eigen::Index m = 0; m < bodies.moving.triangles.rows(); ++m) {
    const geometry::Corners moving = place(corners(bodies.moving, m));
    for (Eigen::Index r = 0; r < bodies.reference.triangles.rows(); ++r) {
      const double offset = offset_mm(bodies.reference, r) + offset_mm(bodies.moving, m);
      least = std::min(
          least, pair_travel_mm(corners(there.mesh, r), moving, geometry::GapKind::signed_facing, offset));
    }
  }
  return least;
}

std::vector<double> bits_of(const geometry::GapResult& answer)
{
  std::vector<double> bits{answer.travel_mm, static_cast<double>(answer.pair.reference),
                           static_cast<double>(answer.pair.moving)};
  for (const geometry::GapFeature& f : answer.features) {
    bits.push_back(f.travel_mm);
    bits.insert(bits.end(), f.point_mm.begin(), f.point_mm.end());
    bits.insert(bits.end(), f.normal.begin(), f.normal.end());
    bits.push_back(f.triangles.reference);
    bits.push_back(f.triangles.moving);
  }
  return bits;
}

}  // namespace vrda::test
