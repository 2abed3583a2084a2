// Triangulation of polygons.
#include "job/clean_mesh.hpp"

#include <cmath>
#include <numeric>

namespace vrda::job {
namespace {

using Outline = std::vector<Eigen::Vector2d>;  // corners in the plane of the polygon

// Newell's normal: the sum of the areas projected on the coordinate planes.
Eigen::Vector3d newell_normal(const Points& corners)
{
  // Relative to the first corner, for precision far from the origin.
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  for (Eigen::Index k = 1; k + 1 < corners.rows(); ++k) {
    const Eigen::Vector3d a = (corners.row(k) - corners.row(0)).transpose();
    const Eigen::Vector3d b = (corners.row(k + 1) - corners.row(0)).transpose();
    normal += a.cross(b);
  }
  return normal;
}

Outline projected(const Points& corners, const Eigen::Vector3d& normal)
{
  const Eigen::Vector3d n = normal.normalized();
  Eigen::Index least = 0;
  n.cwiseAbs().minCoeff(&least);
  const Eigen::Vector3d u = n.cross(Eigen::Vector3d::Unit(least)).normalized();
  const Eigen::Vector3d v = n.cross(u);
  Outline flat;
  for (Eigen::Index k = 0; k < corners.rows(); ++k) {
    const Eigen::Vector3d p = (corners.row(k) - corners.row(0)).transpose();
    flat.emplace_back(p.dot(u), p.dot(v));
  }
  return flat;
}

double turn(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c)
{
  return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

bool covers(const Outline& flat, const std::array<std::int32_t, 3>& ear, std::int32_t corner)
{
  const auto at = [&](std::int32_t k) -> const Eigen::Vector2d& { return flat[static_cast<std::size_t>(k)]; };
  const Eigen::Vector2d& p = at(corner);
  if (p == at(ear[0]) || p == at(ear[1]) || p == at(ear[2])) return false;
  return turn(at(ear[0]), at(ear[1]), p) >= 0.0 && turn(at(ear[1]), at(ear[2]), p) >= 0.0 &&
         turn(at(ear[2]), at(ear[0]), p) >= 0.0;
}

std::array<std::int32_t, 3> ear_at(const std::vector<std::int32_t>& remaining, std::size_t k)
{
  const std::size_t n = remaining.size();
  return {remaining[(k + n - 1) % n], remaining[k], remaining[(k + 1) % n]};
}

bool is_ear(const Outline& flat, const std::vector<std::int32_t>& remaining, std::size_t k, double least_area)
{
  const std::array<std::int32_t, 3> ear = ear_at(remaining, k);
  const auto at = [&](std::int32_t i) -> const Eigen::Vector2d& { return flat[static_cast<std::size_t>(i)]; };
  if (turn(at(ear[0]), at(ear[1]), at(ear[2])) <= least_area) return false;
  for (const std::int32_t other : remaining) {
    if (other != ear[0] && other != ear[1] && other != ear[2] && covers(flat, ear, other)) return false;
  }
  return true;
}

// The position of the next ear; the number of remaining corners if none exists.
std::size_t next_ear(const Outline& flat, const std::vector<std::int32_t>& remaining, double least_area)
{
  std::size_t k = 0;
  while (k < remaining.size() && !is_ear(flat, remaining, k, least_area)) ++k;
  return k;
}

}  // namespace

std::vector<std::array<std::int32_t, 3>> triangulate(const Points& corners_mm)
{
  std::vector<std::array<std::int32_t, 3>> triangles;
  if (corners_mm.rows() == 3) return {{0, 1, 2}};
  const Eigen::Vector3d normal = newell_normal(corners_mm);
  if (!(normal.norm() > 0.0)) return triangles;
  const Outline flat = projected(corners_mm, normal);
  // Ears below rounding would be slivers along an edge; they are postponed.
  const double least_area = 1e-12 * normal.norm();
  std::vector<std::int32_t> remaining(flat.size());
  std::iota(remaining.begin(), remaining.end(), 0);
  while (remaining.size() > 3) {
    const std::size_t k = next_ear(flat, remaining, least_area);
    if (k == remaining.size()) break;
    triangles.push_back(ear_at(remaining, k));
    remaining.erase(remaining.begin() + static_cast<std::ptrdiff_t>(k));
  }
  for (std::size_t k = 1; k + 1 < remaining.size(); ++k)
    triangles.push_back({remaining[0], remaining[k], remaining[k + 1]});
  return triangles;
}

}  // namespace vrda::job
