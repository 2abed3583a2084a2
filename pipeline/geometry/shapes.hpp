/// Generated meshes of joints and test scenes.
/// Everything is in mm, canonical axes (X anterior, Y proximal, Z the subject's right), with the
/// rotation centre at the origin. The reference is above; the moving object is pushed up (+Y) onto it.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "model/mesh.hpp"

namespace vrda::geometry {

/// One component of an object. `mesh` is closed, wound outward and has vertex normals.
struct ShapePart {
  std::string name;      ///< unique within the shape; the stem of its file
  std::string material;  ///< "bone", "meniscus", "cartilage"
  bool has_contact = true;
  Mesh mesh;
};

/// Shape and parameters to generate. Missing parameters take their defaults (see shape_parameters).
struct ShapeRequest {
  std::string shape;                         ///< one of shape_names()
  std::map<std::string, double> numbers;     ///< e.g. {"resolution", 1.0}; unit as documented
  std::map<std::string, std::string> words;  ///< e.g. {"side", "left"}
};

struct Shape {
  std::vector<ShapePart> reference;
  std::vector<ShapePart> moving;
};

/// One ligament fibre of a shape, attached to its parts at their generated positions.
struct ShapeFibre {
  std::string name;
  std::string bundle;
  Eigen::Vector3d reference_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d moving_mm = Eigen::Vector3d::Zero();
  double stiffness_n = 0.0;  ///< per unit strain
  double slack_length_mm = 0.0;
};

/// One parameter of a shape: a number with unit and range, or one of a list of words.
struct ShapeParameter {
  std::string name;
  std::string meaning;
  std::string unit;  ///< "mm", "deg", or empty for a pure number or a word
  double default_number = 0.0;
  double lowest = 0.0;   ///< allowed
  double highest = 0.0;  ///< allowed
  bool is_integer = false;
  std::vector<std::string> choices;  ///< for words; the first is the default
};

/// In the order of the help text.
std::vector<std::string> shape_names();

/// One-line description. Throws InputError for an unknown shape.
std::string shape_summary(const std::string& shape);

/// Every parameter of a shape. Throws InputError for an unknown shape.
std::vector<ShapeParameter> shape_parameters(const std::string& shape);

/// Builds the shape; deterministic to the last bit.
/// Throws InputError (file "shape", field the shape or parameter) for an unknown shape, parameter or word,
/// naming the nearest known one, and for a number out of range.
/// Cost: milliseconds at default size, some seconds for a million triangles.
Shape generate_shape(const ShapeRequest& request);

/// The ligaments of a shape; throws InputError like generate_shape(), and for a shape without ligaments.
std::vector<ShapeFibre> generate_fibres(const ShapeRequest& request);

/// The same as a table for a job's `ligaments.fibres` (schemas/ligaments.md), with its sources as comments.
std::string fibre_table(const ShapeRequest& request);

}  // namespace vrda::geometry
