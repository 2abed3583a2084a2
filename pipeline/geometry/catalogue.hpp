/// Registry of the generated shapes for shapes.hpp: name, parameters with units and limits, and builder of
/// each. Meshes and fibres are in mm, canonical axes; values were checked against the limits before a builder
/// is called.
#pragma once

#include <cmath>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "geometry/shapes.hpp"

namespace vrda::geometry {

/// The complete, validated parameters of a request.
class ShapeValues {
 public:
  double number(const std::string& name) const { return numbers_.at(name); }
  int integer(const std::string& name) const { return static_cast<int>(std::lround(numbers_.at(name))); }
  const std::string& word(const std::string& name) const { return words_.at(name); }
  void set(const std::string& name, double value) { numbers_[name] = value; }
  void set(const std::string& name, const std::string& value) { words_[name] = value; }

 private:
  std::map<std::string, double> numbers_;
  std::map<std::string, std::string> words_;
};

struct CatalogueEntry {
  std::string name;
  std::string summary;
  std::vector<ShapeParameter> parameters = {};
  std::function<Shape(const ShapeValues&)> build = {};
  std::vector<ShapeFibre> (*fibres)(const ShapeValues&) = nullptr;  ///< null: no ligaments
  std::string fibre_sources = {};                                   ///< comment lines of the fibre table
  FollowerTexts (*follower)(const ShapeValues&) = nullptr;          ///< null: no follower
};

/// In the order of the help text.
const std::vector<CatalogueEntry>& shape_catalogue();

// The test scenes of thesis 4.2, upside down: Delta = +Y pushes the moving object up, so the cavity is above
// it and open at the bottom. The deepest point of each cavity is the origin; the moving object's highest
// point is generated `initial_clearance_mm` below the cavity's rim.

enum class DishSection {
  bowl,  ///< part of a ball
  cone,  ///< straight, with the bowl's depth at the middle of its edges
  wave   ///< the cone's mean slope with alternating steeper and flatter rings, monotonic
};

/// A ball or ellipsoid under a square dish. For a ball smaller than the bowl: equilibrium with its top at the
/// origin.
struct BallInDishParameters {
  double ball_radius_mm = 10.0;
  Eigen::Vector3d stretch{1.0, 1.0, 1.0};  ///< half axes / ball_radius_mm
  double dish_radius_mm = 30.0;            ///< of the bowl's curvature
  double dish_width_mm = 36.0;             ///< edge of the square block
  double hole_mm = 0.0;                    ///< width of a square hole through the middle
  DishSection section = DishSection::bowl;
  int ball_edges = 8;        ///< edges along an icosahedron's edge: 20 n^2 triangles
  int dish_edges = 24;       ///< edges along each half of the block's width
  double turn_deg = 0.0;     ///< of an ellipsoid about +Y
  double offset_x_mm = 0.0;  ///< of the ball from the dish's axis
  double offset_z_mm = 0.0;
  double initial_clearance_mm = 5.0;
};
/// Throws InputError when the dish radius is too small for the block's width, or the hole leaves no rim.
Shape ball_in_dish(const BallInDishParameters& plan);

/// A bar under two four-faced pyramids side by side along X, tips down. If it is narrower than the gap, its
/// equilibrium is between them along Z with the upper face at y = 0.
struct BarOnPyramidsParameters {
  double base_mm = 20.0;    ///< edge of each pyramid's square base
  double height_mm = 15.0;  ///< of each pyramid
  double gap_mm = 10.0;     ///< between the two bases
  double bar_length_mm = 40.0;
  double bar_width_mm = 8.0;
  double bar_height_mm = 8.0;
  double turn_deg = 20.0;  ///< of the bar about +Y; 0: along Z
  double offset_x_mm = 0.0;
  double offset_z_mm = 0.0;
  int edges = 4;  ///< along half a base
  double initial_clearance_mm = 5.0;
};
Shape bar_on_pyramids(const BarOnPyramidsParameters& plan);

/// A pyramidal cap under a pyramidal sink of the same slopes. Equilibrium: both tips at the origin, edges
/// aligned.
struct CapInSinkParameters {
  double base_mm = 40.0;   ///< edge of the sink's opening
  double depth_mm = 20.0;  ///< of the sink
  double cap_scale = 0.9;  ///< size of the cap / size of the sink
  double turn_deg = 20.0;  ///< of the cap about +Y
  double offset_x_mm = 0.0;
  double offset_z_mm = 0.0;
  int edges = 2;  ///< along half a base; 1 makes every face one triangle
  double initial_clearance_mm = 5.0;
};
Shape cap_in_sink(const CapInSinkParameters& plan);

}  // namespace vrda::geometry
