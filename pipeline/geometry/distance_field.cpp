#include "geometry/distance_field.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <deque>
#include <map>
#include <optional>
#include <utility>

#include "core/units.hpp"
#include "geometry/nearest_surface.hpp"
#include "geometry/placement.hpp"

namespace vrda::geometry {
namespace {

constexpr double cell_mm = 1.0;
// The spline differs less from its nearest coefficient, at most 0.87 mm away: its slope is about 1.
constexpr double slope_bound_mm = 1.5;

using Edge = std::pair<std::int32_t, std::int32_t>;

Edge edge_of(const Mesh& mesh, Eigen::Index t, Eigen::Index corner)
{
  return std::minmax(mesh.triangles(t, corner), mesh.triangles(t, (corner + 1) % 3));
}

// Sign of a distance by pseudonormals. Source: Baerentzen and Aanaes (2005), IEEE Trans Vis Comput Graph
// 11:243-253.
class SurfaceSides {
 public:
  // Beyond an edge of one triangle between two vertices of `rim` the distance is positive. Beyond others,
  // where hidden triangles are missing, the surface counts as continued. The mesh must outlive it.
  SurfaceSides(const Mesh& mesh, const std::vector<bool>& rim)
      : mesh_(mesh),
        at_vertex_(Points::Zero(mesh.vertices_mm.rows(), 3)),
        is_rim_(static_cast<std::size_t>(mesh.vertices_mm.rows()), false)
  {
    for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) add(mesh, t);
    for (auto& [edge, value] : edges_) {
      const auto a = static_cast<std::size_t>(edge.first), b = static_cast<std::size_t>(edge.second);
      value.is_rim = value.n == 1 && rim[a] && rim[b];
      if (value.is_rim) is_rim_[a] = is_rim_[b] = true;
    }
  }

  double signed_mm(const Eigen::Vector3d& p_mm, const SurfacePoint& near) const
  {
    const auto [normal, is_rim] = normal_at(near);
    return is_rim || (p_mm - near.p_mm).dot(normal) >= 0.0 ? near.distance_mm : -near.distance_mm;
  }

 private:
  struct EdgeNormal {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    int n = 0;
    bool is_rim = false;
  };

  void add(const Mesh& mesh, Eigen::Index t)
  {
    const auto corner = corners(mesh, t);
    const Eigen::Vector3d normal = face_normal(mesh, t);
    for (std::size_t k = 0; k < 3; ++k) {
      const auto c = static_cast<Eigen::Index>(k);
      const Eigen::Vector3d u = corner[(k + 1) % 3] - corner[k], v = corner[(k + 2) % 3] - corner[k];
      at_vertex_.row(mesh.triangles(t, c)) += arc_tangent2(u.cross(v).norm(), u.dot(v)) * normal.transpose();
      EdgeNormal& edge = edges_[edge_of(mesh, t, c)];
      edge.sum += normal;
      ++edge.n;
    }
  }

  std::pair<Eigen::Vector3d, bool> normal_at(const SurfacePoint& near) const
  {
    constexpr double on_feature = 1e-9;  // barycentric
    const auto corner = corners(mesh_, near.triangle);
    const Eigen::Vector3d normal = face_normal(mesh_, near.triangle);
    const double twice_area = (corner[1] - corner[0]).cross(corner[2] - corner[0]).dot(normal);
    std::array<bool, 3> is_zero{};
    for (std::size_t k = 0; k < 3; ++k) {
      const Eigen::Vector3d u = corner[(k + 1) % 3] - near.p_mm, v = corner[(k + 2) % 3] - near.p_mm;
      is_zero[k] = u.cross(v).dot(normal) <= on_feature * twice_area;
    }
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t next = (k + 1) % 3, last = (k + 2) % 3;
      if (!is_zero[k]) continue;
      const std::int32_t a = mesh_.triangles(near.triangle, static_cast<Eigen::Index>(next)),
                         b = mesh_.triangles(near.triangle, static_cast<Eigen::Index>(last));
      if (is_zero[next]) return at_vertex(b);
      if (is_zero[last]) return at_vertex(a);
      const EdgeNormal& edge = edges_.at(edge_of(mesh_, near.triangle, static_cast<Eigen::Index>(next)));
      return {edge.sum, edge.is_rim};
    }
    return {normal, false};
  }

