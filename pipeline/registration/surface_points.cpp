#include "registration/surface_points.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace vrda::registration {
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

PointTree::PointTree(SurfacePoints points) : points_(std::move(points))
{
  std::vector<Eigen::Index> order(static_cast<std::size_t>(points_.positions_mm.rows()));
  std::iota(order.begin(), order.end(), 0);
  arrange(order, {0, points_.positions_mm.rows(), 0});
  SurfacePoints arranged{points_.positions_mm(order, Eigen::all), points_.normals(order, Eigen::all)};
  points_ = std::move(arranged);
}

void PointTree::arrange(std::vector<Eigen::Index>& order, Range range) const
{
  if (range.end - range.begin < 2) return;
  const Eigen::Index middle = (range.begin + range.end) / 2;
  std::nth_element(order.begin() + range.begin, order.begin() + middle, order.begin() + range.end,
                   [&](Eigen::Index l, Eigen::Index r) {
                     const double a = points_.positions_mm(l, range.axis);
                     const double b = points_.positions_mm(r, range.axis);
                     return a != b ? a < b : l < r;
                   });
  const int next = (range.axis + 1) % 3;
  arrange(order, {range.begin, middle, next});
  arrange(order, {middle + 1, range.end, next});
}

PointTree::Nearest PointTree::nearest(const Eigen::Vector3d& p_mm, const Eigen::Vector3d& normal,
                                      double least_cosine) const
{
  struct Task {
    Range range;
    double least_sq_mm2;  // distance of the range's half-space
  };
  std::array<Task, 64> stack;
  std::size_t n_tasks = 0;
  stack[n_tasks++] = {{0, points_.positions_mm.rows(), 0}, 0.0};
  Nearest best{-1, std::numeric_limits<double>::infinity()};
  while (n_tasks > 0) {
    const Task task = stack[--n_tasks];
    const Range& range = task.range;
    if (range.begin >= range.end || task.least_sq_mm2 >= best.distance_sq_mm2) continue;
    const Eigen::Index middle = (range.begin + range.end) / 2;
    const double distance_sq = (points_.positions_mm.row(middle).transpose() - p_mm).squaredNorm();
    if (distance_sq < best.distance_sq_mm2 &&
        points_.normals.row(middle).dot(normal.transpose()) > least_cosine)
      best = {middle, distance_sq};
    const double off = p_mm[range.axis] - points_.positions_mm(middle, range.axis);
    const int next = (range.axis + 1) % 3;
    const Range below{range.begin, middle, next}, above{middle + 1, range.end, next};
    stack[n_tasks++] = {off < 0.0 ? above : below, off * off};
    stack[n_tasks++] = {off < 0.0 ? below : above, task.least_sq_mm2};
  }
  return best;
}

}  // namespace vrda::registration
