/// A flexion motion as OpenSim reads it: .sto and .mot (schemas/exports.md).
#pragma once

#include <array>
#include <string>

#include "exports/flexion_motion.hpp"

namespace vrda {

/// What a file holds after `time`, in this order: three angles and the translation of the moving mesh's
/// origin.
inline constexpr std::array<const char*, 6> opensim_coordinates{"flexion", "varus", "internal",
                                                                "tx",      "ty",    "tz"};

struct OpenSimOptions {
  std::array<std::string, 6> columns;  ///< a name for each of opensim_coordinates
  bool in_degrees = false;             ///< angles; else radians
  double degrees_per_second = 30.0;    ///< makes time of flexion
};

/// knee_flex_r, knee_add_r, knee_rot_r, knee_tx_r, knee_ty_r, knee_tz_r: the knee of Lenhart (2015) and Smith
/// (2019); on a left joint they end in _l.
std::array<std::string, 6> opensim_columns(Side side);

/// The whole file. R = Rz(-flexion) Rx(varus) Ry(internal) and (tx, ty, tz) in metres take the moving mesh's
/// axes to the reference's, both canonical; on a left joint varus and internal turn about -X and -Y.
std::string opensim_table(const FlexionMotion& motion, const OpenSimOptions& options);

}  // namespace vrda