  std::pair<Eigen::Vector3d, bool> at_vertex(std::int32_t row) const
  {
    return {at_vertex_.row(row).transpose(), is_rim_[static_cast<std::size_t>(row)]};
  }

  const Mesh& mesh_;
  Points at_vertex_;
  std::map<Edge, EdgeNormal> edges_;
  std::vector<bool> is_rim_;
};

struct SignedSurface {
  SignedSurface(const Mesh& mesh, const std::vector<bool>& rim) : nearest(mesh), sides(nearest.mesh(), rim) {}

  // Empty beyond `most_mm`.
  std::optional<double> distance_mm(const Eigen::Vector3d& p_mm, double most_mm) const
  {
    NearestLimits limits;
    limits.max_distance_mm = most_mm;
    const SurfacePoint near = nearest.nearest(p_mm, limits);
    if (near.triangle < 0) return std::nullopt;
    return sides.signed_mm(p_mm, near);
  }

  NearestSurface nearest;
  SurfaceSides sides;
};

// Triangles by component, or by offset.
template <typename Key>
std::map<Key, std::vector<Eigen::Index>> groups_of(Eigen::Index n_triangles, const auto& key_of)
{
  std::map<Key, std::vector<Eigen::Index>> groups;
  for (Eigen::Index t = 0; t < n_triangles; ++t) groups[key_of(t)].push_back(t);
  return groups;
}

using Weights = std::array<double, 4>;

// Cubic B-spline at `t` of [0, 1) beyond the second of four nodes.
inline Weights weights_of(double t)
{
  const double u = 1.0 - t, sixth = 1.0 / 6.0, two_thirds = 4.0 / 6.0;
  return {sixth * u * u * u, two_thirds - t * t + 0.5 * t * t * t, two_thirds - u * u + 0.5 * u * u * u,
          sixth * t * t * t};
}

inline Weights first_weights_of(double t)
{
  const double u = 1.0 - t;
  return {-0.5 * u * u, 0.5 * (3.0 * t * t - 4.0 * t), 0.5 * (4.0 * u - 3.0 * u * u), 0.5 * t * t};
}

inline Weights second_weights_of(double t)
{
  const double u = 1.0 - t;
  return {u, 3.0 * t - 2.0, 3.0 * u - 2.0, t};
}

inline double dot(const Weights& a, const double* b)
{
  return (a[0] * b[0] + a[1] * b[1]) + (a[2] * b[2] + a[3] * b[3]);
}

// The spline of its own values: (1/6, 2/3, 1/6) along an axis is a binomial pass less a third of its change.
void filter_by_spline(std::vector<double>& values, const std::array<std::int64_t, 3>& n, int axis)
{
  std::vector<double> once = values;
  filter_binomially(once, n, axis, 1);
  for (std::size_t k = 0; k < values.size(); ++k) values[k] += (once[k] - values[k]) * (2.0 / 3.0);
}

}  // namespace

void filter_binomially(std::vector<double>& values, const std::array<std::int64_t, 3>& n, int axis,
                       int n_passes)
{
  const auto a = static_cast<std::size_t>(axis);
  const std::int64_t stride = axis == 0 ? 1 : axis == 1 ? n[0] : n[0] * n[1];
  const std::int64_t n_lines = n[0] * n[1] * n[2] / n[a];
  std::vector<double> line(static_cast<std::size_t>(n[a]) + 2);
  for (std::int64_t l = 0; l < n_lines; ++l) {
    // Lines along axis 0 follow each other; along axis 1 there are n[0] of them in each of n[2] planes.
    const std::int64_t start = axis == 0 ? l * n[0] : axis == 1 ? (l / n[0]) * n[0] * n[1] + l % n[0] : l;
    for (std::int64_t i = 0; i < n[a]; ++i)
      line[static_cast<std::size_t>(i) + 1] = values[static_cast<std::size_t>(start + i * stride)];
    for (int pass = 0; pass < n_passes; ++pass) {
      line.front() = line[1];
      line.back() = line[line.size() - 2];
      double before = line.front();
      for (std::size_t i = 1; i + 1 < line.size(); ++i) {
        const double here = line[i];
        line[i] = 0.25 * (before + line[i + 1]) + 0.5 * here;
        before = here;
      }
    }
    for (std::int64_t i = 0; i < n[a]; ++i)
      values[static_cast<std::size_t>(start + i * stride)] = line[static_cast<std::size_t>(i) + 1];
  }
}

