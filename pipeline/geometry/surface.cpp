#include "geometry/surface.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <utility>

#include "core/trig.hpp"
#include "core/units.hpp"

namespace vrda::geometry {
namespace {

using Face = std::array<std::int32_t, 3>;

Mesh assembled(const std::vector<Eigen::Vector3d>& vertices_mm, const std::vector<Face>& faces)
{
  Mesh mesh;
  mesh.vertices_mm.resize(static_cast<Eigen::Index>(vertices_mm.size()), 3);
  for (std::size_t v = 0; v < vertices_mm.size(); ++v) {
    mesh.vertices_mm.row(static_cast<Eigen::Index>(v)) = vertices_mm[v].transpose();
  }
  mesh.triangles.resize(static_cast<Eigen::Index>(faces.size()), 3);
  for (std::size_t t = 0; t < faces.size(); ++t) {
    mesh.triangles.row(static_cast<Eigen::Index>(t)) << faces[t][0], faces[t][1], faces[t][2];
  }
  return mesh;
}

// Vertices and faces of a block under construction; vertices are created on first use.
class BlockBuilder {
 public:
  explicit BlockBuilder(const ShapedBlock& block) : block_(block)
  {
    n_x_ = static_cast<int>(block.x_mm.size()) - 1;
    n_z_ = static_cast<int>(block.z_mm.size()) - 1;
    faces_up_ = block.front_y_mm(block.x_mm.front(), block.z_mm.front()) > block.back_y_mm;
  }

  Mesh mesh()
  {
    for (int i = 0; i < n_x_; ++i) {
      for (int k = 0; k < n_z_; ++k) {
        if (!is_filled(i, k)) continue;
        add_front(i, k);
        add_quad(back(i, k), back(i + 1, k), back(i + 1, k + 1), back(i, k + 1));
        if (!is_filled(i - 1, k)) add_quad(front(i, k), back(i, k), back(i, k + 1), front(i, k + 1));
        if (!is_filled(i + 1, k))
          add_quad(front(i + 1, k + 1), back(i + 1, k + 1), back(i + 1, k), front(i + 1, k));
        if (!is_filled(i, k - 1)) add_quad(front(i + 1, k), back(i + 1, k), back(i, k), front(i, k));
        if (!is_filled(i, k + 1))
          add_quad(front(i, k + 1), back(i, k + 1), back(i + 1, k + 1), front(i + 1, k + 1));
      }
    }
    Mesh result = assembled(vertices_mm_, faces_);
    result.normals = vertex_normals(result);
    return result;
  }

 private:
  bool is_filled(int i, int k) const
  {
    if (i < 0 || k < 0 || i >= n_x_ || k >= n_z_) return false;
    const auto reach = [](const std::vector<double>& lines, int n) {
      const auto at = static_cast<std::size_t>(n);
      return std::max(std::abs(lines[at]), std::abs(lines[at + 1]));
    };
    return std::max(reach(block_.x_mm, i), reach(block_.z_mm, k)) > block_.hole_half_mm;
  }

  std::int32_t vertex(int i, int k, bool is_front)
  {
    const auto [found, is_new] =
        index_.try_emplace({i, k, is_front ? 1 : 0}, static_cast<std::int32_t>(vertices_mm_.size()));
    if (is_new) {
      const double x = block_.x_mm[static_cast<std::size_t>(i)], z = block_.z_mm[static_cast<std::size_t>(k)];
      vertices_mm_.emplace_back(x, is_front ? block_.front_y_mm(x, z) : block_.back_y_mm, z);
    }
    return found->second;
  }
  std::int32_t front(int i, int k) { return vertex(i, k, true); }
  std::int32_t back(int i, int k) { return vertex(i, k, false); }

  // Counter-clockwise seen from outside when the front faces up.
  void add_face(std::int32_t a, std::int32_t b, std::int32_t c)
  {
    faces_.push_back(faces_up_ ? Face{a, b, c} : Face{a, c, b});
  }
  void add_quad(std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t d)
  {
    add_face(a, b, c);
    add_face(a, c, d);
  }

  void add_front(int i, int k)
  {
    const std::int32_t a = front(i, k), b = front(i, k + 1), c = front(i + 1, k + 1), d = front(i + 1, k);
    const auto y = [&](std::int32_t v) { return vertices_mm_[static_cast<std::size_t>(v)].y(); };
    const auto at = [](const std::vector<double>& lines, int n) {
      return 0.5 * (lines[static_cast<std::size_t>(n)] + lines[static_cast<std::size_t>(n) + 1]);
    };
    const double middle = block_.front_y_mm(at(block_.x_mm, i), at(block_.z_mm, k));
    const bool is_first = std::abs(0.5 * (y(a) + y(c)) - middle) <= std::abs(0.5 * (y(b) + y(d)) - middle);
    is_first ? add_quad(a, b, c, d) : add_quad(b, c, d, a);
  }

