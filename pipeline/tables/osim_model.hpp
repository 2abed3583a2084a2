/// The motion over flexion and varus as polynomials of the joint's two coordinates, for OpenSim's
/// MultivariatePolynomialFunction (schemas/exports.md). Radians and metres.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "store/motion_model.hpp"
#include "tables/tables.hpp"

namespace vrda::tables {

/// Sum of coefficient * flexion^i * varus^j over i + j <= order, by ascending i, then j: OpenSim's order.
struct BivariatePolynomial {
  int order = 0;
  std::vector<double> coefficients;  ///< [(order + 1) (order + 2) / 2]
};

struct OsimSurfaces {
  std::array<double, 2> flexion_rad{}, varus_rad{};  ///< first and last
  BivariatePolynomial internal_rad;
  std::array<BivariatePolynomial, 3> translation_m;  ///< of the rotation centre, along the reference's axes
};

/// The largest order that is tried, and the error that the order keeps to: metres and radians.
inline constexpr int largest_osim_order = 20;
inline constexpr double osim_surface_error = 1e-7;

/// The surfaces of `set`, interpolated at Chebyshev points of the measured range, with the least order that
/// keeps the neglected terms below osim_surface_error. Throws InputError naming `file` for a set or a model
/// that depends on flexion only, turned axes (Delta other than +Y), an attitude without a pose, and a set
/// that needs a larger order, as one with kinks.
OsimSurfaces osim_surfaces(const store::MotionModel& model, const std::string& file, const std::string& set);

// The motion as an OpenSim joint: a CustomJoint whose functions are splines of flexion, or polynomials of
// flexion and varus, alone or in a model with both bodies, meshes and fibres (schemas/exports.md).

struct OsimOptions {
  std::string file;        ///< of the motion model, for messages
  std::string coordinate;  ///< name of the joint's coordinate, flexion in rad
  std::string mesh_stem;   ///< prefix of the mesh files
  /// The functions, instead of splines over flexion; the joint then has a second coordinate of this name.
  std::optional<OsimSurfaces> surfaces = std::nullopt;
  std::string varus_coordinate = {};
  /// Of both coordinates: -1 for one that grows in extension (gait2392), or in abduction.
  double flexion_sign = 1.0, varus_sign = 1.0;
};

struct OsimMesh {
  std::string file;  ///< name within the folder Geometry
  Mesh mesh_m;       ///< one component, canonical axes, metres
};

struct OsimModel {
  std::string xml;
  std::vector<OsimMesh> meshes;
};

/// The joint element alone. Its frames' parents are /bodyset/REFERENCE and /bodyset/MOVING. Throws InputError
/// naming options.file for a sequence of frames, or unless the joint's own flexion rises from pose to pose.
std::string osim_joint(const store::MotionModel& model, const FlexionMotion& motion,
                       const OsimOptions& options);

/// A complete model, the reference welded to ground. Throws like osim_joint().
OsimModel osim_model(const store::MotionModel& model, const FlexionMotion& motion,
                     const OsimOptions& options);

/// Knots of the splines, degrees: the flexions of the set with others between. They become denser towards
/// flexions with kinks, so that these are rounded over 0.004 degrees only.
std::vector<double> osim_flexions_deg(const store::MotionModel& model, const std::string& set);

}  // namespace vrda::tables
