#include "geometry/nearest_surface.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>

namespace vrda::geometry {
namespace {

// Independent of the winding: corners in the order of their vertices.
std::array<Eigen::Vector3d, 3> corners_by_vertex(const Mesh& mesh, Eigen::Index t)
{
  std::array<std::int32_t, 3> rows{mesh.triangles(t, 0), mesh.triangles(t, 1), mesh.triangles(t, 2)};
  std::sort(rows.begin(), rows.end());
  return {mesh.vertices_mm.row(rows[0]), mesh.vertices_mm.row(rows[1]), mesh.vertices_mm.row(rows[2])};
}

double fraction_of(double x)
{
  return x - std::floor(x);
}

// The i-th point of a sequence that fills a triangle evenly (Roberts's R2, from the plastic number).
Eigen::Vector3d point_in(const std::array<Eigen::Vector3d, 3>& corner, double i)
{
  double a = fraction_of(0.5 + i * 0.7548776662466927), b = fraction_of(0.5 + i * 0.5698402909980532);
  if (a + b > 1.0) {
    a = 1.0 - a;
    b = 1.0 - b;
  }
  return corner[0] + a * (corner[1] - corner[0]) + b * (corner[2] - corner[0]);
}

}  // namespace

SurfacePoints sample_surface(const Mesh& mesh, int n)
{
  std::vector<double> area_until;  // twice the area of all triangles up to this one
  double sum = 0.0;
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    const auto [a, b, c] = corners(mesh, t);
    sum += (b - a).cross(c - a).norm();
    area_until.push_back(sum);
  }
  if (!(sum > 0.0)) return {Points(0, 3), Points(0, 3)};
  SurfacePoints points{Points(n, 3), Points(n, 3)};
  std::size_t t = 0;
  for (int i = 0; i < n; ++i) {
    const double at = (i + 0.5) / n * sum;
    while (t + 1 < area_until.size() && area_until[t] < at) ++t;
    const auto row = static_cast<Eigen::Index>(t);
    points.positions_mm.row(i) = point_in(corners_by_vertex(mesh, row), i).transpose();
    points.normals.row(i) = face_normal(mesh, row).transpose();
  }
  return points;
}

Mesh cropped(const Mesh& mesh, const Eigen::Vector3d& centre_mm, double radius_mm)
{
  std::vector<Eigen::Index> kept;
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    const auto [a, b, c] = corners(mesh, t);
    if (((a + b + c) / 3.0 - centre_mm).squaredNorm() < radius_mm * radius_mm) kept.push_back(t);
  }
  return select_triangles(mesh, kept);
}

SurfacePoints mirrored_z(const SurfacePoints& points)
{
  SurfacePoints mirrored = points;
  mirrored.positions_mm.col(2) *= -1.0;
  mirrored.normals.col(2) *= -1.0;
  return mirrored;
}

SurfacePoints joined(const SurfacePoints& a, const SurfacePoints& b)
{
  SurfacePoints both{Points(a.positions_mm.rows() + b.positions_mm.rows(), 3), Points()};
  both.positions_mm << a.positions_mm, b.positions_mm;
  both.normals.resize(both.positions_mm.rows(), 3);
  both.normals << a.normals, b.normals;
  return both;
}

void NormalBounds::add(const NormalBounds& other)
{
  least = least.min(other.least);
  most = most.max(other.most);
}

bool NormalBounds::may_exceed(double least_cosine, const Eigen::Vector3d& normal) const
{
  double most_cosine = 1e-12;  // for rounding
  for (Eigen::Index k = 0; k < 3; ++k) most_cosine += normal[k] * (normal[k] > 0.0 ? most[k] : least[k]);
  return most_cosine > least_cosine;
}

PointTree::PointTree(SurfacePoints points) : points_(std::move(points))
{
  std::vector<Eigen::Index> order(static_cast<std::size_t>(points_.positions_mm.rows()));
  std::iota(order.begin(), order.end(), 0);
  arrange(order, {0, points_.positions_mm.rows(), 0});
  SurfacePoints arranged{points_.positions_mm(order, Eigen::all), points_.normals(order, Eigen::all)};
  points_ = std::move(arranged);
  bounds_.resize(order.size());
  bound({0, points_.positions_mm.rows(), 0});
}

