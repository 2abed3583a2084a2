#include "support/meshes.hpp"

#include "core/units.hpp"

namespace vrda::test {
namespace {

void set_triangle(Mesh& mesh, Eigen::Index t, int a, int b, int c)
{
  mesh.triangles.row(t) << a, b, c;
}

}  // namespace

Mesh box(const Eigen::Vector3d& centre_mm, const Eigen::Vector3d& size_mm)
{
  Mesh mesh;
  mesh.vertices_mm.resize(8, 3);
  for (int v = 0; v < 8; ++v) {
    const Eigen::Vector3d unit(v & 1 ? 0.5 : -0.5, v & 2 ? 0.5 : -0.5, v & 4 ? 0.5 : -0.5);
    mesh.vertices_mm.row(v) = (centre_mm + unit.cwiseProduct(size_mm)).transpose();
  }
  mesh.triangles.resize(12, 3);
  mesh.triangles << 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5, 0, 1, 5, 0, 5, 4, 2, 6, 7, 2, 7, 3, 0, 2, 3, 0, 3, 1,
      4, 5, 7, 4, 7, 6;
  mesh.normals = vertex_normals(mesh);
  return mesh;
}

Mesh ball(double radius_mm, int n_rings, int n_sectors)
{
  Mesh mesh;
  mesh.vertices_mm.resize(2 + (n_rings - 1) * n_sectors, 3);
  mesh.vertices_mm.row(0) << 0, radius_mm, 0;
  mesh.vertices_mm.row(1) << 0, -radius_mm, 0;
  const auto ring_vertex = [&](int ring, int sector) {
    return 2 + (ring - 1) * n_sectors + sector % n_sectors;
  };
  for (int ring = 1; ring < n_rings; ++ring) {
    const SinCos polar = sin_cos(pi * ring / n_rings);
    for (int sector = 0; sector < n_sectors; ++sector) {
      const SinCos around = sin_cos(2.0 * pi * sector / n_sectors);
      mesh.vertices_mm.row(ring_vertex(ring, sector)) << radius_mm * polar.sin * around.cos,
          radius_mm * polar.cos, -radius_mm * polar.sin * around.sin;
    }
  }
  mesh.triangles.resize(2 * n_sectors * (n_rings - 1), 3);
  Eigen::Index t = 0;
  for (int sector = 0; sector < n_sectors; ++sector) {
    set_triangle(mesh, t++, 0, ring_vertex(1, sector), ring_vertex(1, sector + 1));
    set_triangle(mesh, t++, 1, ring_vertex(n_rings - 1, sector + 1), ring_vertex(n_rings - 1, sector));
    for (int ring = 1; ring + 1 < n_rings; ++ring) {
      const int a = ring_vertex(ring, sector), b = ring_vertex(ring, sector + 1);
      const int c = ring_vertex(ring + 1, sector), d = ring_vertex(ring + 1, sector + 1);
      set_triangle(mesh, t++, a, c, d);
      set_triangle(mesh, t++, a, d, b);
    }
  }
  mesh.normals = mesh.vertices_mm / radius_mm;
  return mesh;
}

Mesh sheet(double size_mm, int n)
{
  Mesh mesh;
  mesh.vertices_mm.resize((n + 1) * (n + 1), 3);
  for (int i = 0; i <= n; ++i) {
    for (int k = 0; k <= n; ++k) {
      mesh.vertices_mm.row(i * (n + 1) + k) << size_mm * (i - 0.5 * n) / n, 0.0, size_mm * (k - 0.5 * n) / n;
    }
  }
  mesh.triangles.resize(2 * n * n, 3);
  Eigen::Index t = 0;
  for (int i = 0; i < n; ++i) {
    for (int k = 0; k < n; ++k) {
      const int a = i * (n + 1) + k, b = a + 1, c = a + n + 1, d = c + 1;
      set_triangle(mesh, t++, a, b, d);
      set_triangle(mesh, t++, a, d, c);
    }
  }
  mesh.normals = vertex_normals(mesh);
  return mesh;
}

Mesh plate(double half_width_mm, bool is_up)
{
  Mesh mesh;
  mesh.vertices_mm.resize(4, 3);
  mesh.vertices_mm << -half_width_mm, 0, -half_width_mm, half_width_mm, 0, -half_width_mm, half_width_mm, 0,
      half_width_mm, -half_width_mm, 0, half_width_mm;
  mesh.triangles.resize(2, 3);
  if (is_up) {
    mesh.triangles << 0, 2, 1, 0, 3, 2;
  } else {
    mesh.triangles << 0, 1, 2, 0, 2, 3;
  }
  return mesh;
}

}  // namespace vrda::test
