/// The potential of the equilibrium, ligament energy minus work of the loads, and its
/// certificate: whether compressive contact forces balance loads and ligaments.
#pragma once

#include <vector>

#include "model/solver_options.hpp"
#include "model/step_record.hpp"
#include "model/ligaments.hpp"
#include "solve/applied_loads.hpp"
#include "solve/contact_constraint.hpp"

namespace vrda::solve {

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
  bool is_linear() const { return ligaments.fibres.empty() && applied == nullptr; }
};

/// Ligament energy minus work of the loads, N mm, with derivatives over the configuration (angles in rad).
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

}  // namespace vrda::solve
