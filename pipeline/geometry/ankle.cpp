#include "geometry/ankle.hpp"

#include <algorithm>
#include <cmath>

#include "geometry/level_set.hpp"

namespace vrda::geometry {
namespace {

constexpr double ankle_rounding_mm = 2.0;
// Edges of a tenth of the trochlea's radius.
constexpr double ankle_cells_a_radius = 10.0;
constexpr double tibia_wall_mm = 14.0;      // above the top of the trochlea
constexpr double malleolus_mm = 8.0;        // its thickness
constexpr double malleolus_space_mm = 1.5;  // between it and the trochlea

LevelSetOptions ankle_options(const AnkleParameters& plan)
{
  LevelSetOptions options;
  options.cell_mm = plan.radius_mm / (ankle_cells_a_radius * plan.resolution);
  return options;
}

// Radius of the trochlea at z: smallest in the middle.
double profile_mm(const AnkleParameters& plan, double z_mm)
{
  return plan.radius_mm + plan.groove_mm -
         std::sqrt(std::max(plan.groove_mm * plan.groove_mm - z_mm * z_mm, 0.0));
}

double from_axis_mm(const Eigen::Vector3d& p)
{
  return std::sqrt(p.x() * p.x() + p.y() * p.y());
}

// Inside a block with rounded edges.
double block(const Eigen::Vector3d& p, const Eigen::Vector3d& min_mm, const Eigen::Vector3d& max_mm)
{
  const Eigen::Vector3d off = (min_mm - p).cwiseMax(p - max_mm);
  return smooth_max(smooth_max(off.x(), off.y(), ankle_rounding_mm), off.z(), ankle_rounding_mm);
}

Mesh talus(const AnkleParameters& plan)
{
  const double half_mm = 0.5 * plan.width_mm;
  const Field field = [=](const Eigen::Vector3d& p) {
    const double ends =
        smooth_max(std::abs(p.z()) - half_mm, -0.7 * plan.radius_mm - p.y(), ankle_rounding_mm);
    return smooth_max(from_axis_mm(p) - profile_mm(plan, p.z()), ends, ankle_rounding_mm);
  };
  const double reach_mm = 1.5 * plan.radius_mm + half_mm;
  return level_set_mesh(field, {Eigen::Vector3d::Constant(-reach_mm), Eigen::Vector3d::Constant(reach_mm)},
                        ankle_options(plan));
}

Mesh tibia_of_ankle(const AnkleParameters& plan)
{
  const double half_mm = 0.5 * plan.width_mm, wall_mm = half_mm + malleolus_space_mm;
  const double top_mm = plan.radius_mm + plan.clearance_mm + tibia_wall_mm;
  const Field field = [=](const Eigen::Vector3d& p) {
    // The roof covers 60 degrees to the front and to the back.
    const double roof = block(p, {-plan.radius_mm, 0.5 * plan.radius_mm, -wall_mm - malleolus_mm},
                              {plan.radius_mm, top_mm, wall_mm});
    const double cavity = profile_mm(plan, p.z()) + plan.clearance_mm - from_axis_mm(p);
    const double malleolus = block(p, {-0.5 * plan.radius_mm, -0.6 * plan.radius_mm, -wall_mm - malleolus_mm},
                                   {0.5 * plan.radius_mm, top_mm - 0.5 * tibia_wall_mm, -wall_mm});
    return smooth_min(smooth_max(roof, cavity, ankle_rounding_mm), malleolus, ankle_rounding_mm);
  };
  const double reach_mm = top_mm + plan.width_mm;
  return level_set_mesh(field, {Eigen::Vector3d::Constant(-reach_mm), Eigen::Vector3d::Constant(reach_mm)},
                        ankle_options(plan));
}

}  // namespace

Shape ankle(const AnkleParameters& plan)
{
  return {{{"tibia", "bone", true, tibia_of_ankle(plan)}}, {{"talus", "bone", true, talus(plan)}}};
}

}  // namespace vrda::geometry
