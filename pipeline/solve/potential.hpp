/// What the equilibrium minimises: ligaments' energy less the loads' work (DESIGN.md 5.3).
#pragma once

#include "core/equilibrium_options.hpp"
#include "ligament/ligaments.hpp"
#include "solve/place.hpp"

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

}  // namespace vrda
