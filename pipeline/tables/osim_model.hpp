/// The motion as an OpenSim joint: a CustomJoint whose functions are splines of flexion, or polynomials of
/// flexion and varus, alone or in a model with both bodies, meshes and fibres (schemas/exports.md).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tables/flexion_motion.hpp"
#include "tables/osim_surfaces.hpp"

namespace vrda::tables {

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
