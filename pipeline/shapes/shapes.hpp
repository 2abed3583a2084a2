/// Joints and test scenes made by code: no mesh file needed.
/// Everything is in mm, canonical axes (X anterior, Y proximal, Z the subject's right), with the
/// rotation centre at the origin. The reference hangs above, the moving object is pushed up (+Y) onto it.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/mesh.hpp"

namespace vrda {

/// One component of an object. `mesh` is closed, wound outward and has vertex normals.
struct ShapePart {
  std::string name;      ///< unique within the shape; the stem of its file
  std::string material;  ///< "bone", "meniscus", "cartilage"
  bool has_contact = true;
  Mesh mesh;
};

/// What to generate. Parameters left out take their defaults (see shape_parameters).
struct ShapeRequest {
  std::string shape;                         ///< one of shape_names()
  std::map<std::string, double> numbers;     ///< e.g. {"resolution", 1.0}; unit as documented
  std::map<std::string, std::string> words;  ///< e.g. {"side", "left"}
};

struct Shape {
  std::vector<ShapePart> reference;
  std::vector<ShapePart> moving;
};

/// One ligament fibre of a shape, attached to its reference and moving parts where generate_shape() puts
/// them.
struct ShapeFibre {
  std::string name;
  std::string bundle;
  Eigen::Vector3d reference_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d moving_mm = Eigen::Vector3d::Zero();
  double stiffness_n = 0.0;  ///< per unit strain
  double slack_length_mm = 0.0;
};

/// One parameter of a shape: a number with a unit and a range, or a word out of a list.
struct ShapeParameter {
  std::string name;
  std::string meaning;
  std::string unit;  ///< "mm", "deg", or empty for a pure number or a word
  double default_number = 0.0;
  double lowest = 0.0;   ///< allowed
  double highest = 0.0;  ///< allowed
  bool is_whole = false;
  std::vector<std::string> choices;  ///< words only; the first is the default
};

/// In the order in which help prints them.
std::vector<std::string> shape_names();

/// One line on what the shape is. Throws InputError for an unknown shape.
std::string shape_summary(const std::string& shape);

/// Every parameter of a shape. Throws InputError for an unknown shape.
std::vector<ShapeParameter> shape_parameters(const std::string& shape);

/// Builds the shape. Same request, same bits.
/// Throws InputError (file "shape", field the shape or parameter) for an unknown shape, parameter or word,
/// naming the nearest known one, and for a number out of range.
/// Cost: milliseconds at default size, some seconds for a million triangles.
Shape generate_shape(const ShapeRequest& request);

/// The ligaments of a shape; throws InputError like generate_shape(), and for a shape without ligaments.
std::vector<ShapeFibre> generate_fibres(const ShapeRequest& request);

/// The same as a table for a job's `ligaments.fibres` (schemas/ligaments.md), its sources in comments.
std::string fibre_table(const ShapeRequest& request);

}  // namespace vrda