  const ShapedBlock& block_;
  int n_x_ = 0;
  int n_z_ = 0;
  bool faces_up_ = true;
  std::map<std::array<int, 3>, std::int32_t> index_;
  std::vector<Eigen::Vector3d> vertices_mm_;
  std::vector<Face> faces_;
};

// Corners and faces of an icosahedron on the unit ball with a corner at +Y: two rings of five at
// heights +-1 / sqrt(5).
struct Icosahedron {
  std::array<Eigen::Vector3d, 12> corner;
  std::vector<Face> faces;
};

Icosahedron icosahedron()
{
  Icosahedron result;
  const double height = 1.0 / std::sqrt(5.0), radius = 2.0 * height;
  result.corner[0] = Eigen::Vector3d(0, 1, 0);
  result.corner[11] = Eigen::Vector3d(0, -1, 0);
  for (std::int32_t k = 0; k < 5; ++k) {
    const auto at = static_cast<std::size_t>(k);
    const SinCos upper = sin_cos(2.0 * pi * k / 5.0), lower = sin_cos(2.0 * pi * (k + 0.5) / 5.0);
    result.corner[1 + at] = {radius * upper.cos, height, -radius * upper.sin};
    result.corner[6 + at] = {radius * lower.cos, -height, -radius * lower.sin};
    const std::int32_t u = 1 + k, u_next = 1 + (k + 1) % 5, l = 6 + k, l_next = 6 + (k + 1) % 5;
    result.faces.insert(result.faces.end(), {Face{0, u, u_next}, Face{u, l, u_next}, Face{u_next, l, l_next},
                                             Face{11, l_next, l}});
  }
  return result;
}

// Points on a face are identified by corners and weights, so that faces share the points of their edges.
using PointName = std::array<std::pair<std::int32_t, int>, 3>;

}  // namespace

void append_lines(std::vector<double>& lines, double from, double to, int n_steps)
{
  for (int k = lines.empty() ? 0 : 1; k <= n_steps; ++k) {
    const double t = static_cast<double>(k) / n_steps;
    lines.push_back(from * (1.0 - t) + to * t);
  }
}

Mesh block_mesh(const ShapedBlock& block)
{
  return BlockBuilder(block).mesh();
}

Mesh plain_pyramid_mesh(double half_base_mm, double rim_y_mm, double back_y_mm)
{
  // Corners counter-clockwise seen from above: 0 to 3 rim, 4 to 7 back, 8 tip.
  std::vector<Eigen::Vector3d> vertices_mm;
  for (const double y : {rim_y_mm, back_y_mm}) {
    for (const auto& [x, z] : {std::pair(1.0, 1.0), {1.0, -1.0}, {-1.0, -1.0}, {-1.0, 1.0}}) {
      vertices_mm.emplace_back(half_base_mm * x, y, half_base_mm * z);
    }
  }
  vertices_mm.emplace_back(0.0, 0.0, 0.0);
  std::vector<Face> faces = {{4, 6, 5}, {4, 7, 6}};
  for (std::int32_t k = 0; k < 4; ++k) {
    const std::int32_t next = (k + 1) % 4;
    faces.insert(faces.end(), {Face{k, next, 8}, Face{k + 4, next, k}, Face{k + 4, next + 4, next}});
  }
  if (back_y_mm > 0.0) {
    for (Face& face : faces) std::swap(face[1], face[2]);
  }
  Mesh mesh = assembled(vertices_mm, faces);
  mesh.normals = vertex_normals(mesh);
  return mesh;
}

Mesh ellipsoid_mesh(const Eigen::Vector3d& half_axes_mm, int n_edges)
{
  const Icosahedron base = icosahedron();
  std::map<PointName, std::int32_t> index;
  std::vector<Eigen::Vector3d> vertices_mm, normal;
  std::vector<Face> faces;
  const auto point = [&](const Face& face, int a, int b) {
    PointName name = {{{face[0], n_edges - a - b}, {face[1], a}, {face[2], b}}};
    for (auto& [corner, weight] : name) corner = weight == 0 ? -1 : corner;
    std::sort(name.begin(), name.end());
    const auto [found, is_new] = index.try_emplace(name, static_cast<std::int32_t>(vertices_mm.size()));
    if (is_new) {
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      for (const auto& [corner, weight] : name) {
        if (corner >= 0) sum += weight * base.corner[static_cast<std::size_t>(corner)];
      }
      const Eigen::Vector3d unit = sum.normalized();
      vertices_mm.push_back(unit.cwiseProduct(half_axes_mm));
      normal.push_back(unit.cwiseQuotient(half_axes_mm).normalized());
    }
    return found->second;
  };
  for (const Face& face : base.faces) {
    for (int a = 0; a < n_edges; ++a) {
      for (int b = 0; a + b < n_edges; ++b) {
        faces.push_back({point(face, a, b), point(face, a + 1, b), point(face, a, b + 1)});
        if (a + b + 1 == n_edges) continue;
        faces.push_back({point(face, a + 1, b), point(face, a + 1, b + 1), point(face, a, b + 1)});
      }
    }
  }
  Mesh mesh = assembled(vertices_mm, faces);
  mesh.normals = assembled(normal, {}).vertices_mm;
  return mesh;
}

}  // namespace vrda::geometry
