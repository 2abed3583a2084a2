#include "geometry/scenes.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "core/error.hpp"
#include "model/frames.hpp"
#include "core/trig.hpp"
#include "core/units.hpp"
#include "geometry/surface.hpp"

namespace vrda::geometry {
namespace {

// Material thickness above the deepest point of a cavity.
constexpr double backing_mm = 6.0;

Mesh placed(const Mesh& mesh, double turn_deg, const Eigen::Vector3d& shift_mm)
{
  return transformed(mesh, pose_of({shift_mm, rad_from_deg(turn_deg)}));
}

Shape pair_of(std::string reference_name, Mesh reference, std::string moving_name, Mesh moving)
{
  return {{{std::move(reference_name), "bone", true, std::move(reference)}},
          {{std::move(moving_name), "bone", true, std::move(moving)}}};
}

double bowl_depth_mm(double radius_mm, double from_axis_mm)
{
  return radius_mm - std::sqrt(radius_mm * radius_mm - from_axis_mm * from_axis_mm);
}

// Depth of the dish's surface below the origin's height, at a distance from its axis.
double dish_depth_mm(const BallInDishParameters& plan, double from_axis_mm)
{
  if (plan.section == DishSection::bowl) return bowl_depth_mm(plan.dish_radius_mm, from_axis_mm);
  const double half_mm = 0.5 * plan.dish_width_mm;
  const double slope = bowl_depth_mm(plan.dish_radius_mm, half_mm) / half_mm;
  if (plan.section == DishSection::cone) return slope * from_axis_mm;
  // The slope oscillates by 0.7 of its mean, with four periods over the half width.
  const double wave_per_mm = 2.0 * pi * 4.0 / half_mm;
  return slope * (from_axis_mm - 0.7 / wave_per_mm * sine(wave_per_mm * from_axis_mm));
}

Mesh dish(const BallInDishParameters& plan)
{
  const double half_mm = 0.5 * plan.dish_width_mm;
  ShapedBlock block;
  append_lines(block.x_mm, -half_mm, 0.0, plan.dish_edges);
  append_lines(block.x_mm, 0.0, half_mm, plan.dish_edges);
  block.z_mm = block.x_mm;
  block.front_y_mm = [&](double x, double z) { return -dish_depth_mm(plan, std::sqrt(x * x + z * z)); };
  block.back_y_mm = backing_mm;
  block.hole_half_mm = 0.5 * plan.hole_mm;
  return block_mesh(block);
}

double pyramid_mm(double height_mm, double half_base_mm, double dx, double dz)
{
  return height_mm * std::max(0.0, 1.0 - std::max(std::abs(dx), std::abs(dz)) / half_base_mm);
}

Mesh pyramids(const BarOnPyramidsParameters& plan)
{
  const double half_mm = 0.5 * plan.base_mm;
  const double middle_mm = 0.5 * plan.gap_mm + half_mm;
  ShapedBlock block;
  append_lines(block.x_mm, -middle_mm - half_mm, -middle_mm, plan.edges);
  append_lines(block.x_mm, -middle_mm, -middle_mm + half_mm, plan.edges);
  append_lines(block.x_mm, -middle_mm + half_mm, middle_mm - half_mm, plan.edges);
  append_lines(block.x_mm, middle_mm - half_mm, middle_mm, plan.edges);
  append_lines(block.x_mm, middle_mm, middle_mm + half_mm, plan.edges);
  append_lines(block.z_mm, -half_mm, 0.0, plan.edges);
  append_lines(block.z_mm, 0.0, half_mm, plan.edges);
  block.front_y_mm = [&](double x, double z) {
    return -pyramid_mm(plan.height_mm, half_mm, std::abs(x) - middle_mm, z);
  };
  block.back_y_mm = backing_mm;
  return block_mesh(block);
}

// A box with its upper face at y = 0.
Mesh bar(const BarOnPyramidsParameters& plan)
{
  ShapedBlock block;
  append_lines(block.x_mm, -0.5 * plan.bar_width_mm, 0.5 * plan.bar_width_mm, plan.edges);
  append_lines(block.z_mm, -0.5 * plan.bar_length_mm, 0.5 * plan.bar_length_mm, 4 * plan.edges);
  block.front_y_mm = [](double, double) { return 0.0; };
  block.back_y_mm = -plan.bar_height_mm;
  return block_mesh(block);
}

// A pyramid with its tip at the origin; the sink is the same surface seen from below, with its back above.
// With one edge along half a base every face is a single triangle, as in thesis 3.7; with more, a grid.
Mesh pyramid_mesh(double half_base_mm, double depth_mm, double back_y_mm, int edges)
{
  if (edges == 1) return plain_pyramid_mesh(half_base_mm, -depth_mm, back_y_mm);
  ShapedBlock block;
  append_lines(block.x_mm, -half_base_mm, 0.0, edges);
  append_lines(block.x_mm, 0.0, half_base_mm, edges);
  block.z_mm = block.x_mm;
  block.front_y_mm = [=](double x, double z) { return pyramid_mm(depth_mm, half_base_mm, x, z) - depth_mm; };
  block.back_y_mm = back_y_mm;
  return block_mesh(block);
}

}  // namespace

Shape ball_in_dish(const BallInDishParameters& plan)
{
  // The block's corners must stay inside the ball's equator, where the bowl would be vertical.
  constexpr double widest = 0.95;
  const double corner_mm = plan.dish_width_mm / std::sqrt(2.0);
  if (corner_mm > widest * plan.dish_radius_mm) {
    throw InputError({"shape ball-in-dish", "dish_width", std::to_string(plan.dish_width_mm),
                      "at most " + std::to_string(widest * std::sqrt(2.0) * plan.dish_radius_mm) +
                          " mm for this dish_radius"});
  }
  // A rim of at least one cell must be left around the hole.
  const double widest_hole_mm = plan.dish_width_mm * (1.0 - 1.0 / plan.dish_edges);
  if (plan.hole_mm > 0.0 && plan.hole_mm >= widest_hole_mm) {
    throw InputError(
        {"shape ball-in-dish", "hole", std::to_string(plan.hole_mm),
         "less than " + std::to_string(widest_hole_mm) + " mm for this dish_width and dish_edges"});
  }
  const Eigen::Vector3d half_axes_mm = plan.ball_radius_mm * plan.stretch;
  const double top_mm = -dish_depth_mm(plan, corner_mm) - plan.initial_clearance_mm;
  const Eigen::Vector3d shift_mm(plan.offset_x_mm, top_mm - half_axes_mm.y(), plan.offset_z_mm);
  return pair_of("dish", dish(plan), "ball",
                 placed(ellipsoid_mesh(half_axes_mm, plan.ball_edges), plan.turn_deg, shift_mm));
}

Shape bar_on_pyramids(const BarOnPyramidsParameters& plan)
{
  const Eigen::Vector3d shift_mm(plan.offset_x_mm, -plan.height_mm - plan.initial_clearance_mm,
                                 plan.offset_z_mm);
  return pair_of("pyramids", pyramids(plan), "bar", placed(bar(plan), plan.turn_deg, shift_mm));
}

Shape cap_in_sink(const CapInSinkParameters& plan)
{
  const double cap_half_mm = 0.5 * plan.cap_scale * plan.base_mm,
               cap_depth_mm = plan.cap_scale * plan.depth_mm;
  const Eigen::Vector3d shift_mm(plan.offset_x_mm, -plan.depth_mm - plan.initial_clearance_mm,
                                 plan.offset_z_mm);
  return pair_of("sink", pyramid_mesh(0.5 * plan.base_mm, plan.depth_mm, backing_mm, plan.edges), "cap",
                 placed(pyramid_mesh(cap_half_mm, cap_depth_mm, -cap_depth_mm - backing_mm, plan.edges),
                        plan.turn_deg, shift_mm));
}

}  // namespace vrda::geometry
