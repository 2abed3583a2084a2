#include "view/solids.hpp"

#include <algorithm>
#include <array>

#include "core/error.hpp"
#include "core/trig.hpp"
#include "core/units.hpp"

namespace vrda::view {
namespace {

constexpr std::size_t n_sides = 12;
constexpr std::size_t n_ball_rings = 9;
/// An arrow has pairs of rings for tail, shaft, back of the head and cone, each with its own normals.
constexpr std::size_t n_arrow_rings = 8, n_rod_rings = 6;

using Circle = std::array<SinCos, n_sides>;

const Circle& circle()
{
  static const Circle points = [] {
    Circle made{};
    for (std::size_t k = 0; k < n_sides; ++k)
      made[k] = sin_cos(static_cast<double>(k) * (2.0 * pi / static_cast<double>(n_sides)));
    return made;
  }();
  return points;
}

/// Right-handed orthonormal frame: two directions across, one along.
struct Frame {
  Eigen::Vector3d u, v, along;
};

Frame frame_along(const Eigen::Vector3d& along)
{
  Eigen::Index least = 0;
  along.cwiseAbs().minCoeff(&least);
  const Eigen::Vector3d u = along.cross(Eigen::Vector3d::Unit(least)).normalized();
  return {u, along.cross(u), along};
}

struct Ring {
  Eigen::Vector3d centre_mm;
  double radius_mm = 0.0;
  double outward = 1.0;  ///< radial component of the normal
  double forward = 0.0;  ///< axial component of the normal
};

std::array<float, 3> single(const Eigen::Vector3d& v)
{
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

std::size_t set_ring(RenderMesh& mesh, std::size_t first_vertex, const Frame& frame, const Ring& ring)
{
  for (std::size_t k = 0; k < n_sides; ++k) {
    const SinCos& angle = circle()[k];
    const Eigen::Vector3d across = angle.cos * frame.u + angle.sin * frame.v;
    RenderVertex& vertex = mesh.vertices[first_vertex + k];
    vertex.position_mm = single(ring.centre_mm + ring.radius_mm * across);
    vertex.normal = single(ring.outward * across + ring.forward * frame.along);
  }
  return first_vertex + n_sides;
}

/// Triangles between the rings at vertices first and first + n_sides, counter-clockwise seen from outside.
void add_band(RenderMesh& mesh, std::size_t first)
{
  for (std::size_t k = 0; k < n_sides; ++k) {
    const auto a = static_cast<std::uint32_t>(first + k);
    const auto b = static_cast<std::uint32_t>(first + (k + 1) % n_sides);
    const auto n = static_cast<std::uint32_t>(n_sides);
    for (const std::uint32_t index : {a, b, b + n, a, b + n, a + n}) mesh.triangles.push_back(index);
  }
}

/// Adds rings and the bands between successive rings; with step 2 only between the rings of each pair.
void add_rings(RenderMesh& mesh, std::size_t n_rings, std::size_t step)
{
  const std::size_t first = mesh.vertices.size();
  mesh.vertices.resize(first + n_rings * n_sides);
  for (std::size_t ring = 0; ring + 1 < n_rings; ring += step) add_band(mesh, first + ring * n_sides);
}

SolidSize size_of(std::size_t n_rings, std::size_t step)
{
  return {n_rings * n_sides, n_rings / step * 6 * n_sides - (step == 1 ? 6 * n_sides : 0)};
}

/// Writes a flat end cap: a ring and its centre, in axial order. `ring.forward` is -1 or 1.
std::size_t set_end(RenderMesh& mesh, std::size_t vertex, const Frame& frame, const Ring& ring)
{
  const Ring centre{ring.centre_mm, 0.0, 0.0, ring.forward};
  vertex = set_ring(mesh, vertex, frame, ring.forward > 0.0 ? ring : centre);
  return set_ring(mesh, vertex, frame, ring.forward > 0.0 ? centre : ring);
}

}  // namespace

SolidSize ball_size()
{
  return size_of(n_ball_rings, 1);
}
SolidSize arrow_size()
{
  return size_of(n_arrow_rings, 2);
}
SolidSize tube_size(std::size_t n_points)
{
  return size_of(n_points + 2, 1);
}

void add_balls(RenderMesh& mesh, std::size_t n)
{
  for (std::size_t i = 0; i < n; ++i) add_rings(mesh, n_ball_rings, 1);
}
void add_rods(RenderMesh& mesh, std::size_t n)
{
  for (std::size_t i = 0; i < n; ++i) add_rings(mesh, n_rod_rings, 2);
}
void add_arrows(RenderMesh& mesh, std::size_t n)
{
  for (std::size_t i = 0; i < n; ++i) add_rings(mesh, n_arrow_rings, 2);
}
void add_tube(RenderMesh& mesh, std::size_t n_points)
{
  add_rings(mesh, n_points + 2, 1);
}

void set_ball(RenderMesh& mesh, std::size_t first_vertex, const Eigen::Vector3d& centre_mm, double radius_mm)
{
  const Frame frame = frame_along(Eigen::Vector3d::UnitY());
  for (std::size_t i = 0; i < n_ball_rings; ++i) {
    const SinCos turn = sin_cos(static_cast<double>(i) * (pi / static_cast<double>(n_ball_rings - 1)));
    const Eigen::Vector3d ring_mm = centre_mm - radius_mm * turn.cos * frame.along;
    first_vertex = set_ring(mesh, first_vertex, frame, {ring_mm, radius_mm * turn.sin, turn.sin, -turn.cos});
  }
}

void set_rod(RenderMesh& mesh, std::size_t first_vertex, const Eigen::Vector3d& from_mm,
             const Eigen::Vector3d& to_mm, double radius_mm)
{
  const Frame frame = frame_along((to_mm - from_mm).normalized());
  std::size_t vertex = set_end(mesh, first_vertex, frame, {from_mm, radius_mm, 0.0, -1.0});
  vertex = set_ring(mesh, vertex, frame, {from_mm, radius_mm});
  vertex = set_ring(mesh, vertex, frame, {to_mm, radius_mm});
  set_end(mesh, vertex, frame, {to_mm, radius_mm, 0.0, 1.0});
}

void set_arrow(RenderMesh& mesh, std::size_t first_vertex, const Eigen::Vector3d& from_mm,
               const Eigen::Vector3d& to_mm, double radius_mm)
{
  constexpr double head_by_shaft = 3.0, head_slimness = 2.6, most_of_arrow = 0.6;
  const double length_mm = (to_mm - from_mm).norm();
  const Frame frame = frame_along((to_mm - from_mm) / length_mm);
  const double head_radius_mm =
      std::min(head_by_shaft * radius_mm, most_of_arrow * length_mm / head_slimness);
  const double shaft_radius_mm = head_radius_mm / head_by_shaft;
  const Eigen::Vector3d arrow_neck_mm = to_mm - head_slimness * head_radius_mm * frame.along;
  std::size_t vertex = set_end(mesh, first_vertex, frame, {from_mm, shaft_radius_mm, 0.0, -1.0});
  vertex = set_ring(mesh, vertex, frame, {from_mm, shaft_radius_mm});
  vertex = set_ring(mesh, vertex, frame, {arrow_neck_mm, shaft_radius_mm});
  vertex = set_end(mesh, vertex, frame, {arrow_neck_mm, head_radius_mm, 0.0, -1.0});
  // Normal of a cone with a length of head_slimness radii.
  constexpr double outward = 0.933, forward = 0.359;
  vertex = set_ring(mesh, vertex, frame, {arrow_neck_mm, head_radius_mm, outward, forward});
  set_ring(mesh, vertex, frame, {to_mm, 0.0, outward, forward});
}

void set_tube(RenderMesh& mesh, std::size_t first_vertex, std::span<const Eigen::Vector3d> points_mm,
              double radius_mm)
{
  set_band(mesh, first_vertex, points_mm, {radius_mm, radius_mm});
}

void set_band(RenderMesh& mesh, std::size_t first_vertex, std::span<const Eigen::Vector3d> points_mm,
              const BandSection& section)
{
  constexpr double coincident_mm = 1e-9;
  check(points_mm.size() >= 2, "a tube has at least two points");
  const std::size_t last = points_mm.size() - 1;
  Frame frame = frame_along(Eigen::Vector3d::UnitY());
  bool has_frame = false;
  std::size_t vertex = first_vertex;
  const auto set_section = [&](const Eigen::Vector3d& centre_mm, double width_mm, double forward) {
    for (std::size_t k = 0; k < n_sides; ++k) {
      const SinCos& angle = circle()[k];
      const double scale = width_mm / section.half_width_mm;
      RenderVertex& made = mesh.vertices[vertex + k];
      made.position_mm = single(centre_mm + scale * (section.half_width_mm * angle.cos * frame.u +
                                                     section.half_thickness_mm * angle.sin * frame.v));
      // The gradient of the ellipse.
      const Eigen::Vector3d outward = section.half_thickness_mm * angle.cos * frame.u +
                                      section.half_width_mm * angle.sin * frame.v;
      made.normal = single(forward == 0.0 ? outward.normalized() : Eigen::Vector3d(forward * frame.along));
    }
    vertex += n_sides;
  };
  for (std::size_t i = 0; i <= last; ++i) {
    const Eigen::Vector3d tangent_mm = points_mm[std::min(i + 1, last)] - points_mm[i > 0 ? i - 1 : 0];
    const double length_mm = tangent_mm.norm();
    if (length_mm > coincident_mm) {
      // The width's direction, or else the minimal rotation from the previous ring's frame.
      const Eigen::Vector3d along = tangent_mm / length_mm;
      const double part = static_cast<double>(i) / static_cast<double>(last);
      const Eigen::Vector3d across = (1.0 - part) * section.across_first + part * section.across_last;
      const Eigen::Vector3d wanted = across - along.dot(across) * along;
      const Eigen::Vector3d u = frame.u - along.dot(frame.u) * along;
      if (wanted.norm() > 0.1 * across.norm()) {
        frame = {wanted.normalized(), along.cross(wanted.normalized()), along};
      } else {
        frame = has_frame && u.norm() > 0.1 ? Frame{u.normalized(), along.cross(u.normalized()), along}
                                            : frame_along(along);
      }
      has_frame = true;
    }
    if (i == 0) set_section(points_mm[0], 0.0, -1.0);
    set_section(points_mm[i], section.half_width_mm, 0.0);
    if (i == last) set_section(points_mm[last], 0.0, 1.0);
  }
}

}  // namespace vrda::view
