/// Applied loads and lines of constant tension in the equilibrium. Loads that turn with an object have no
/// potential: at one pose they are replaced by loads that have one and the same force there.
#pragma once

#include <vector>

#include "model/solver_options.hpp"
#include "model/ligaments.hpp"

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

}  // namespace vrda::solve
