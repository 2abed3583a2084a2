/// Ligament fibres between the reference and the moving object: tension law, wrapping, energy and its
/// derivatives (DESIGN.md 5.3).
#pragma once

#include <span>
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

/// Both objects in S at one attitude and pose.
struct JointPlacement {
  Eigen::Matrix3d R_S_reference = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d R_S_moving = Eigen::Matrix3d::Identity();
  Eigen::Vector3d t_S_moving_mm = Eigen::Vector3d::Zero();
};
JointPlacement placed(const Attitude& attitude, const MovingPose& pose);

/// In S. One free segment crosses from the object that bears the wrap to the other (of a straight fibre: the
/// whole fibre). Only that segment pulls the objects towards each other.
struct FibrePath {
  double length_mm = 0.0;
  bool is_wrapped = false;
  /// Unit, along the crossing segment from the reference to the moving object: zero for two attachments in
  /// one place.
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();
  /// The attachment where the crossing segment ends, and the object it belongs to.
  Eigen::Vector3d end_mm = Eigen::Vector3d::Zero();
  WrapBody end_body = WrapBody::moving;
  /// Second derivatives of the length over `end_mm`, the wrap held; 1/mm.
  Eigen::Matrix3d bending = Eigen::Matrix3d::Zero();
};

/// Allocates nothing.
FibrePath fibre_path(const Fibre& fibre, const std::vector<Wrap>& wraps, const JointPlacement& placement);

struct FibreWay {
  double length_mm = 0.0;  ///< as fibre_path's, not that of the points' chords
  bool is_wrapped = false;
};

/// Puts points of the fibre's way into `points_mm` (at least four), in S, from the reference's attachment to
/// the moving object's: evenly along a straight fibre; of a wrapped one evenly on the surface, from where it
/// comes to it to where it leaves it, and both attachments. Allocates nothing.
FibreWay fibre_way(const Fibre& fibre, const std::vector<Wrap>& wraps, const JointPlacement& placement,
                   std::span<Eigen::Vector3d> points_mm);

}  // namespace vrda
