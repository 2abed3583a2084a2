// The generic tibia with plateaus and fibula, as signed distance fields and their meshes; canonical axes, mm.
#include <algorithm>
#include <cmath>
#include <utility>

#include "geometry/knee.hpp"
#include "geometry/level_set.hpp"

namespace vrda::geometry {
namespace {

constexpr double tibia_cut_mm = -50.0;     // below it the tibia is only drawn
constexpr double tibia_overlap_mm = 17.0;  // of the drawn shaft with the contact part
constexpr double shaft_end_mm = -145.0;
constexpr double tibia_cell_mm = 3.95;

// A dish along one axis: curvature rise / reach^2 at the bottom, slope rise / reach far out.
double dish(double offset_mm, double rise_mm, double reach_mm)
{
  const double u = offset_mm / reach_mm;
  return rise_mm * (std::sqrt(1.0 + u * u) - 1.0);
}

// Compact bump of height 1: (1 - q)^3, twice continuously differentiable.
double bump(double dx, double dz)
{
  const double rest = std::max(0.0, 1.0 - dx * dx - dz * dz);
  return rest * rest * rest;
}

// Concave in both directions; posterior slope of about 3 degrees from rim to rim, level at the contact point.
double medial_plateau_mm(double x, double z)
{
  static const Eigen::Vector3d rest = medial_contact_point_mm();
  constexpr double slope = 0.08;
  // dish'(rest) = -slope makes the surface level at the contact point.
  constexpr double rise = 1.7, reach = 10.0;
  const double u = slope * reach / rise;
  const double ahead = reach * u / std::sqrt(1.0 - u * u);
  const double sagittal =
      dish(x - rest.x() - ahead, rise, reach) - dish(ahead, rise, reach) + slope * (x - rest.x());
  return rest.y() + sagittal + dish(z - rest.z(), 2.0, 10.0);
}

// Slightly convex from front to back, slightly concave from side to side, posterior slope of 4 degrees.
double lateral_plateau_mm(double x, double z)
{
  static const Eigen::Vector3d rest = lateral_contact_point_mm();
  const double dx = x - rest.x();
  constexpr double slope = 0.07, convex_radius_mm = 140.0;
  return rest.y() + slope * dx - dx * dx / (2.0 * convex_radius_mm) + dish(z - rest.z(), 1.6, 9.0);
}

double eminence_mm(double x, double z)
{
  const double medial = 8.0 * bump((x + 1.0) / 16.0, (z + 5.0) / 9.5);
  const double lateral = 6.5 * bump((x + 3.0) / 14.0, (z - 5.0) / 9.0);
  return smooth_max(medial, lateral, 3.0) - 0.5;
}

// Approximate signed distance from an ellipse.
double ellipse(double dx, double dz, double half_x, double half_z)
{
  const double u = dx / half_x, w = dz / half_z;
  return (std::sqrt(u * u + w * w) - 1.0) * std::min(half_x, half_z);
}

// Outline of the tibial head from above: two lobes and the front between them.
double head_outline(double x, double z)
{
  const double medial = ellipse(x - 3.0, z + 20.0, 25.0, 20.5);
  const double lateral = ellipse(x - 1.0, z - 20.0, 22.5, 20.0);
  const double front = ellipse(x - 7.0, z, 22.0, 24.0);
  return smooth_min(smooth_min(medial, lateral, 6.0), front, 10.0);
}

// Rounded triangular section of the shaft with its edge in front.
double shaft_outline(double x, double z)
{
  return smooth_max(ellipse(x - 4.0, z, 15.0, 13.0), 0.45 * (x - 4.0) + 0.9 * std::abs(z) - 12.0, 8.0);
}

double tuberosity(const Eigen::Vector3d& p)
{
  const Eigen::Vector3d d =
      (p - Eigen::Vector3d(15.5, -64.0, 1.0)).cwiseQuotient(Eigen::Vector3d(1.0, 1.7, 1.0));
  return d.norm() - 8.5;
}

LevelSetOptions tibia_options(double resolution)
{
  LevelSetOptions chosen;
  chosen.cell_mm = tibia_cell_mm / resolution;
  return chosen;
}

LevelSet plateau_part()
{
  const Field upper = [](const Eigen::Vector3d& p) {
    return smooth_max(tibia_field(p), tibia_cut_mm - p.y(), 2.0);
  };
  return {upper, {{-40, tibia_cut_mm - 10, -60}, {50, 0, 60}}};
}

}  // namespace

Eigen::Vector3d medial_contact_point_mm()
{
  const Support p = support(medial_condyle(), 0.0);
  return {-p.slope_mm, -p.value_mm, medial_condyle().z_mm};
}

Eigen::Vector3d lateral_contact_point_mm()
{
  const Support p = support(lateral_condyle(), 0.0);
  return {-p.slope_mm, -p.value_mm, lateral_condyle().z_mm};
}

double plateau_height_mm(double x, double z)
{
  const double w = smooth_step(-10.0, 10.0, z);
  return (1.0 - w) * medial_plateau_mm(x, z) + w * lateral_plateau_mm(x, z) + eminence_mm(x, z);
}

double tibia_field(const Eigen::Vector3d& p)
{
  const double narrowing = smooth_step(30.0, 78.0, -p.y());
  const double backward = 6.0 * smooth_step(30.0, 60.0, -p.y());
  const double side = (1.0 - narrowing) * head_outline(p.x(), p.z()) +
                      narrowing * shaft_outline(p.x() + backward - 6.0, p.z());
  const double with_tuberosity = smooth_min(side, tuberosity(p), 10.0);
  return smooth_max(with_tuberosity, p.y() - plateau_height_mm(p.x(), p.z()), 5.0);
}

double fibula_field(const Eigen::Vector3d& p)
{
  const double narrowing = smooth_step(48.0, 80.0, -p.y());
  const Eigen::Vector3d head = (p - Eigen::Vector3d(-15.0, -50.0, 37.0));
  const double shaft = ellipse(p.x() + 15.0 - 3.0 * narrowing, p.z() - 37.0 + 5.0 * narrowing,
                               7.0 - narrowing, 7.0 - narrowing);
  const double below = smooth_max(shaft, p.y() + 52.0, 3.0);
  return smooth_min(head.cwiseQuotient(Eigen::Vector3d(1.0, 1.25, 1.0)).norm() - 9.5, below, 6.0);
}

BoneMeshes tibia_meshes(double resolution, double drawn_resolution)
{
  const LevelSet upper = plateau_part();
  const Field lower = [](const Eigen::Vector3d& p) {
    const double below_cut = smooth_max(tibia_field(p), p.y() - tibia_cut_mm - tibia_overlap_mm, 2.0);
    return smooth_max(below_cut, shaft_end_mm - p.y(), 2.0);
  };
  const Box box_mm{{-40, shaft_end_mm - 10, -60}, {50, tibia_cut_mm + tibia_overlap_mm + 10, 60}};
  const LevelSetOptions drawn = tibia_options(drawn_resolution);
  auto [contact, shaft] = adjoining_level_set_meshes(upper, {lower, box_mm}, drawn);
  if (resolution != drawn_resolution) {
    contact = level_set_mesh(upper.field, upper.box_mm, tibia_options(resolution));
  }
  hide_shaft_end(
      shaft, [](const Eigen::Vector3d& p) { return p.y() - tibia_cut_mm; }, drawn.cell_mm);
  return {std::move(contact), std::move(shaft)};
}

Mesh fibula_mesh(double resolution)
{
  LevelSetOptions options;
  options.cell_mm = 3.5 / resolution;
  const Field whole = [](const Eigen::Vector3d& p) {
    return smooth_max(fibula_field(p), shaft_end_mm - p.y(), 2.0);
  };
  return level_set_mesh(whole, {{-40, shaft_end_mm - 10, 15}, {10, -30, 60}}, options);
}

}  // namespace vrda::geometry
