// The generic femur, two condyles on a shaft, as a signed distance field and its mesh; canonical axes, mm.
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/units.hpp"
#include "geometry/hull.hpp"
#include "geometry/knee.hpp"
#include "geometry/level_set.hpp"

namespace vrda::geometry {
namespace {

// Above this height the femur is only drawn.
constexpr double femur_cut_mm = 16.0;
// Overlap of the drawn shaft with the condylar part: three triangles beyond its rounded end.
constexpr double femur_overlap_mm = 20.0;
constexpr double shaft_top_mm = 115.0;

double chain_of_hulls(const std::array<Hull, 2>& hulls, const Eigen::Vector3d& p)
{
  return smooth_min(hulls[0].signed_distance_mm(p), hulls[1].signed_distance_mm(p), 6.0);
}

std::array<Hull, 2> chain(const Ball& a, const Ball& b, const Ball& c)
{
  return {Hull(a, b), Hull(b, c)};
}

// The two ridges of the trochlea, from the front of each condyle up and towards the middle; the lateral one
// is further anterior. Their fillet is the floor of the groove.
double trochlea(const Eigen::Vector3d& p)
{
  static const std::array<Hull, 2> lateral =
      chain({{4.0, -4.0, 20.0}, 14.5}, {{17.0, 8.0, 15.0}, 15.0}, {{17.5, 32.0, 9.0}, 9.5});
  static const std::array<Hull, 2> medial =
      chain({{5.0, -4.0, -20.0}, 14.5}, {{16.5, 7.0, -14.0}, 13.5}, {{16.5, 29.0, -8.0}, 9.5});
  return smooth_min(chain_of_hulls(lateral, p), chain_of_hulls(medial, p), 7.0);
}

// Shaft and metaphysis above the condyles: elliptic sections that vary with height.
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
  static const CondyleSurface medial(medial_condyle());
  static const CondyleSurface lateral(lateral_condyle());
  const double flat_m = smooth_max(medial.signed_distance_mm(p), -p.z() - 40.5, 6.0);
  const double flat_l = smooth_max(lateral.signed_distance_mm(p), p.z() - 39.5, 6.0);
  return std::min(flat_m, flat_l);
}

constexpr double femur_cell_mm = 5.05;  // gives about 1,516 triangles below the cut

LevelSetOptions femur_options(double resolution)
{
  LevelSetOptions chosen;
  chosen.cell_mm = femur_cell_mm / resolution;
  return chosen;
}

LevelSet condylar_part()
{
  const Field lower = [](const Eigen::Vector3d& p) {
    return smooth_max(femur_field(p), p.y() - femur_cut_mm, 2.0);
  };
  return {lower, {{-45, -48, -60}, {55, femur_cut_mm + 10, 60}}};
}

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
  const double front = smooth_min(trochlea(p), shaft_and_flare(p), 12.0);
  const double body = smooth_min(front, epicondyles(p), 10.0);
  const double whole = smooth_min(condyles(p), body, 7.0);
  return smooth_max(whole, -notch(p), 4.0);
}

BoneMeshes femur_meshes(double resolution, double drawn_resolution)
{
  const LevelSet lower = condylar_part();
  const Field upper = [](const Eigen::Vector3d& p) {
    const double above_cut = smooth_max(femur_field(p), femur_cut_mm - femur_overlap_mm - p.y(), 2.0);
    return smooth_max(above_cut, p.y() - shaft_top_mm, 2.0);
  };
  const Box box_mm{{-45, femur_cut_mm - femur_overlap_mm - 10, -60}, {55, shaft_top_mm + 10, 60}};
  const LevelSetOptions drawn = femur_options(drawn_resolution);
  auto [contact, shaft] = adjoining_level_set_meshes(lower, {upper, box_mm}, drawn);
  if (resolution != drawn_resolution) {
    contact = level_set_mesh(lower.field, lower.box_mm, femur_options(resolution));
  }
  hide_shaft_end(
      shaft, [](const Eigen::Vector3d& p) { return femur_cut_mm - p.y(); }, drawn.cell_mm);
  return {std::move(contact), std::move(shaft)};
}

}  // namespace vrda::geometry
