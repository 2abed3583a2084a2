/// The settings of the stability search and of the equilibrium, in internal units.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/units.hpp"

namespace vrda::inline model {

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

/// The axes in which an applied load keeps its direction. All coincide at zero attitude and theta. The values
/// are those of the motion model.
enum class LoadFrame : std::int8_t { world = 0, reference = 1, moving = 2 };

/// As in a job.
constexpr const char* name_of(LoadFrame frame)
{
  return frame == LoadFrame::world ? "world" : frame == LoadFrame::reference ? "reference" : "moving";
}

/// A force at a material point of the moving object and a moment on it; their opposites act on the reference.
struct AppliedLoad {
  LoadFrame frame = LoadFrame::world;
  Eigen::Vector3d force_n{0.0, 0.0, 0.0};     ///< axes of `frame`
  Eigen::Vector3d moment_nmm{0.0, 0.0, 0.0};  ///< right-handed, axes of `frame`
  Eigen::Vector3d point_mm{0.0, 0.0, 0.0};    ///< in the moving object's frame
};

/// A straight line of constant tension between both objects.
struct TensionLine {
  double tension_n = 0.0;
  Eigen::Vector3d reference_mm{0.0, 0.0, 0.0};  ///< in the reference's frame
  Eigen::Vector3d moving_mm{0.0, 0.0, 0.0};     ///< in the moving object's frame
};

/// Loads on the moving object at one flexion, in the solver frame S; frames of the objects are those in S at
/// zero attitude. The work of the constant (dead) load, the first four members, is
/// force . translation + moment_nmm * theta + varus_moment_nmm * varus + (point x force) . (Y theta + X
/// varus); the last term is the force's moment about the origin of S.
struct Loads {
  Eigen::Vector3d force_n{0.0, 20.0, 0.0};
  double moment_nmm = 0.0;        ///< about Delta, on theta
  double varus_moment_nmm = 0.0;  ///< on varus
  Eigen::Vector3d point_mm{0.0, 0.0, 0.0};
  std::vector<AppliedLoad> applied;
  std::vector<TensionLine> lines;
};

}  // namespace vrda::inline model
