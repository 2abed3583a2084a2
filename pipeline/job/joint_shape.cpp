#include "job/joint_shape.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "core/text.hpp"
#include "geometry/nearest_surface.hpp"

namespace vrda::job {
namespace {

constexpr double facing_band_mm = 4.0;  // cartilage of both sides together
constexpr Eigen::Index most_samples = 2000;
constexpr std::size_t fewest_facing = 20;
// Femoral heads deviate from spheres by up to 1 to 2 mm on radii of 20 to 28 mm.
constexpr double ball_rms_share = 0.04;
constexpr double smallest_ball_mm = 5.0;
constexpr double largest_ball_mm = 60.0;
// Length of the mean direction from the centre: (1 + cos a) / 2 for a cap of half-angle a, here 53 degrees.
constexpr double flattest_cap = 0.8;

std::vector<Eigen::Vector3d> facing_vertices(const Case& loaded)
{
  const geometry::NearestSurface reference(loaded.reference.contact.mesh);
  const Points& vertices = loaded.moving.contact.mesh.vertices_mm;
  if (reference.is_empty()) return {};
  const Eigen::Index step = std::max<Eigen::Index>(1, vertices.rows() / most_samples);
  std::vector<std::pair<double, Eigen::Vector3d>> found;
  double least_mm = std::numeric_limits<double>::infinity();
  for (Eigen::Index v = 0; v < vertices.rows(); v += step) {
    const Eigen::Vector3d p_mm = vertices.row(v);
    geometry::NearestLimits limits;
    limits.max_distance_mm = std::min(least_mm + facing_band_mm, limits.max_distance_mm);
    const geometry::SurfacePoint nearest = reference.nearest(p_mm, limits);
    if (nearest.triangle < 0) continue;
    least_mm = std::min(least_mm, nearest.distance_mm);
    found.emplace_back(nearest.distance_mm, p_mm);
  }
  std::vector<Eigen::Vector3d> facing;
  for (const auto& [distance_mm, p_mm] : found) {
    if (distance_mm <= least_mm + facing_band_mm) facing.push_back(p_mm);
  }
  return facing;
}

// Least squares of |p|^2 = 2 p . c + (r^2 - |c|^2), about the mean of the points.
Sphere sphere_through(const std::vector<Eigen::Vector3d>& points)
{
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : points) mean += p / static_cast<double>(points.size());
  Eigen::Matrix4d A = Eigen::Matrix4d::Zero();
  Eigen::Vector4d b = Eigen::Vector4d::Zero();
  for (const Eigen::Vector3d& p : points) {
    Eigen::Vector4d row;
    row << 2.0 * (p - mean), 1.0;
    A += row * row.transpose();
    b += row * (p - mean).squaredNorm();
  }
  const Eigen::Vector4d x = A.ldlt().solve(b);
  const Eigen::Vector3d c = x.head<3>();
  return {mean + c, std::sqrt(std::max(x[3] + c.squaredNorm(), 0.0))};
}

}  // namespace

std::optional<BallFit> ball_fit(const Case& loaded)
{
  const std::vector<Eigen::Vector3d> points = facing_vertices(loaded);
  if (points.size() < fewest_facing) return std::nullopt;
  BallFit fit;
  fit.sphere = sphere_through(points);
  const auto n = static_cast<double>(points.size());
  double sum_sq = 0.0;
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : points) {
    const Eigen::Vector3d out = p - fit.sphere.centre_mm;
    sum_sq += (out.norm() - fit.sphere.radius_mm) * (out.norm() - fit.sphere.radius_mm);
    direction += out.normalized() / n;
  }
  fit.rms_mm = std::sqrt(sum_sq / n);
  fit.is_ball = fit.rms_mm <= ball_rms_share * fit.sphere.radius_mm && direction.norm() <= flattest_cap &&
                fit.sphere.radius_mm >= smallest_ball_mm && fit.sphere.radius_mm <= largest_ball_mm;
  return fit;
}

std::string joint_shape_warning(const std::string& joint, const Case& loaded)
{
  if (joint == "other") return "";
  const std::optional<BallFit> fit = ball_fit(loaded);
  if (!fit || fit->is_ball == (joint == "hip")) return "";
  const auto tenths = [](double mm) { return shortest_decimal(std::round(10.0 * mm) / 10.0); };
  const std::string sphere = "one sphere (radius " + tenths(fit->sphere.radius_mm) + " mm, off by " +
                             tenths(fit->rms_mm) + " mm RMS)";
  if (fit->is_ball)
    return "joint: \"" + joint + "\", but \"" + loaded.moving.name + "\" faces the reference with " + sphere +
           ", as a hip does; write joint = \"hip\", or \"other\" for another ball joint";
  return "joint: \"hip\", but where \"" + loaded.moving.name + "\" faces the reference it is not part of " +
         sphere +
         "; write joint = \"knee\", \"ankle\" or \"subtalar\" if it is one, else \"other\", or check "
         "the meshes and frames";
}

}  // namespace vrda::job