void PointTree::arrange(std::vector<Eigen::Index>& order, Range range) const
{
  if (range.is_empty()) return;
  std::nth_element(order.begin() + range.begin, order.begin() + range.middle(), order.begin() + range.end,
                   [&](Eigen::Index l, Eigen::Index r) {
                     const double a = points_.positions_mm(l, range.axis);
                     const double b = points_.positions_mm(r, range.axis);
                     return a != b ? a < b : l < r;
                   });
  arrange(order, range.below());
  arrange(order, range.above());
}

void PointTree::bound(Range range)
{
  if (range.is_empty()) return;
  const Eigen::Index n = range.end - range.begin;
  const auto positions_mm = points_.positions_mm.middleRows(range.begin, n);
  const auto normals = points_.normals.middleRows(range.begin, n);
  bounds_[static_cast<std::size_t>(range.middle())] = {
      positions_mm.colwise().minCoeff(),
      positions_mm.colwise().maxCoeff(),
      {normals.colwise().minCoeff(), normals.colwise().maxCoeff()}};
  bound(range.below());
  bound(range.above());
}

double PointTree::Bounds::distance_sq_mm2(const Eigen::Vector3d& p_mm) const
{
  double sum = 0.0;
  for (Eigen::Index k = 0; k < 3; ++k) {
    const double off_mm = std::max({least_mm[k] - p_mm[k], p_mm[k] - most_mm[k], 0.0});
    sum += off_mm * off_mm;
  }
  return sum;
}

PointTree::Nearest PointTree::nearest(const Eigen::Vector3d& p_mm, const Eigen::Vector3d& normal,
                                      double least_cosine, Eigen::Index start) const
{
  struct Task {
    Range range;
    double least_sq_mm2;
  };
  std::array<Task, 64> stack;
  std::size_t n_tasks = 0;
  Nearest best{-1, std::numeric_limits<double>::infinity()};
  const auto offer = [&](Eigen::Index row) {
    const double distance_sq = (points_.positions_mm.row(row).transpose() - p_mm).squaredNorm();
    if (distance_sq < best.distance_sq_mm2 && points_.normals.row(row).dot(normal.transpose()) > least_cosine)
      best = {row, distance_sq};
  };
  const auto add = [&](const Range& range) {
    if (range.is_empty()) return;
    const Bounds& bounds = bounds_[static_cast<std::size_t>(range.middle())];
    const double least_sq_mm2 = bounds.distance_sq_mm2(p_mm);
    if (least_sq_mm2 < best.distance_sq_mm2 && bounds.normals.may_exceed(least_cosine, normal))
      stack[n_tasks++] = {range, least_sq_mm2};
  };
  if (start >= 0) offer(start);
  add({0, points_.positions_mm.rows(), 0});
  while (n_tasks > 0) {
    const Task task = stack[--n_tasks];
    if (task.least_sq_mm2 >= best.distance_sq_mm2) continue;
    const Range& range = task.range;
    if (range.end - range.begin <= most_at_once) {
      for (Eigen::Index row = range.begin; row < range.end; ++row) offer(row);
      continue;
    }
    const Eigen::Index middle = range.middle();
    offer(middle);
    const bool is_below = p_mm[range.axis] < points_.positions_mm(middle, range.axis);
    add(is_below ? range.above() : range.below());
    add(is_below ? range.below() : range.above());
  }
  return best;
}

