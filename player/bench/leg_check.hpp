/// Whether the model shows the tracked leg: angles beyond its range, angles that no knee has, exchanged
/// bodies.
#pragma once

#include <string>

#include "store/poses.hpp"
#include "bench/leg.hpp"

namespace vrda::bench {

/// Distance of a measured angle from the model's range; 0 within a degree of it, the noise of a tracked leg.
struct BeyondRange {
  double measured_rad = 0.0, nearest_rad = 0.0;  ///< `nearest`: at which the model is drawn
  bool is_beyond = false;
};

struct LegCheck {
  BeyondRange flexion, varus;
  /// Flexion 20 degrees before the model's range or 75 after it, varus 30 beside it, or 60 of rotation.
  bool is_implausible = false;
  /// With the bodies of femur and tibia exchanged the leg would be bent within the range, and it is not.
  bool are_bodies_exchanged = false;
  double rotation_rad = 0.0;

  bool is_wrong() const { return flexion.is_beyond || varus.is_beyond || is_implausible; }
};

/// `exchanged`: the angles if each body is on the other bone.
LegCheck check_leg(const store::Motion& motion, const bench::LegAngles& measured,
                   const bench::LegAngles& exchanged);

/// "flexion 120, model ends at 90"; empty if nothing is wrong. Degrees.
std::string leg_check_text(const LegCheck& check);

}  // namespace vrda::bench
