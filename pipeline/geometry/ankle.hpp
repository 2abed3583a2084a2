/// A tibiotalar pair: a grooved talar trochlea pushed up into the mortise of the tibia. Origin: on the axis
/// of the trochlea, in its middle.
#pragma once

#include "geometry/shapes.hpp"

namespace vrda::geometry {

struct AnkleParameters {
  double resolution = 1.0;    ///< factor on the number of edges along a line
  double radius_mm = 20.0;    ///< of the trochlea in the bottom of its groove
  double groove_mm = 40.0;    ///< radius of the groove from side to side
  double width_mm = 28.0;     ///< of the trochlea from side to side
  double clearance_mm = 0.5;  ///< radius of the tibia's joint surface minus that of the trochlea
};

/// Reference "tibia" with its medial malleolus, moving "talus" of a right foot; surfaces of revolution about
/// Z, generated concentric without contact. Pushed up, the trochlea touches along the top of its groove, at
/// (0, clearance, 0). Radii: talar domes of adults are arcs of about 20 mm (Siegler et al. 2014, J Biomech
/// 47:4038-4042, who also find them saddle-shaped).
Shape ankle(const AnkleParameters& plan);

}  // namespace vrda::geometry