namespace {

// Normals of triangles averaged over some 3 mm around, each weighted by its area.
Points smoothed_normals(const Mesh& mesh)
{
  constexpr double around_mm = 3.0;
  constexpr int most_rounds = 12;
  Eigen::VectorXd area(mesh.triangles.rows());
  Points own(mesh.triangles.rows(), 3);
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    const auto [a, b, c] = corners(mesh, t);
    area[t] = (b - a).cross(c - a).norm();
    own.row(t) = face_normal(mesh, t).transpose();
  }
  // A round averages over about an edge, and rounds add up like steps of a random walk.
  const double edges = mesh.triangles.rows() == 0 ? 0.0 : around_mm / mean_edge_length_mm(mesh);
  const int n_rounds = static_cast<int>(std::min(edges * edges, static_cast<double>(most_rounds)));
  Points normals = own;
  for (int round = 0; round < n_rounds; ++round) {
    Points at_vertex = Points::Zero(mesh.vertices_mm.rows(), 3);
    for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
      for (const std::int32_t row : mesh.triangles.row(t)) at_vertex.row(row) += area[t] * normals.row(t);
    }
    for (auto sum : at_vertex.rowwise()) sum.stableNormalize();
    for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
      Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
      for (const std::int32_t row : mesh.triangles.row(t)) sum += at_vertex.row(row);
      if (sum.squaredNorm() > 0.0) normals.row(t) = sum.normalized();
    }
  }
  // At the rim of a thin layer the two sides cancel out.
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    if (normals.row(t).dot(own.row(t)) < 0.2) normals.row(t) = own.row(t);
  }
  return normals;
}

// A pass of Laplacian smoothing; vertices with `is_fixed` stay.
void relax(Mesh& mesh, const std::vector<bool>& is_fixed, double factor)
{
  Points sum = Points::Zero(mesh.vertices_mm.rows(), 3);
  Eigen::VectorXd n = Eigen::VectorXd::Zero(mesh.vertices_mm.rows());
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    for (Eigen::Index k = 0; k < 3; ++k) {
      const std::int32_t at = mesh.triangles(t, k), next = mesh.triangles(t, (k + 1) % 3);
      sum.row(at) += mesh.vertices_mm.row(next);
      n[at] += 1.0;
    }
  }
  for (Eigen::Index v = 0; v < mesh.vertices_mm.rows(); ++v) {
    if (n[v] == 0.0 || is_fixed[static_cast<std::size_t>(v)]) continue;
    mesh.vertices_mm.row(v) += factor * (sum.row(v) / n[v] - mesh.vertices_mm.row(v));
  }
}

double distance_sq_mm2(const Eigen::Vector3d& p, const geometry::BoxTree::Node& node)
{
  double sum = 0.0;
  for (std::size_t k = 0; k < 3; ++k) {
    const double x = p[static_cast<Eigen::Index>(k)];
    const double off = std::max({node.min_mm[k] - x, x - node.max_mm[k], 0.0});
    sum += off * off;
  }
  return sum;
}

}  // namespace

std::vector<bool> rim_vertices(const Mesh& mesh)
{
  // Where the triangles close a ring, its neighbours cancel out.
  std::vector<std::int64_t> ring(static_cast<std::size_t>(mesh.vertices_mm.rows()), 0);
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    for (Eigen::Index k = 0; k < 3; ++k)
      ring[static_cast<std::size_t>(mesh.triangles(t, k))] +=
          mesh.triangles(t, (k + 1) % 3) - mesh.triangles(t, (k + 2) % 3);
  }
  std::vector<bool> is_rim;
  for (const std::int64_t sum : ring) is_rim.push_back(sum != 0);
  return is_rim;
}

Eigen::Vector3d nearest_in_triangle(const Eigen::Vector3d& p, const std::array<Eigen::Vector3d, 3>& corner)
{
  const auto& [a, b, c] = corner;
  const Eigen::Vector3d ab = b - a, ac = c - a, ap = p - a;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0.0 && d2 <= 0.0) return a;
  const Eigen::Vector3d bp = p - b;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0.0 && d4 <= d3) return b;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return a + d1 / (d1 - d3) * ab;
  const Eigen::Vector3d cp = p - c;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0.0 && d5 <= d6) return c;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return a + d2 / (d2 - d6) * ac;
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0) return b + (d4 - d3) / (d4 - d3 + d5 - d6) * (c - b);
  const double sum = va + vb + vc;
  return a + vb / sum * ab + vc / sum * ac;
}

Mesh without_noise(Mesh mesh)
{
  // Taubin (1995): shrinks and expands alternately, so that shapes of some edges keep their size.
  constexpr double shrink = 0.5, swell = -0.53;
  constexpr double around_mm = 2.5;
  constexpr int most_rounds = 10;
  if (mesh.triangles.rows() == 0) return mesh;
  const double edges = around_mm / mean_edge_length_mm(mesh);
  const int n_rounds = static_cast<int>(std::min(edges * edges, static_cast<double>(most_rounds)));
  const std::vector<bool> is_rim = rim_vertices(mesh);
  for (int round = 0; round < n_rounds; ++round) {
    relax(mesh, is_rim, shrink);
    relax(mesh, is_rim, swell);
  }
  return mesh;
}

