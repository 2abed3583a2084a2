#include "geometry/catalogue.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "core/text.hpp"
#include "core/units.hpp"
#include "geometry/generic_knee.hpp"
#include "geometry/level_set.hpp"
#include "geometry/shapes.hpp"
#include "model/frames.hpp"

namespace vrda::geometry {
namespace {

using Entry = CatalogueEntry;
using Values = ShapeValues;

struct Range {
  double lowest = 0.0;
  double highest = 0.0;
};

ShapeParameter number(std::string name, std::string meaning, std::string unit, double value, Range range)
{
  return {std::move(name), std::move(meaning), std::move(unit), value,
          range.lowest,    range.highest,      false,           {}};
}

ShapeParameter whole(std::string name, std::string meaning, int value, Range range)
{
  ShapeParameter parameter =
      number(std::move(name), std::move(meaning), "", static_cast<double>(value), range);
  parameter.is_integer = true;
  return parameter;
}

ShapeParameter word(std::string name, std::string meaning, std::vector<std::string> choices)
{
  return {std::move(name), std::move(meaning), "", 0.0, 0.0, 0.0, false, std::move(choices)};
}

Shape of_side(Shape shape, const Values& values)
{
  if (values.word("side") == "right") return shape;
  for (std::vector<ShapePart>* parts : {&shape.reference, &shape.moving}) {
    for (ShapePart& part : *parts) part.mesh = mirrored_z(part.mesh);
  }
  return shape;
}

std::vector<ShapeFibre> of_side(std::vector<ShapeFibre> fibres, const Values& values)
{
  if (values.word("side") == "right") return fibres;
  for (ShapeFibre& fibre : fibres) {
    fibre.reference_mm.z() *= -1.0;
    fibre.moving_mm.z() *= -1.0;
  }
  return fibres;
}

// The upper end of the knee's range gives a million triangles.
Entry knee_entry()
{
  return {"knee",
          "a right or left knee: femur, tibia, both menisci; shafts and fibula drawn only",
          {number("resolution", "factor on the number of edges along a line; triangles grow with its square",
                  "", 1.0, {0.5, 15.0}),
           word("side", "which knee", {"right", "left"})},
          [](const Values& values) { return of_side(right_knee(values.number("resolution")), values); },
          [](const Values& values) { return of_side(right_knee_fibres(), values); },
          knee_fibre_sources};
}

Entry template_knee_entry()
{
  return {"knee-template",
          "the knee that vrda prepare registers onto a subject's: femur, tibia; fibula drawn only",
          {word("side", "which knee", {"right", "left"})},
          [](const Values& values) { return of_side(right_template_knee(), values); },
          [](const Values& values) { return of_side(right_template_knee_fibres(), values); },
          template_knee_fibre_sources};
}

Entry hip_entry()
{
  const HipParameters plan;
  return {
      "hip",
      "a spherical head with a neck in a deep socket",
      {number("resolution", "factor on the number of edges along a line", "", plan.resolution, {0.5, 12.0}),
       number("radius", "of the head", "mm", plan.radius_mm, {5.0, 100.0}),
       number("clearance", "inner radius of the socket minus radius of the head", "mm", plan.clearance_mm,
              {0.0, 20.0}),
       number("wall", "thickness of the socket", "mm", plan.wall_mm, {2.0, 50.0}),
       number("depth", "distance of the socket's rim beyond its centre", "mm", plan.depth_mm, {-20.0, 20.0}),
       number("neck", "angle of the neck from -Y, to the right", "deg", plan.neck_deg, {0.0, 80.0}),
       number("neck_ratio", "radius of the head over that of the neck", "", plan.neck_ratio, {1.2, 5.0}),
       number("inclination", "angle of the socket's opening from -Y, to the right", "deg",
              plan.inclination_deg, {0.0, 80.0}),
       number("anteversion", "angle of the opening towards anterior", "deg", plan.anteversion_deg,
              {-45.0, 45.0}),
       word("side", "which hip", {"right", "left"})},
      [](const Values& values) {
        HipParameters chosen;
        chosen.resolution = values.number("resolution");
        chosen.radius_mm = values.number("radius");
        chosen.clearance_mm = values.number("clearance");
        chosen.wall_mm = values.number("wall");
        chosen.depth_mm = values.number("depth");
        chosen.neck_deg = values.number("neck");
        chosen.neck_ratio = values.number("neck_ratio");
        chosen.inclination_deg = values.number("inclination");
        chosen.anteversion_deg = values.number("anteversion");
        return of_side(hip(chosen), values);
      },
      nullptr,
      {}};
}

Entry ankle_entry()
{
  const AnkleParameters plan;
  return {
      "ankle",
      "a grooved talar trochlea in the mortise of a tibia",
      {number("resolution", "factor on the number of edges along a line", "", plan.resolution, {0.5, 12.0}),
       number("radius", "of the trochlea in the bottom of its groove", "mm", plan.radius_mm, {10.0, 50.0}),
       number("groove", "radius of the groove from side to side", "mm", plan.groove_mm, {20.0, 1000.0}),
       number("width", "of the trochlea", "mm", plan.width_mm, {10.0, 39.0}),
       number("clearance", "radius of the tibia's surface minus that of the trochlea", "mm",
              plan.clearance_mm, {0.05, 5.0}),
       word("side", "which foot", {"right", "left"})},
      [](const Values& values) {
        return of_side(ankle({values.number("resolution"), values.number("radius"), values.number("groove"),
                              values.number("width"), values.number("clearance")}),
                       values);
      },
      nullptr,
      {}};
}

Entry ball_in_dish_entry()
{
  const BallInDishParameters plan;
  return {
      "ball-in-dish",
      "a ball or ellipsoid pushed up into a dish that is open at the bottom",
      {number("ball_radius", "radius of the ball", "mm", plan.ball_radius_mm, {0.1, 200.0}),
       number("stretch_x", "half axis along X / ball_radius", "", 1.0, {0.1, 10.0}),
       number("stretch_y", "half axis along Y / ball_radius", "", 1.0, {0.1, 10.0}),
       number("stretch_z", "half axis along Z / ball_radius", "", 1.0, {0.1, 10.0}),
       number("dish_radius", "radius of curvature of the bowl", "mm", plan.dish_radius_mm, {1.0, 1000.0}),
       number("dish_width", "edge length of the square block", "mm", plan.dish_width_mm, {1.0, 1000.0}),
       number("hole", "width of a square central hole; 0: no hole", "mm", plan.hole_mm, {0.0, 500.0}),
       word("section", "profile of the dish", {"bowl", "cone", "wave"}),
       whole("ball_edges", "edges along an edge of the icosahedron; 20 n^2 triangles", plan.ball_edges,
             {1, 200}),
       whole("dish_edges", "edges along half the block's width", plan.dish_edges, {1, 350}),
       number("turn", "rotation of the ellipsoid about +Y", "deg", plan.turn_deg, {-180.0, 180.0}),
       number("offset_x", "X of the ball from the dish's axis", "mm", 0.0, {-500.0, 500.0}),
       number("offset_z", "Z of the ball from the dish's axis", "mm", 0.0, {-500.0, 500.0}),
       number("apart", "initial distance from the ball's top to the dish's rim", "mm",
              plan.initial_clearance_mm, {0.0, 100.0})},
      [](const Values& values) {
        BallInDishParameters chosen;
        chosen.ball_radius_mm = values.number("ball_radius");
        chosen.stretch = {values.number("stretch_x"), values.number("stretch_y"), values.number("stretch_z")};
        chosen.dish_radius_mm = values.number("dish_radius");
        chosen.dish_width_mm = values.number("dish_width");
        chosen.hole_mm = values.number("hole");
        chosen.section = values.word("section") == "cone"   ? DishSection::cone
                         : values.word("section") == "wave" ? DishSection::wave
                                                            : DishSection::bowl;
        chosen.ball_edges = values.integer("ball_edges");
        chosen.dish_edges = values.integer("dish_edges");
        chosen.turn_deg = values.number("turn");
        chosen.offset_x_mm = values.number("offset_x");
        chosen.offset_z_mm = values.number("offset_z");
        chosen.initial_clearance_mm = values.number("apart");
        return ball_in_dish(chosen);
      },
      nullptr,
      {}};
}

Entry bar_on_pyramids_entry()
{
  const BarOnPyramidsParameters plan;
  return {
      "bar-on-pyramids",
      "a bar pushed up between two pyramids with their tips down",
      {number("base", "edge length of each pyramid's base", "mm", plan.base_mm, {1.0, 500.0}),
       number("height", "height of each pyramid", "mm", plan.height_mm, {0.1, 500.0}),
       number("gap", "distance between the two bases", "mm", plan.gap_mm, {0.1, 500.0}),
       number("bar_length", "length of the bar, along Z at turn = 0", "mm", plan.bar_length_mm,
              {0.1, 1000.0}),
       number("bar_width", "width of the bar", "mm", plan.bar_width_mm, {0.1, 500.0}),
       number("bar_height", "height of the bar", "mm", plan.bar_height_mm, {0.1, 500.0}),
       number("turn", "rotation of the bar about +Y", "deg", plan.turn_deg, {-180.0, 180.0}),
       number("offset_x", "X of the bar from the middle between the pyramids", "mm", 0.0, {-500.0, 500.0}),
       number("offset_z", "Z of the bar from the middle between the pyramids", "mm", 0.0, {-500.0, 500.0}),
       whole("edges", "edges along half a base", plan.edges, {1, 200}),
       number("apart", "initial distance from the bar to the tips", "mm", plan.initial_clearance_mm,
              {0.0, 100.0})},
      [](const Values& values) {
        BarOnPyramidsParameters chosen;
        chosen.base_mm = values.number("base");
        chosen.height_mm = values.number("height");
        chosen.gap_mm = values.number("gap");
        chosen.bar_length_mm = values.number("bar_length");
        chosen.bar_width_mm = values.number("bar_width");
        chosen.bar_height_mm = values.number("bar_height");
        chosen.turn_deg = values.number("turn");
        chosen.offset_x_mm = values.number("offset_x");
        chosen.offset_z_mm = values.number("offset_z");
        chosen.edges = values.integer("edges");
        chosen.initial_clearance_mm = values.number("apart");
        return bar_on_pyramids(chosen);
      },
      nullptr,
      {}};
}

Entry cap_in_sink_entry()
{
  const CapInSinkParameters plan;
  return {"cap-in-sink",
          "a four-faced cap pushed up into a four-faced sink of the same slopes",
          {number("base", "edge length of the sink's opening", "mm", plan.base_mm, {1.0, 500.0}),
           number("depth", "depth of the sink", "mm", plan.depth_mm, {0.1, 500.0}),
           number("cap_scale", "size of the cap / size of the sink", "", plan.cap_scale, {0.05, 2.0}),
           number("turn", "rotation of the cap about +Y", "deg", plan.turn_deg, {-180.0, 180.0}),
           number("offset_x", "X of the cap from the sink's axis", "mm", 0.0, {-500.0, 500.0}),
           number("offset_z", "Z of the cap from the sink's axis", "mm", 0.0, {-500.0, 500.0}),
           whole("edges", "edges along half a base; 1: one triangle per face", plan.edges, {1, 200}),
           number("apart", "initial distance from the cap's tip to the sink's rim", "mm",
                  plan.initial_clearance_mm, {0.0, 100.0})},
          [](const Values& values) {
            CapInSinkParameters chosen;
            chosen.base_mm = values.number("base");
            chosen.depth_mm = values.number("depth");
            chosen.cap_scale = values.number("cap_scale");
            chosen.turn_deg = values.number("turn");
            chosen.offset_x_mm = values.number("offset_x");
            chosen.offset_z_mm = values.number("offset_z");
            chosen.edges = values.integer("edges");
            chosen.initial_clearance_mm = values.number("apart");
            return cap_in_sink(chosen);
          },
          nullptr,
          {}};
}

}  // namespace

const std::vector<CatalogueEntry>& shape_catalogue()
{
  static const std::vector<Entry> all = {knee_entry(),       template_knee_entry(), hip_entry(),
                                         ankle_entry(),      ball_in_dish_entry(),  bar_on_pyramids_entry(),
                                         cap_in_sink_entry()};
  return all;
}

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
