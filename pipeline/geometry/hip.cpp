#include "geometry/hip.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/error.hpp"
#include "model/frames.hpp"
#include "core/trig.hpp"
#include "core/units.hpp"
#include "geometry/level_set.hpp"

namespace vrda::geometry {
namespace {

constexpr double rim_rounding_mm = 1.5;
// Edges of a tenth of the radius: about 3,500 triangles on the socket at resolution 1.
constexpr double cells_a_radius = 10.0;

LevelSetOptions options_for(const HipParameters& plan)
{
  LevelSetOptions options;
  options.cell_mm = plan.radius_mm / (cells_a_radius * plan.resolution);
  options.cell_mm = std::min(options.cell_mm, 0.6 * plan.wall_mm);
  return options;
}

// Meshed with its opening at -Y: not every direction gives a manifold net.
Mesh socket(const HipParameters& plan)
{
  const double inner_mm = plan.radius_mm + plan.clearance_mm;
  const Field field = [=](const Eigen::Vector3d& p) {
    const double from_centre = p.norm();
    const double wall = std::max(inner_mm - from_centre, from_centre - inner_mm - plan.wall_mm);
    return smooth_max(wall, -plan.depth_mm - p.y(), rim_rounding_mm);
  };
  const double reach_mm = inner_mm + 2.0 * plan.wall_mm;
  const Mesh mesh = level_set_mesh(
      field, {Eigen::Vector3d::Constant(-reach_mm), Eigen::Vector3d::Constant(reach_mm)}, options_for(plan));
  Pose X_canonical_socket = Pose::Identity();
  X_canonical_socket.linear() =
      rotation_x(-rad_from_deg(plan.inclination_deg)) * rotation_z(rad_from_deg(plan.anteversion_deg));
  return transformed(mesh, X_canonical_socket);
}

Mesh head(const HipParameters& plan)
{
  const SinCos lean = sin_cos(rad_from_deg(plan.neck_deg));
  const Eigen::Vector3d axis(0.0, -lean.cos, lean.sin);
  const double length_mm = 2.0 * plan.radius_mm;
  const double neck_mm = plan.radius_mm / plan.neck_ratio;
  const Field field = [=](const Eigen::Vector3d& p) {
    const double along = std::clamp(p.dot(axis), 0.0, length_mm);
    const double neck = (p - along * axis).norm() - neck_mm;
    return smooth_min(p.norm() - plan.radius_mm, neck, 0.15 * plan.radius_mm);
  };
  const double reach_mm = length_mm + 1.5 * neck_mm;
  return level_set_mesh(field, {Eigen::Vector3d::Constant(-reach_mm), Eigen::Vector3d::Constant(reach_mm)},
                        options_for(plan));
}

}  // namespace

Shape hip(const HipParameters& plan)
{
  const double inner_mm = plan.radius_mm + plan.clearance_mm;
  // A rim below the centre must leave an opening for the head; a rim above it must leave a cap.
  const double deepest_mm = std::sqrt(inner_mm * inner_mm - plan.radius_mm * plan.radius_mm);
  const double shallowest_mm = -0.8 * inner_mm;
  if (plan.depth_mm > deepest_mm || plan.depth_mm < shallowest_mm) {
    throw InputError({"shape hip", "depth", std::to_string(plan.depth_mm),
                      "from " + std::to_string(shallowest_mm) + " to " + std::to_string(deepest_mm) +
                          " mm for this radius and clearance, so that the head can enter and is retained"});
  }
  return {{{"socket", "bone", true, socket(plan)}}, {{"head", "bone", true, head(plan)}}};
}

}  // namespace vrda::geometry