NearestSurface::NearestSurface(Mesh mesh)
    : mesh_(std::move(mesh)),
      normals_(smoothed_normals(mesh_)),
      is_rim_(rim_vertices(mesh_)),
      tree_(mesh_),
      normal_bounds_(tree_.nodes().size())
{
  for (std::size_t i = tree_.nodes().size(); i-- > 0;) {  // children come after their parent
    const geometry::BoxTree::Node& node = tree_.nodes()[i];
    NormalBounds& bounds = normal_bounds_[i];
    if (!node.is_leaf()) {
      bounds.add(normal_bounds_[i + 1]);
      bounds.add(normal_bounds_[static_cast<std::size_t>(node.first)]);
      continue;
    }
    for (std::int32_t k = node.first; k < node.first + node.count; ++k) {
      const Eigen::Array3d normal = normals_.row(tree_.order()[static_cast<std::size_t>(k)]).transpose();
      bounds.add({normal, normal});
    }
  }
}

bool NearestSurface::is_at_rim(Eigen::Index triangle) const
{
  const Eigen::RowVector3i rows = mesh_.triangles.row(triangle);
  return std::any_of(rows.begin(), rows.end(),
                     [&](std::int32_t row) { return is_rim_[static_cast<std::size_t>(row)]; });
}

bool NearestSurface::is_behind(const Eigen::Vector3d& p_mm, const SurfacePoint& on) const
{
  // A point in front of a sharp edge may be behind one of its faces, but never along the normal.
  constexpr double least_cosine = 0.5;
  return !is_at_rim(on.triangle) &&
         (p_mm - on.p_mm).dot(normal(on.triangle)) < -least_cosine * on.distance_mm;
}

SurfacePoint NearestSurface::nearest(const Eigen::Vector3d& p_mm, const NearestLimits& limits) const
{
  SurfacePoint best;
  if (tree_.is_empty()) return best;
  struct Task {
    std::int32_t node = 0;
    double least_sq_mm2 = 0.0;
  };
  const bool is_limited = limits.least_cosine >= -1.0;
  double best_sq = limits.max_distance_mm * limits.max_distance_mm;
  std::array<Task, 64> stack;
  std::size_t n_tasks = 0;
  stack[n_tasks++] = {0, distance_sq_mm2(p_mm, tree_.nodes()[0])};
  while (n_tasks > 0) {
    const Task task = stack[--n_tasks];
    if (task.least_sq_mm2 > best_sq) continue;
    if (is_limited &&
        !normal_bounds_[static_cast<std::size_t>(task.node)].may_exceed(limits.least_cosine, limits.normal))
      continue;
    const geometry::BoxTree::Node& node = tree_.nodes()[static_cast<std::size_t>(task.node)];
    if (!node.is_leaf()) {
      Task near{task.node + 1, distance_sq_mm2(p_mm, tree_.nodes()[static_cast<std::size_t>(task.node) + 1])};
      Task far{node.first, distance_sq_mm2(p_mm, tree_.nodes()[static_cast<std::size_t>(node.first)])};
      if (far.least_sq_mm2 < near.least_sq_mm2) std::swap(near, far);
      stack[n_tasks++] = far;
      stack[n_tasks++] = near;
      continue;
    }
    for (std::int32_t k = node.first; k < node.first + node.count; ++k) {
      const Eigen::Index t = tree_.order()[static_cast<std::size_t>(k)];
      if (is_limited && normals_.row(t).dot(limits.normal.transpose()) <= limits.least_cosine) continue;
      const Eigen::Vector3d q_mm = nearest_in_triangle(p_mm, corners(mesh_, t));
      const double sq = (q_mm - p_mm).squaredNorm();
      if (sq > best_sq || (sq == best_sq && best.triangle >= 0 && t > best.triangle)) continue;
      best_sq = sq;
      best = {t, q_mm, std::sqrt(sq)};
    }
  }
  return best;
}

}  // namespace vrda::geometry