std::vector<Eigen::Index> outer_triangles(const Mesh& mesh, const std::vector<std::int32_t>& component)
{
  // A triangle is hidden if another component is this near before it and beyond its surface, or near behind.
  constexpr double probes_mm[] = {0.25, 0.5, 1.0};
  constexpr double reach_mm = 6.0;  // of solids that belong together, above the thickness of cartilage
  const Eigen::Index n = mesh.triangles.rows();
  const auto groups = groups_of<std::int32_t>(
      n, [&](Eigen::Index t) { return component.empty() ? 0 : component[static_cast<std::size_t>(t)]; });
  const std::vector<bool> rim = rim_vertices(mesh);
  std::deque<SignedSurface> surfaces;  // which do not move
  for (const auto& [name, rows] : groups) {
    if (groups.size() > 1) surfaces.emplace_back(select_triangles(mesh, rows), rim);
  }
  std::vector<Eigen::Index> outer;
  std::size_t own = 0;
  for (const auto& [name, rows] : groups) {
    for (const Eigen::Index t : rows) {
      const auto [a, b, c] = corners(mesh, t);
      const Eigen::Vector3d middle = (a + b + c) / 3.0, normal = face_normal(mesh, t);
      bool is_hidden = false;
      for (std::size_t s = 0; s < surfaces.size(); ++s) {
        for (const double probe_mm : probes_mm) {
          if (s == own || is_hidden) continue;
          const std::optional<double> d = surfaces[s].distance_mm(middle + probe_mm * normal, reach_mm);
          is_hidden = d && *d < 0.0;
        }
      }
      if (!is_hidden) outer.push_back(t);
    }
    ++own;
  }
  std::sort(outer.begin(), outer.end());
  return outer;
}

DistanceField::DistanceField(const Mesh& mesh, const std::vector<std::int32_t>& component)
{
  set_grid(bounding_box(mesh));
  value_.assign(static_cast<std::size_t>(n_[0] * n_[1] * n_[2]), band_mm);
  const std::vector<bool> rim = rim_vertices(mesh);
  const std::vector<Eigen::Index> outer = outer_triangles(mesh, component);
  std::map<double, std::vector<Eigen::Index>> by_offset;
  for (const Eigen::Index t : outer) by_offset[offset_mm(mesh, t)].push_back(t);
  for (const auto& [offset, rows] : by_offset) add_surface(select_triangles(mesh, rows), rim, offset);
  smooth();
}

void DistanceField::set_grid(const Box& surface_mm)
{
  for (std::size_t k = 0; k < 3; ++k) {
    const auto axis = static_cast<Eigen::Index>(k);
    first_[k] = static_cast<std::int64_t>(std::floor((surface_mm.min_mm[axis] - band_mm) / cell_mm)) - 2;
    n_[k] =
        static_cast<std::int64_t>(std::ceil((surface_mm.max_mm[axis] + band_mm) / cell_mm)) + 3 - first_[k];
  }
}

namespace {

// The nearest triangle of every node within the band, spread from node to node in the order of the distance:
// the nearest triangle of a node is that of one of its 26 neighbours, but for a few nodes between two
// triangles that are about as near.
class NearestTriangles {
 public:
  NearestTriangles(const std::array<std::int64_t, 3>& first, const std::array<std::int64_t, 3>& n,
                   const Mesh& mesh)
      : first_(first), n_(n), nearest_(static_cast<std::size_t>(n[0] * n[1] * n[2])), queue_(n_buckets)
  {
    for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) corner_mm_.push_back(corners(mesh, t));
    for (std::size_t t = 0; t < corner_mm_.size(); ++t) seed(static_cast<std::int32_t>(t));
    for (; bucket_ < n_buckets; ++bucket_) {
      for (std::size_t k = 0; k < queue_[bucket_].size(); ++k) spread(queue_[bucket_][k]);
    }
  }

  // -1: none within the band.
  SurfacePoint at(std::size_t row, const Eigen::Vector3d& p_mm) const
  {
    const Node& node = nearest_[row];
    if (node.triangle < 0) return {};
    return {node.triangle, nearest_in_triangle(p_mm, corner_mm_[static_cast<std::size_t>(node.triangle)]),
            std::sqrt(node.sq_mm2)};
  }

