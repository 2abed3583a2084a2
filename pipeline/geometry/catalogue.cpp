#include "geometry/catalogue.hpp"

#include <algorithm>
#include <utility>

#include "core/text.hpp"
#include "core/units.hpp"
#include "geometry/generic_knee.hpp"
#include "geometry/level_set.hpp"
#include "model/frames.hpp"

namespace vrda::geometry {
namespace {

using Entry = CatalogueEntry;
using Values = ShapeValues;

struct Range {
  double lowest = 0.0;
  double highest = 0.0;
};

/// A parameter, and how its value gets into the shape's plan.
template <typename Plan>
struct Row {
  ShapeParameter parameter;
  std::function<void(const Values&, Plan&)> set;  ///< may be empty
};

/// The default is that of the plan's member.
template <typename Plan>
Row<Plan> number(const char* name, const char* meaning, const char* unit, double Plan::*member, Range range)
{
  return {{name, meaning, unit, Plan{}.*member, range.lowest, range.highest, false, {}},
          [=](const Values& values, Plan& plan) { plan.*member = values.number(name); }};
}

template <typename Plan>
Row<Plan> whole(const char* name, const char* meaning, int Plan::*member, Range range)
{
  return {{name, meaning, "", static_cast<double>(Plan{}.*member), range.lowest, range.highest, true, {}},
          [=](const Values& values, Plan& plan) { plan.*member = values.integer(name); }};
}

ShapeParameter word(const char* name, const char* meaning, std::vector<std::string> choices)
{
  return {name, meaning, "", 0.0, 0.0, 0.0, false, std::move(choices)};
}

/// Shapes with this parameter are made for a right side and mirrored.
ShapeParameter side(const char* meaning)
{
  return word("side", meaning, {"right", "left"});
}

Shape of_side(Shape shape, const std::string& side)
{
  if (side == "right") return shape;
  for (std::vector<ShapePart>* parts : {&shape.reference, &shape.moving, &shape.followers}) {
    for (ShapePart& part : *parts) part.mesh = mirrored_z(part.mesh);
  }
  return shape;
}

std::vector<ShapeFibre> of_side(std::vector<ShapeFibre> fibres, const std::string& side)
{
  if (side == "right") return fibres;
  for (ShapeFibre& fibre : fibres) {
    fibre.reference_mm.z() *= -1.0;
    fibre.moving_mm.z() *= -1.0;
  }
  return fibres;
}

template <typename Plan>
Entry entry_of(const char* name, const char* summary, std::vector<Row<Plan>> rows, Shape (*make)(const Plan&))
{
  Entry entry{name, summary};
  bool has_side = false;
  for (const Row<Plan>& row : rows) {
    has_side |= row.parameter.name == "side";
    entry.parameters.push_back(row.parameter);
  }
  entry.build = [rows = std::move(rows), make, has_side](const Values& values) {
    Plan plan;
    for (const Row<Plan>& row : rows)
      if (row.set) row.set(values, plan);
    return of_side(make(plan), has_side ? values.word("side") : "right");
  };
  return entry;
}

Entry knee_entry()
{
  struct Plan {
    double resolution = 1.0;
  };
  // The upper end of the range gives a million triangles.
  Entry entry = entry_of<Plan>(
      "knee", "a right or left knee: femur, tibia, both menisci, patella; shafts and fibula drawn only",
      {number("resolution", "factor on the number of edges along a line; triangles grow with its square", "",
              &Plan::resolution, {0.5, 15.0}),
       {side("which knee"), {}}},
      [](const Plan& plan) { return right_knee(plan.resolution); });
  entry.fibres = [](const Values& values) { return of_side(right_knee_fibres(), values.word("side")); };
  entry.fibre_sources = knee_fibre_sources;
  entry.follower = [](const Values& values) {
    return patella_texts(generic_patella(), values.word("side") == "left");
  };
  return entry;
}

Entry template_knee_entry()
{
  struct Plan {};
  Entry entry = entry_of<Plan>(
      "knee-template",
      "the knee that vrda prepare registers onto a subject's: femur, tibia, patella; fibula drawn only",
      {{side("which knee"), {}}}, [](const Plan&) { return right_template_knee(); });
  entry.fibres = [](const Values& values) {
    return of_side(right_template_knee_fibres(), values.word("side"));
  };
  entry.fibre_sources = template_knee_fibre_sources;
  entry.follower = [](const Values& values) {
    return patella_texts(template_patella(), values.word("side") == "left");
  };
  return entry;
}

Entry hip_entry()
{
  using Plan = HipParameters;
  return entry_of<Plan>(
      "hip", "a spherical head with a neck in a deep socket",
      {number("resolution", "factor on the number of edges along a line", "", &Plan::resolution, {0.5, 12.0}),
       number("radius", "of the head", "mm", &Plan::radius_mm, {5.0, 100.0}),
       number("clearance", "inner radius of the socket minus radius of the head", "mm", &Plan::clearance_mm,
              {0.0, 20.0}),
       number("wall", "thickness of the socket", "mm", &Plan::wall_mm, {2.0, 50.0}),
       number("depth", "distance of the socket's rim beyond its centre", "mm", &Plan::depth_mm,
              {-20.0, 20.0}),
       number("neck", "angle of the neck from -Y, to the right", "deg", &Plan::neck_deg, {0.0, 80.0}),
       number("neck_ratio", "radius of the head over that of the neck", "", &Plan::neck_ratio, {1.2, 5.0}),
       number("inclination", "angle of the socket's opening from -Y, to the right", "deg",
              &Plan::inclination_deg, {0.0, 80.0}),
       number("anteversion", "angle of the opening towards anterior", "deg", &Plan::anteversion_deg,
              {-45.0, 45.0}),
       {side("which hip"), {}}},
      hip);
}

Entry ankle_entry()
{
  using Plan = AnkleParameters;
  return entry_of<Plan>(
      "ankle", "a grooved talar trochlea in the mortise of a tibia",
      {number("resolution", "factor on the number of edges along a line", "", &Plan::resolution, {0.5, 12.0}),
       number("radius", "of the trochlea in the bottom of its groove", "mm", &Plan::radius_mm, {10.0, 50.0}),
       number("groove", "radius of the groove from side to side", "mm", &Plan::groove_mm, {20.0, 1000.0}),
       number("width", "of the trochlea", "mm", &Plan::width_mm, {10.0, 39.0}),
       number("clearance", "radius of the tibia's surface minus that of the trochlea", "mm",
              &Plan::clearance_mm, {0.05, 5.0}),
       {side("which foot"), {}}},
      ankle);
}

Row<BallInDishParameters> stretch(const char* name, const char* meaning, Eigen::Index axis)
{
  return {
      {name, meaning, "", 1.0, 0.1, 10.0, false, {}},
      [=](const Values& values, BallInDishParameters& plan) { plan.stretch[axis] = values.number(name); }};
}

Entry ball_in_dish_entry()
{
  using Plan = BallInDishParameters;
  return entry_of<Plan>(
      "ball-in-dish", "a ball or ellipsoid pushed up into a dish that is open at the bottom",
      {number("ball_radius", "radius of the ball", "mm", &Plan::ball_radius_mm, {0.1, 200.0}),
       stretch("stretch_x", "half axis along X / ball_radius", 0),
       stretch("stretch_y", "half axis along Y / ball_radius", 1),
       stretch("stretch_z", "half axis along Z / ball_radius", 2),
       number("dish_radius", "radius of curvature of the bowl", "mm", &Plan::dish_radius_mm, {1.0, 1000.0}),
       number("dish_width", "edge length of the square block", "mm", &Plan::dish_width_mm, {1.0, 1000.0}),
       number("hole", "width of a square central hole; 0: no hole", "mm", &Plan::hole_mm, {0.0, 500.0}),
       {word("section", "profile of the dish", {"bowl", "cone", "wave"}),
        [](const Values& values, Plan& plan) {
          const std::string& section = values.word("section");
          plan.section = section == "cone"   ? DishSection::cone
                         : section == "wave" ? DishSection::wave
                                             : DishSection::bowl;
        }},
       whole("ball_edges", "edges along an edge of the icosahedron; 20 n^2 triangles", &Plan::ball_edges,
             {1, 200}),
       whole("dish_edges", "edges along half the block's width", &Plan::dish_edges, {1, 350}),
       number("turn", "rotation of the ellipsoid about +Y", "deg", &Plan::turn_deg, {-180.0, 180.0}),
       number("offset_x", "X of the ball from the dish's axis", "mm", &Plan::offset_x_mm, {-500.0, 500.0}),
       number("offset_z", "Z of the ball from the dish's axis", "mm", &Plan::offset_z_mm, {-500.0, 500.0}),
       number("apart", "initial distance from the ball's top to the dish's rim", "mm",
              &Plan::initial_clearance_mm, {0.0, 100.0})},
      ball_in_dish);
}

Entry bar_on_pyramids_entry()
{
  using Plan = BarOnPyramidsParameters;
  return entry_of<Plan>(
      "bar-on-pyramids", "a bar pushed up between two pyramids with their tips down",
      {number("base", "edge length of each pyramid's base", "mm", &Plan::base_mm, {1.0, 500.0}),
       number("height", "height of each pyramid", "mm", &Plan::height_mm, {0.1, 500.0}),
       number("gap", "distance between the two bases", "mm", &Plan::gap_mm, {0.1, 500.0}),
       number("bar_length", "length of the bar, along Z at turn = 0", "mm", &Plan::bar_length_mm,
              {0.1, 1000.0}),
       number("bar_width", "width of the bar", "mm", &Plan::bar_width_mm, {0.1, 500.0}),
       number("bar_height", "height of the bar", "mm", &Plan::bar_height_mm, {0.1, 500.0}),
       number("turn", "rotation of the bar about +Y", "deg", &Plan::turn_deg, {-180.0, 180.0}),
       number("offset_x", "X of the bar from the middle between the pyramids", "mm", &Plan::offset_x_mm,
              {-500.0, 500.0}),
       number("offset_z", "Z of the bar from the middle between the pyramids", "mm", &Plan::offset_z_mm,
              {-500.0, 500.0}),
       whole("edges", "edges along half a base", &Plan::edges, {1, 200}),
       number("apart", "initial distance from the bar to the tips", "mm", &Plan::initial_clearance_mm,
              {0.0, 100.0})},
      bar_on_pyramids);
}

Entry cap_in_sink_entry()
{
  using Plan = CapInSinkParameters;
  return entry_of<Plan>(
      "cap-in-sink", "a four-faced cap pushed up into a four-faced sink of the same slopes",
      {number("base", "edge length of the sink's opening", "mm", &Plan::base_mm, {1.0, 500.0}),
       number("depth", "depth of the sink", "mm", &Plan::depth_mm, {0.1, 500.0}),
       number("cap_scale", "size of the cap / size of the sink", "", &Plan::cap_scale, {0.05, 2.0}),
       number("turn", "rotation of the cap about +Y", "deg", &Plan::turn_deg, {-180.0, 180.0}),
       number("offset_x", "X of the cap from the sink's axis", "mm", &Plan::offset_x_mm, {-500.0, 500.0}),
       number("offset_z", "Z of the cap from the sink's axis", "mm", &Plan::offset_z_mm, {-500.0, 500.0}),
       whole("edges", "edges along half a base; 1: one triangle per face", &Plan::edges, {1, 200}),
       number("apart", "initial distance from the cap's tip to the sink's rim", "mm",
              &Plan::initial_clearance_mm, {0.0, 100.0})},
      cap_in_sink);
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
