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
  std::vector<ShapePart> followers = {};  ///< of bodies that may follow the joint
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

/// Fibres and lines of a shape's follower as a table, and its wraps, as texts of a job's files
/// (schemas/followers.md). Throws InputError like generate_fibres().
struct FollowerTexts {
  std::string fibres, wraps;
};
FollowerTexts follower_texts(const ShapeRequest& request);

// A hip-like pair: a spherical head with a neck, pushed up into a deep socket. Origin: the socket's centre.

struct HipParameters {
  double resolution = 1.0;       ///< factor on the number of edges along a line
  double radius_mm = 24.0;       ///< of the head
  double clearance_mm = 0.5;     ///< inner radius of the socket minus radius of the head
  double wall_mm = 6.0;          ///< the socket's thickness
  double depth_mm = 2.0;         ///< distance of the socket's rim beyond its centre, towards the opening
  double neck_deg = 45.0;        ///< angle of the neck from -Y, towards the subject's right
  double neck_ratio = 2.0;       ///< radius of the head over that of the neck
  double inclination_deg = 0.0;  ///< angle of the socket's opening from -Y, towards the subject's right
  double anteversion_deg = 0.0;  ///< then of the opening towards anterior
};

/// Reference "socket", moving "head"; generated concentric without contact. Pushed up, the head is in
/// equilibrium with its centre at (0, clearance, 0). The neck meets the rim where its axis is
/// 90 degrees - asin(1 / neck_ratio) from that of the opening, for a depth of 0 and no wall. Throws
/// InputError when the socket's rim is too narrow for the head to enter, or too shallow.
Shape hip(const HipParameters& plan);

// A tibiotalar pair: a grooved talar trochlea pushed up into the mortise of the tibia. Origin: on the axis
// of the trochlea, in its middle.

struct AnkleParameters {
  double resolution = 1.0;    ///< factor on the number of edges along a line
  double radius_mm = 20.0;    ///< of the trochlea in the bottom of its groove
  double groove_mm = 40.0;    ///< radius of the groove from side to side
  double width_mm = 28.0;     ///< of the trochlea from side to side
  double clearance_mm = 0.5;  ///< radius of the tibia's joint surface minus that of the trochlea
};

/// Reference "tibia" with its medial malleolus, moving "talus" of a right foot; surfaces of revolution about
/// Z, generated concentric without contact. Pushed up, the trochlea touches along the top of its groove, at
/// (0, clearance, 0). Radii: talar domes of adults are arcs of about 20 mm (Siegler et al. 2014, J Biomech
/// 47:4038-4042, who also find them saddle-shaped).
Shape ankle(const AnkleParameters& plan);

// The bound on the size of a generated mesh.

/// Throws InputError with the shape's `parameter` as its field if a mesh of up to `n_triangles`, estimated
/// before it is made, has more than two million: some seconds and a gigabyte.
void require_moderate_size(double n_triangles, const std::string& parameter);

}  // namespace vrda::geometry