 private:
  static constexpr double bucket_mm = 0.25;
  static constexpr auto n_buckets = static_cast<std::size_t>(DistanceField::band_mm / bucket_mm) + 1;
  using Index = std::array<std::int64_t, 3>;
  struct Node {
    double sq_mm2 = DistanceField::band_mm * DistanceField::band_mm;
    std::int32_t triangle = -1, spread = -1;  // `spread`: its triangle when its neighbours last got it
  };

  std::size_t row_of(const Index& at) const
  {
    return static_cast<std::size_t>((at[2] * n_[1] + at[1]) * n_[0] + at[0]);
  }
  Index index_of(std::size_t row) const
  {
    const auto r = static_cast<std::int64_t>(row);
    return {r % n_[0], r / n_[0] % n_[1], r / (n_[0] * n_[1])};
  }

  // Nodes of the cells that the triangle may pass, and one further.
  void seed(std::int32_t triangle)
  {
    const Corners& c = corner_mm_[static_cast<std::size_t>(triangle)];
    Index from{}, to{};
    for (std::size_t k = 0; k < 3; ++k) {
      const Extent along = extent(c, static_cast<Eigen::Index>(k));
      from[k] = static_cast<std::int64_t>(std::floor(along.least / cell_mm)) - first_[k];
      to[k] = static_cast<std::int64_t>(std::ceil(along.most / cell_mm)) - first_[k];
    }
    offer_all(triangle, from, to);
  }

  void spread(std::size_t row)
  {
    Node& node = nearest_[row];
    if (node.spread == node.triangle) return;
    node.spread = node.triangle;
    const Index at = index_of(row);
    offer_all(node.triangle, {at[0] - 1, at[1] - 1, at[2] - 1}, {at[0] + 1, at[1] + 1, at[2] + 1});
  }

  void offer_all(std::int32_t triangle, const Index& from, const Index& to)
  {
    for (std::int64_t z = std::max<std::int64_t>(from[2], 0); z <= std::min(to[2], n_[2] - 1); ++z) {
      for (std::int64_t y = std::max<std::int64_t>(from[1], 0); y <= std::min(to[1], n_[1] - 1); ++y) {
        for (std::int64_t x = std::max<std::int64_t>(from[0], 0); x <= std::min(to[0], n_[0] - 1); ++x)
          offer(triangle, {x, y, z});
      }
    }
  }

  void offer(std::int32_t triangle, const Index& at)
  {
    Node& node = nearest_[row_of(at)];
    if (node.triangle == triangle) return;
    const Eigen::Vector3d p_mm = cell_mm * Eigen::Vector3d(static_cast<double>(at[0] + first_[0]),
                                                           static_cast<double>(at[1] + first_[1]),
                                                           static_cast<double>(at[2] + first_[2]));
    const double sq_mm2 =
        (nearest_in_triangle(p_mm, corner_mm_[static_cast<std::size_t>(triangle)]) - p_mm).squaredNorm();
    if (sq_mm2 > node.sq_mm2 || (sq_mm2 == node.sq_mm2 && triangle > node.triangle)) return;
    node.sq_mm2 = sq_mm2;
    node.triangle = triangle;
    // One that turns out to be nearer than the nodes of this bucket follows them.
    queue_[std::max(bucket_, static_cast<std::size_t>(std::sqrt(sq_mm2) / bucket_mm))].push_back(row_of(at));
  }

  const Index first_, n_;
  std::vector<Corners> corner_mm_;
  std::vector<Node> nearest_;
  std::vector<std::vector<std::size_t>> queue_;  // rows by distance
  std::size_t bucket_ = 0;
};

}  // namespace

void DistanceField::add_surface(const Mesh& surface, const std::vector<bool>& rim, double offset)
{
  const NearestTriangles nearest(first_, n_, surface);
  const SurfaceSides sides(surface, rim);
  for (std::int64_t z = 0; z < n_[2]; ++z) {
    for (std::int64_t y = 0; y < n_[1]; ++y) {
      double far_mm = band_mm;  // along a row the sign changes within the band only
      for (std::int64_t x = 0; x < n_[0]; ++x) {
        const std::size_t row = row_of(x, y, z);
        const Eigen::Vector3d p_mm =
            cell_mm * Eigen::Vector3d(static_cast<double>(x + first_[0]), static_cast<double>(y + first_[1]),
                                      static_cast<double>(z + first_[2]));
        const SurfacePoint near = nearest.at(row, p_mm);
        double d_mm = far_mm;
        if (near.triangle >= 0) {
          d_mm = sides.signed_mm(p_mm, near);
          far_mm = std::copysign(band_mm, d_mm);
        }
        value_[row] = std::min(value_[row], std::clamp(d_mm - offset, -band_mm, band_mm));
      }
    }
  }
}

