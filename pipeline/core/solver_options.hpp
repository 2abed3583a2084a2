/// The settings of the stability search and of the equilibrium, in internal units.
#pragma once

#include <Eigen/Core>

#include "core/units.hpp"

namespace vrda {

enum class ContactPoints { exact, triangle_centre };
enum class ContactNormals { least_curvature, reference, moving };

struct SearchOptions {
  double approach_step_mm = 5.0;
  double translation_step_mm = 1.0;
  double translation_resolution_mm = 0.1;
  double rotation_step_rad = rad_from_deg(1.0);
  double rotation_resolution_rad = rad_from_deg(0.1);
  ContactPoints points = ContactPoints::exact;
  ContactNormals normals = ContactNormals::least_curvature;
  int max_steps = 10000;
};

/// Of one motion step.
struct EquilibriumOptions {
  double tolerance_mm = 1e-4;  ///< of the pose, along Delta
  int max_iterations = 200;
  double contact_resolution_mm = 0.01;  ///< surfaces closer than this touch, in /contacts and flags
};

/// Of the spine, along which varus is left free.
struct SpineOptions {
  int n_restarts = 4;              ///< starts at each flexion aside from the chains along it
  double band_moment_nmm = 500.0;  ///< extra moments about Delta that theta is reported for; 0: none
};

/// Dead loads on the moving object at one flexion, in the solver frame S. Their work is
/// force . translation + moment_nmm * theta + varus_moment_nmm * varus plus that of the force's moment about
/// the origin of S when it acts at `point_mm`: (point x force) . (Y theta + X varus).
struct Loads {
  Eigen::Vector3d force_n{0.0, 20.0, 0.0};
  double moment_nmm = 0.0;        ///< about Delta, on theta
  double varus_moment_nmm = 0.0;  ///< on varus
  Eigen::Vector3d point_mm{0.0, 0.0, 0.0};
};

}  // namespace vrda
