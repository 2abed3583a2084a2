/// The test scenes of thesis 4.2, turned over: Delta = +Y pushes the moving object up, so the hollow hangs
/// above it and opens downward. The deepest place of each hollow is the origin; the moving object's highest
/// point is generated `apart_mm` below the hollow's rim.
#pragma once

#include "shapes/shapes.hpp"

namespace vrda {

enum class DishSection {
  bowl,  ///< part of a ball
  cone,  ///< as deep as the bowl at the middle of its edges, straight
  wave   ///< the cone's mean slope, steeper and flatter by turns, always falling
};

/// A ball or ellipsoid under a square dish. A ball smaller than the bowl rests with its top at the origin.
struct BallInDishPlan {
  double ball_radius_mm = 10.0;
  Eigen::Vector3d stretch{1.0, 1.0, 1.0};  ///< the ball's half axes over its radius
  double dish_radius_mm = 30.0;            ///< of the bowl's curvature
  double dish_width_mm = 36.0;             ///< edge of the square block
  double hole_mm = 0.0;                    ///< width of a square hole through the middle
  DishSection section = DishSection::bowl;
  int ball_edges = 8;        ///< edges along an icosahedron's edge: 20 n^2 triangles
  int dish_edges = 24;       ///< edges along each half of the block's width
  double turn_deg = 0.0;     ///< of an ellipsoid about +Y
  double offset_x_mm = 0.0;  ///< of the ball from the dish's axis
  double offset_z_mm = 0.0;
  double apart_mm = 5.0;
};
/// Throws InputError when the bowl's ball is too small for the block's width, or the hole leaves no rim.
Shape ball_in_dish(const BallInDishPlan& plan);

/// A bar under two four-faced pyramids side by side along X, tips down. It rests along Z with its upper face
/// at y = 0, between them, when it is narrower than the gap.
struct BarOnPyramidsPlan {
  double base_mm = 20.0;    ///< edge of each pyramid's square base
  double height_mm = 15.0;  ///< of each pyramid
  double gap_mm = 10.0;     ///< between the two bases
  double bar_length_mm = 40.0;
  double bar_width_mm = 8.0;
  double bar_height_mm = 8.0;
  double turn_deg = 20.0;  ///< of the bar about +Y, from lying along Z
  double offset_x_mm = 0.0;
  double offset_z_mm = 0.0;
  int edges = 4;  ///< along half a base
  double apart_mm = 5.0;
};
Shape bar_on_pyramids(const BarOnPyramidsPlan& plan);

/// A pyramidal cap under a pyramidal sink of the same slopes. It rests with both tips at the origin, edges in
/// line.
struct CapInSinkPlan {
  double base_mm = 40.0;   ///< edge of the sink's opening
  double depth_mm = 20.0;  ///< of the sink
  double cap_scale = 0.9;  ///< the cap's size over the sink's
  double turn_deg = 20.0;  ///< of the cap about +Y
  double offset_x_mm = 0.0;
  double offset_z_mm = 0.0;
  int edges = 2;  ///< along half a base; 1 makes every face one triangle
  double apart_mm = 5.0;
};
Shape cap_in_sink(const CapInSinkPlan& plan);

}  // namespace vrda
