/// What the equilibrium minimises, ligaments' energy less the loads' work (DESIGN.md 5.3), and its
/// certificate: whether contact forces that can only push hold the loads and ligaments.
#pragma once

#include <vector>

#include "core/solver_options.hpp"
#include "core/step_record.hpp"
#include "ligament/ligaments.hpp"
#include "solve/obstacle.hpp"

namespace vrda {

struct Rest;

/// Everything that pulls and pushes at one flexion, but contact.
struct Forces {
  const Ligaments& ligaments;
  const Loads& loads;
  const Grip& grip;
  double flexion_rad = 0.0;
  /// Where set, its potential to second order stands for the exact one, which costs a path for every fibre.
  const Rest* near = nullptr;
};

/// Ligaments' energy less the loads' work, over the coordinates of a Place (angles in rad, not times the
/// lever).
Potential potential_at(const Forces& forces, const Place& place);

/// A pull towards the seed, too weak to matter against any stiffness, that makes the answer the point nearest
/// the seed where the minimum is a continuum: stiffness / 2 times the squared step, height left out.
struct SeedSpring {
  Place seed;
  double stiffness_n_mm = 0.0;
};

struct Rest {
  Place place;          ///< the height changed only
  Potential potential;  ///< there
  bool is_bounded = true;
};

/// The height of least potential at or below `ceiling_mm` (of the pivot) with all else held: at the ceiling
/// when that pushes on; else where the derivative along Delta vanishes, searched from `place` downwards.
/// Not bounded: no such height within `reach_mm` below the ceiling.
struct RestLimits {
  double ceiling_mm = 0.0;
  double reach_mm = 0.0;
  double force_tolerance_n = 0.0;
};
Rest rest_along_delta(const Forces& forces, Place place, const RestLimits& limits);

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
