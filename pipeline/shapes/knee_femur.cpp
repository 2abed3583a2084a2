#include <algorithm>
#include <array>
#include <cmath>

#include "core/units.hpp"
#include "shapes/knee.hpp"
#include "shapes/smooth_ops.hpp"

namespace vrda {
namespace {

// Above this height the femur is only drawn.
constexpr double cut_mm = 30.0;
// How far the drawn shaft reaches into the condylar part, so that no seam shows.
constexpr double overlap_mm = 5.0;
constexpr double shaft_top_mm = 115.0;

struct Ball {
  Eigen::Vector3d centre_mm;
  double radius_mm;
};

// Signed distance from the hulls of successive balls, nearly: radii are interpolated along the axes.
template <std::size_t n>
double chain_of_balls(const std::array<Ball, n>& balls, const Eigen::Vector3d& p)
{
  double nearest = 1e9;
  for (std::size_t k = 0; k + 1 < n; ++k) {
    const Eigen::Vector3d axis = balls[k + 1].centre_mm - balls[k].centre_mm;
    const double t = std::clamp((p - balls[k].centre_mm).dot(axis) / axis.squaredNorm(), 0.0, 1.0);
    const double radius = balls[k].radius_mm + t * (balls[k + 1].radius_mm - balls[k].radius_mm);
    nearest = smooth_min(nearest, (p - balls[k].centre_mm - t * axis).norm() - radius, 2.0);
  }
  return nearest;
}

// The two ridges of the trochlea, from the front of each condyle up and towards the middle; the lateral
// one stands further forward. Their fillet is the groove's floor.
double trochlea(const Eigen::Vector3d& p)
{
  static const std::array<Ball, 4> lateral = {{{{6.0, -4.0, 21.5}, 18.0},
                                               {{15.0, 3.0, 17.0}, 16.0},
                                               {{20.0, 14.0, 13.0}, 13.5},
                                               {{18.0, 27.0, 10.0}, 10.5}}};
  static const std::array<Ball, 4> medial = {{{{9.0, -5.0, -20.5}, 18.5},
                                              {{16.0, 3.0, -16.0}, 15.0},
                                              {{18.5, 13.0, -12.0}, 12.5},
                                              {{17.0, 25.0, -9.0}, 10.0}}};
  return smooth_min(chain_of_balls(lateral, p), chain_of_balls(medial, p), 7.0);
}

// Shaft and the flare that carries the condyles: ellipses changing with height.
double shaft_and_flare(const Eigen::Vector3d& p)
{
  const double low = smooth_step(2.0, 48.0, p.y());
  const double high = smooth_step(35.0, 85.0, p.y());
  const double middle_x = 4.0 + 5.0 * low;
  const double half_depth = 23.0 - 7.0 * low - 2.0 * high;
  const double half_width = 36.0 - 16.0 * low - 5.5 * high;
  const double u = (p.x() - middle_x) / half_depth, w = p.z() / half_width;
  const double side = (std::sqrt(u * u + w * w) - 1.0) * std::min(half_depth, half_width);
  return smooth_max(side, -4.0 - p.y(), 16.0);
}

double epicondyles(const Eigen::Vector3d& p)
{
  const double medial = (p - Eigen::Vector3d(-1.0, 4.0, -32.0)).norm() - 10.5;
  const double lateral = (p - Eigen::Vector3d(-2.0, 3.0, 31.0)).norm() - 10.0;
  return std::min(medial, lateral);
}

// The notch between the condyles: a vault below and behind a roof at about 50 degrees.
double notch(const Eigen::Vector3d& p)
{
  const double roof = 7.5 - (-0.756 * p.x() - 0.655 * p.y());
  return smooth_max(std::abs(p.z()) - 9.5, roof, 9.0);
}

double condyles(const Eigen::Vector3d& p)
{
  static const Condyle medial = medial_condyle();
  static const Condyle lateral = lateral_condyle();
  const double flat_m = smooth_max(signed_distance_mm(medial, p), -p.z() - 40.5, 6.0);
  const double flat_l = smooth_max(signed_distance_mm(lateral, p), p.z() - 39.5, 6.0);
  return std::min(flat_m, flat_l);
}

constexpr double cell_at_resolution_1_mm = 4.55;  // gives about 1,516 triangles below the cut

}  // namespace

Condyle medial_condyle()
{
  Condyle c;
  c.posterior_radius_mm = 23.0;
  c.extra_radius_mm = 17.0;
  c.spiral_end_rad = rad_from_deg(110.0);
  c.shift_mm = {26.196, -12.884};
  c.coronal_radius_mm = 20.0;
  c.z_mm = -22.0;
  c.first_rad = rad_from_deg(-15.0);
  c.last_rad = rad_from_deg(140.0);
  return c;
}

Condyle lateral_condyle()
{
  Condyle c;
  c.posterior_radius_mm = 20.5;
  c.extra_radius_mm = 4.0;
  c.spiral_end_rad = rad_from_deg(110.0);
  c.shift_mm = {3.196, -7.884};
  c.coronal_radius_mm = 19.0;
  c.z_mm = 22.0;
  c.first_rad = rad_from_deg(-30.0);
  c.last_rad = rad_from_deg(140.0);
  return c;
}

double femur_field(const Eigen::Vector3d& p)
{
  const double front = smooth_min(trochlea(p), shaft_and_flare(p), 8.0);
  const double body = smooth_min(front, epicondyles(p), 8.0);
  const double whole = smooth_min(condyles(p), body, 5.0);
  return smooth_max(whole, -notch(p), 4.0);
}

Mesh femur_mesh(double resolution)
{
  LevelSetOptions options;
  options.cell_mm = cell_at_resolution_1_mm / resolution;
  const Field lower = [](const Eigen::Vector3d& p) {
    return smooth_max(femur_field(p), p.y() - cut_mm, 2.0);
  };
  return level_set_mesh(lower, {{-45, -48, -60}, {55, 45, 60}}, options);
}

Mesh femur_shaft_mesh(double resolution)
{
  LevelSetOptions options;
  options.cell_mm = cell_at_resolution_1_mm / resolution;
  const Field upper = [](const Eigen::Vector3d& p) {
    const double above_cut = smooth_max(femur_field(p), cut_mm - overlap_mm - p.y(), 2.0);
    return smooth_max(above_cut, p.y() - shaft_top_mm, 2.0);
  };
  return level_set_mesh(upper, {{-45, 10, -60}, {55, 130, 60}}, options);
}

}  // namespace vrda
