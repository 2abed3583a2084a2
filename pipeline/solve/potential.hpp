/// Applied loads and lines of constant tension in the equilibrium. Loads that turn with an object have no
/// potential: at one pose they are replaced by loads that have one and the same force there.
#pragma once

#include <vector>

#include "model/coordinates.hpp"
#include "model/frames.hpp"
#include "model/ligaments.hpp"
#include "model/step_record.hpp"
#include "solve/contact_constraint.hpp"

namespace vrda::solve {

/// Force and moment about the origin of S on the moving object.
struct Wrench {
  Eigen::Vector3d force_n = Eigen::Vector3d::Zero();
  Eigen::Vector3d moment_nmm = Eigen::Vector3d::Zero();
};

/// Sum of the applied loads and lines at a pose, in S.
Wrench wrench_of(const Loads& loads, const Attitude& attitude, const MovingPose& pose);

/// Loads with a potential.
struct LoadPotential {
  struct PointForce {
    Eigen::Vector3d force_reference_n;  ///< constant in the reference's frame
    Eigen::Vector3d point_moving_mm;
  };
  std::vector<PointForce> forces;
  Vector5d constant = Vector5d::Zero();  ///< generalised force, N and N mm
  std::vector<TensionLine> lines;
};

/// Equal to the loads at the pose. Forces fixed in the reference or, at constant varus, in the world, and
/// lines are exact everywhere. Other forces and all moments are constant along the coordinates: in this form
/// their error does not couple back, so replacing them again at the pose found converges fast.
LoadPotential potential_near(const Loads& loads, const Attitude& attitude, const MovingPose& pose);

/// Energy with derivatives. The constant part counts with its work from zero coordinates.
Potential energy_of(const LoadPotential& loads, const Attitude& attitude, const MovingPose& pose);

/// A coordinate of a prior (model/step_record.hpp) at a pose with Delta = +Y, rad or mm, with its first and
/// second derivatives over the coordinates of S. Right-knee signs, as everything in S.
struct CoordinateValue {
  double value = 0.0;
  Vector5d gradient = Vector5d::Zero();
  Matrix5d hessian = Matrix5d::Zero();
};
CoordinateValue coordinate_value(PriorCoordinate coordinate, double varus_rad, const MovingPose& pose);

/// Energy of the springs with derivatives, N mm.
Potential energy_of(const std::vector<CoordinateSpring>& springs, double varus_rad, const MovingPose& pose);

// The potential of the equilibrium, ligament energy minus work of the loads, and its
// certificate: whether compressive contact forces balance loads and ligaments.

struct EquilibriumCandidate;

/// All forces at one flexion except contact.
struct NonContactForces {
  const model::Ligaments& ligaments;
  const Loads& loads;
  const RotationScale& scale;
  double flexion_rad = 0.0;
  /// If set, the potential is expanded to second order about it, which saves the path of every fibre.
  const EquilibriumCandidate* expansion_point = nullptr;
  /// The applied loads and lines of `loads`; null without any.
  const LoadPotential* applied = nullptr;