// With the filter F and the spline S of its own coefficients: the coefficients F (2 - S F) of the distances
// keep planes and, to second order, curved surfaces in place.
void DistanceField::smooth()
{
  std::vector<double> once = value_;
  for (int axis = 0; axis < 3; ++axis) {
    filter_binomially(once, n_, axis, surface_passes);
    filter_by_spline(once, n_, axis);
  }
  for (std::size_t k = 0; k < value_.size(); ++k) value_[k] = 2.0 * value_[k] - once[k];
  for (int axis = 0; axis < 3; ++axis) filter_binomially(value_, n_, axis, surface_passes);
}

double DistanceField::bound_mm(const Eigen::Vector3d& p_mm) const
{
  std::array<std::int64_t, 3> at{};
  for (std::size_t k = 0; k < 3; ++k) {
    const double x = p_mm[static_cast<Eigen::Index>(k)] / cell_mm + 0.5 - static_cast<double>(first_[k]);
    if (!(x >= 2.0 && x < static_cast<double>(n_[k] - 2))) return band_mm - slope_bound_mm;
    at[k] = static_cast<std::int64_t>(x);
  }
  return value_[row_of(at[0], at[1], at[2])] - slope_bound_mm;
}

DistanceField::Sample DistanceField::sample(const Eigen::Vector3d& p_mm, double least_mm) const
{
  Sample out;
  std::int64_t at[3];
  double t[3];
  for (std::size_t k = 0; k < 3; ++k) {
    const double x = p_mm[static_cast<Eigen::Index>(k)] / cell_mm - static_cast<double>(first_[k]);
    if (!(x >= 1.0 && x < static_cast<double>(n_[k] - 2))) return out;
    at[k] = static_cast<std::int64_t>(x);
    t[k] = x - static_cast<double>(at[k]);
  }
  const Weights x = weights_of(t[0]), y = weights_of(t[1]), z = weights_of(t[2]);
  const double* const nodes = &value_[row_of(at[0] - 1, at[1] - 1, at[2] - 1)];
  const std::int64_t n_row = n_[0], n_plane = n_[0] * n_[1];
  // Per plane of constant z, the values along x and their sums over y.
  double value[4][4], over_y[4];
  for (std::int64_t c = 0; c < 4; ++c) {
    for (std::int64_t b = 0; b < 4; ++b) value[c][b] = dot(x, nodes + c * n_plane + b * n_row);
    over_y[c] = dot(y, value[c]);
  }
  out.distance_mm = over_y[0] * z[0] + over_y[1] * z[1] + over_y[2] * z[2] + over_y[3] * z[3];
  if (!(out.distance_mm < least_mm)) return out;
  const Weights dx = first_weights_of(t[0]), dy = first_weights_of(t[1]), dz = first_weights_of(t[2]);
  const Weights ddx = second_weights_of(t[0]), ddy = second_weights_of(t[1]), ddz = second_weights_of(t[2]);
  double g[3] = {0.0, 0.0, 0.0}, xx = 0.0, yy = 0.0, zz = 0.0, yx = 0.0, zx = 0.0, zy = 0.0;
  for (std::int64_t c = 0; c < 4; ++c) {
    double first[4], second[4];
    for (std::int64_t b = 0; b < 4; ++b) {
      first[b] = dot(dx, nodes + c * n_plane + b * n_row);
      second[b] = dot(ddx, nodes + c * n_plane + b * n_row);
    }
    const auto k = static_cast<std::size_t>(c);
    const double by_x = dot(y, first), by_y = dot(dy, value[c]);
    g[0] += by_x * z[k];
    g[1] += by_y * z[k];
    g[2] += over_y[c] * dz[k];
    xx += dot(y, second) * z[k];
    yy += dot(ddy, value[c]) * z[k];
    zz += over_y[c] * ddz[k];
    yx += dot(dy, first) * z[k];
    zx += by_x * dz[k];
    zy += by_y * dz[k];
  }
  out.gradient = Eigen::Vector3d(g[0], g[1], g[2]) / cell_mm;
  out.hessian_per_mm << xx, yx, zx, yx, yy, zy, zx, zy, zz;
  out.hessian_per_mm /= cell_mm * cell_mm;
  return out;
}

}  // namespace vrda::geometry
