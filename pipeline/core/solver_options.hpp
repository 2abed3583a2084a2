/// The settings of the stability search and of the equilibrium, in internal units.
#pragma once

#include <Eigen/Core>

#include "core/units.hpp"

namespace vrda::inline core {

enum class ContactPoints { exact, triangle_centre };
enum class ContactNormals { least_curvature, reference, moving };

/// Motions across and about Delta that a search does not make.
struct HeldMotions {
  bool x = false;
  bool z = false;
  bool theta = false;

  bool any_translation() const { return x || z; }
};

struct SearchOptions {
  double approach_step_mm = 5.0;
  double translation_step_mm = 1.0;
  double translation_resolution_mm = 0.1;
  double rotation_step_rad = rad_from_deg(1.0);
  double rotation_resolution_rad = rad_from_deg(0.1);
  ContactPoints points = ContactPoints::exact;
  ContactNormals normals = ContactNormals::least_curvature;
  int max_steps = 10000;
  HeldMotions held;
};

/// Settings of one equilibrium solve.
struct EquilibriumOptions {
  double tolerance_mm = 1e-4;  ///< convergence tolerance of the pose along Delta
  int max_iterations = 200;
  double contact_resolution_mm = 0.01;  ///< surfaces closer than this are in contact (/contacts, flags)
};

/// Settings of the spine: the continuation path along flexion, with varus free, from which each row starts.
struct SpineOptions {
  int n_restarts = 4;              ///< additional starts at each flexion besides the two chains
  double band_moment_nmm = 500.0;  ///< extra moments about Delta for the theta band; 0: none
};

/// Constant (dead) loads on the moving object at one flexion, in the solver frame S. Their work is
/// force . translation + moment_nmm * theta + varus_moment_nmm * varus + (point x force) . (Y theta + X
/// varus); the last term is the force's moment about the origin of S.
struct Loads {
  Eigen::Vector3d force_n{0.0, 20.0, 0.0};
  double moment_nmm = 0.0;        ///< about Delta, on theta
  double varus_moment_nmm = 0.0;  ///< on varus
  Eigen::Vector3d point_mm{0.0, 0.0, 0.0};
};

}  // namespace vrda::inline core
