#include "geometry/surface_points.hpp"

#include <algorithm>
#include <array>
#include <cmath>
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
  constexpr double rounding = 1e-12;
  const Eigen::Array3d n = normal.array();
  return (least * n).max(most * n).sum() + rounding > least_cosine;
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
  const Eigen::Array3d p = p_mm.array();
  return (least_mm - p).max(p - most_mm).max(0.0).matrix().squaredNorm();
}

PointTree::Nearest PointTree::nearest(const Eigen::Vector3d& p_mm, const Eigen::Vector3d& normal,
                                      double least_cosine) const
{
  struct Task {
    Range range;
    double least_sq_mm2;
  };
  std::array<Task, 64> stack;
  std::size_t n_tasks = 0;
  Nearest best{-1, std::numeric_limits<double>::infinity()};
  const auto add = [&](const Range& range) {
    if (range.is_empty()) return;
    const Bounds& bounds = bounds_[static_cast<std::size_t>(range.middle())];
    const double least_sq_mm2 = bounds.distance_sq_mm2(p_mm);
    if (least_sq_mm2 < best.distance_sq_mm2 && bounds.normals.may_exceed(least_cosine, normal))
      stack[n_tasks++] = {range, least_sq_mm2};
  };
  add({0, points_.positions_mm.rows(), 0});
  while (n_tasks > 0) {
    const Task task = stack[--n_tasks];
    if (task.least_sq_mm2 >= best.distance_sq_mm2) continue;
    const Range& range = task.range;
    const Eigen::Index middle = range.middle();
    const double distance_sq = (points_.positions_mm.row(middle).transpose() - p_mm).squaredNorm();
    if (distance_sq < best.distance_sq_mm2 &&
        points_.normals.row(middle).dot(normal.transpose()) > least_cosine)
      best = {middle, distance_sq};
    const bool is_below = p_mm[range.axis] < points_.positions_mm(middle, range.axis);
    add(is_below ? range.above() : range.below());
    add(is_below ? range.below() : range.above());
  }
  return best;
}

}  // namespace vrda::geometry
