/// Ligament fibres between the reference and the moving object: tension law, wrapping, energy and its
/// derivatives (DESIGN.md 5.3).
#pragma once

#include <string>
#include <vector>

#include "core/coordinates.hpp"

namespace vrda {

enum class WrapShape { cylinder, ellipsoid };
enum class WrapBody { reference, moving };

/// A smooth surface that fibres go round on the shorter side, fixed to one object. A cylinder runs along its
/// Z. It does not act on a fibre with an attachment inside it (a cylinder counts as endless here), nor on one
/// that would touch a cylinder wholly beyond one of its ends: such a fibre is straight, and its length jumps
/// there.
struct Wrap {
  std::string name;
  WrapShape shape = WrapShape::cylinder;
  WrapBody body = WrapBody::reference;
  Pose X_body_wrap = Pose::Identity();  ///< of the object's frame
  Eigen::Vector3d radii_mm{0, 0, 0};    ///< ellipsoid: half-axes; cylinder: x and y alike, z half its length
};

struct Fibre {
  std::string name;
  std::string bundle;            ///< fibres of one ligament share it
  Eigen::Vector3d reference_mm;  ///< attachment, in the reference's frame
  Eigen::Vector3d moving_mm;     ///< attachment, in the moving object's frame
  double stiffness_n = 0.0;      ///< per unit strain, above 0
  double slack_length_mm = 0.0;  ///< above 0
  int wrap = -1;                 ///< row of Ligaments::wraps, or -1
};

/// Frames: canonical as loaded; both objects' frames at zero attitude of S for the solver.
struct Ligaments {
  std::vector<Fibre> fibres;
  std::vector<Wrap> wraps;
  double transition_strain = 0.06;  ///< where the toe of the tension law ends
};

/// From canonical (own side, meshes' origin) to the frames of the solver, as solver_mesh() does for meshes.
Ligaments solver_ligaments(const Ligaments& canonical, const SolverFrame& frame);

/// Tension of a fibre. Source: Blankevoort et al. 1991, J Biomech 24:1019-1031.
struct Tension {
  double force_n = 0.0;
  double stiffness_n = 0.0;  ///< derivative over strain
  double energy_n = 0.0;     ///< integral over strain; times slack length the energy in N mm
};
Tension tension_of(double strain, double stiffness_n, double transition_strain);

struct FibreState {
  double length_mm = 0.0;
  double strain = 0.0;  ///< negative: slack
  double force_n = 0.0;
  double energy_nmm = 0.0;
  bool is_wrapped = false;  ///< touches its wrap
};

/// One state a fibre.
std::vector<FibreState> fibre_states(const Ligaments& ligaments, const Attitude& attitude,
                                     const MovingPose& pose);

/// Energy of all fibres with its gradient and second derivatives, both exact. The second ones jump where a
/// fibre falls slack or lifts off its wrap. Allocates nothing.
Potential ligament_energy(const Ligaments& ligaments, const Attitude& attitude, const MovingPose& pose);

}  // namespace vrda
