/// The certificate of the equilibrium: whether contact forces that can only push hold the loads and
/// ligaments.
#pragma once

#include <vector>

#include "core/step_record.hpp"
#include "solve/obstacle.hpp"
#include "solve/potential.hpp"
#include "solve/quadratic_program.hpp"

namespace vrda {

/// Of the obstacles that touch at one place.
struct Held {
  struct Bearing {
    std::size_t row = 0;         ///< of the obstacles
    double along_delta_n = 0.0;  ///< above 0
  };
  Vector5d unbalanced_n =
      Vector5d::Zero();     ///< force left along the free coordinates, moments over the lever
  double residual_n = 0.0;  ///< its length
  std::vector<Bearing> bearing;
};

/// The non-negative forces of `touching` that leave least of the gradient of `potential` on the free
/// coordinates. Least squares with non-negative unknowns are the dual of the projection on a cone, which
/// is a quadratic programme: what is left over is the projection.
Held held_by(const Potential& potential, const std::vector<Clearance>& touching, const Grip& grip,
             const std::array<bool, 5>& is_free);

}  // namespace vrda