  /// Whether the potential is linear in the coordinates, so that a plan needs no expansion.
  bool is_linear() const { return ligaments.fibres.empty() && applied == nullptr && loads.springs.empty(); }
};

/// Energy of ligaments and springs minus work of the loads, N mm, with derivatives over the configuration
/// (angles in rad).
Potential potential_at(const NonContactForces& forces, const Configuration& configuration);

/// Proximal term: stiffness / 2 times the squared step from the seed, without the height. Negligible against
/// real stiffness; selects the point nearest the seed if the minimum is a continuum.
struct ProximalTerm {
  Configuration seed;
  double stiffness_n_mm = 0.0;
};

/// A configuration in equilibrium along Delta.
struct EquilibriumCandidate {
  Configuration configuration;
  Potential potential;  ///< at `configuration`
  bool is_bounded = true;
};

/// Minimises the potential over the height of the pivot, all other coordinates held, searching down from
/// `configuration`. The minimum is at the ceiling, or where the derivative along Delta vanishes. Not bounded:
/// no minimum within `reach_mm` below the ceiling.
struct HeightLimits {
  double ceiling_mm = 0.0;  ///< highest pivot without overlap
  double reach_mm = 0.0;
  double force_tolerance_n = 0.0;  ///< of the derivative along Delta
};
EquilibriumCandidate equilibrium_along_delta(const NonContactForces& forces, Configuration configuration,
                                             const HeightLimits& limits);

/// Force balance of the constraints in contact at one configuration.
struct ContactForceBalance {
  struct ActiveConstraint {
    std::size_t row = 0;         ///< of the constraints
    double along_delta_n = 0.0;  ///< above 0
  };
  /// Residual force along the free coordinates; moments divided by the lever.
  Vector5d unbalanced_n = Vector5d::Zero();
  double residual_n = 0.0;  ///< norm of unbalanced_n
  std::vector<ActiveConstraint> active;
};

/// Non-negative least squares: the contact forces of `touching` that minimise the residual gradient of
/// `potential` along the free coordinates. Solved by its dual, the projection of the gradient on a cone.
ContactForceBalance balance_contact_forces(const Potential& potential, const std::vector<Clearance>& touching,
                                           const RotationScale& scale, const std::array<bool, 5>& is_free);

// The joint's six coordinates in the solver frame S: positions, velocities and the work of the loads.

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// A pose as gap queries take it: the attitude at which it is a rotation about Delta alone, and that pose.
struct SolverPosition {
  Attitude attitude;
  MovingPose pose;
};

/// Of a pose in S at zero attitude; the inverse of X_solver_reference_moving(). Flexion and theta are in
/// (-pi, pi], varus in [-pi/2, pi/2]; near its ends only the sum or difference of the other two is defined.
SolverPosition solver_position(const Pose& X_reference_moving);
/// Of a canonical pose: the inverse of X_reference_moving().
inline SolverPosition solver_position(const SolverFrame& frame, const Pose& X_reference_moving)
{
  return solver_position(X_solver_reference_moving(frame, X_reference_moving));
}

// A twist of the moving object relative to the reference, in S: angular velocity (rad), then the velocity of
// the moving object's origin (mm). A point at `p` moves by u + omega x (p - pose.translation_mm). Forces
// are moments about that origin (N mm), then forces (N), so that their product is work.

/// Moment and force of `force_n` acting at the point `p`.
Vector6d wrench_of(const Eigen::Vector3d& force_n, const Eigen::Vector3d& p, const SolverPosition& at);

class JointMap {
 public:
  explicit JointMap(const SolverFrame& frame);

  SolverPosition position_at(const JointCoordinates& coordinates) const;
  JointCoordinates coordinates_at(const SolverPosition& position) const;

  /// Twists in S by each coordinate, columns; `position` is that of the coordinates.
  Matrix6d twists(const JointCoordinates& coordinates, const SolverPosition& position) const;

 private:
  SolverFrame frame_;  // right, about the origin
  Eigen::Matrix3d R_solver_joint_;
};

/// Work of the loads from zero coordinates of S (model/step_record.hpp), N mm, and their wrench. Applied
/// loads and lines count with `applied`, which stands for them near one pose; null without any.
struct Work {
  double work_nmm = 0.0;
  Vector6d wrench = Vector6d::Zero();
};
Work work_of(const Loads& loads, const LoadPotential* applied, const SolverPosition& at);

/// Energy of a spring, N mm; adds its derivative over the twist to `wrench`.
double energy_of(const DirectionSpring& spring, const SolverPosition& at, Vector6d& wrench);
/// The force by which the spring acts on the reference, at `spring.reference_mm` in S; the opposite acts on
/// the moving object there.
Eigen::Vector3d force_on_reference(const DirectionSpring& spring, const SolverPosition& at);

// Distance of a contact constraint along its own normal, for every motion of the moving object.

/// Positive: apart. `wrench` is the derivative over the twist, in (rad, mm): the moment and force of a unit
/// contact force.
struct FeatureDistance {
  double distance_mm = 0.0;
  Vector6d wrench = Vector6d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();    ///< unit, reaction on the moving object, S
  Eigen::Vector3d point_mm = Eigen::Vector3d::Zero();  ///< on the reference, S
};

/// Distances of constraints at one position. `pivot_mm` is RotationScale::pivot_mm, to which a constraint's
/// moving point refers. Faces and edges are extended without limit, as in clearance(). Infinite with a zero
/// wrench for parallel edges.
class FeatureMeter {
 public:
  FeatureMeter(const SolverPosition& at, const Eigen::Vector3d& pivot_mm)
      : at_(at), rotations_(at.attitude, at.pose.theta_rad), pivot_mm_(pivot_mm)
  {
  }
  FeatureDistance operator()(const ContactConstraint& constraint) const;

 private:
  SolverPosition at_;
  Rotations rotations_;
  Eigen::Vector3d pivot_mm_;
};

}  // namespace vrda::solve
