/// A flexion motion in the formats of other programs (schemas/exports.md).
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "exports/flexion_motion.hpp"

namespace vrda {

/// The whole binary file (.glb): both bodies, a node and a mesh a component, a material a name, and one
/// animation "flexion" with a key a frame that turns the reference and turns and moves the moving body.
/// Metres, Y up is proximal, +Z is anterior (the axes of glTF), the rotation centre at the scene's origin.
std::string animated_glb(const MotionModel& model, const FlexionMotion& motion, double degrees_per_second);

/// One row a flexion: the six numbers of data/kinematics first, then the attitude, the surfaces of world W
/// and the clinical translations. mm and degrees.
std::string flexion_csv(const FlexionMotion& motion);

/// The names of its columns, in their order.
std::vector<std::string> flexion_csv_columns();

/// One row a cell of the grid, flexion-major: every number that a cell has, the smoothed ones too. Nothing
/// stands where a cell has no answer; the status goes by its name.
std::string cells_csv(const MotionModel& model);

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

/// Both bodies as posed in world W (mm, single precision), VTK PolyData in XML with its arrays appended as
/// raw bytes. Cells carry `body` (0 reference, 1 moving), `component`, `material` and `has_contact`; field
/// data the names that `component` and `material` number, the attitude and the clinical numbers.
std::string posed_vtp(const MotionModel& model, const FlexionFrame& frame);

/// The contacts of the raw cell at this frame, as points in world W with `normal`, `distance_mm` and
/// `compartment`; empty where the frame is no cell's pose. Only for a motion of the set "raw".
std::string contacts_vtp(const MotionModel& model, const FlexionFrame& frame);

struct SeriesEntry {
  double flexion_deg = 0.0;
  int part = 0;      ///< 0 bodies, 1 contacts
  std::string file;  ///< relative to the .pvd file
};

/// The list, with the flexion in degrees as its time.
std::string series_pvd(const std::vector<SeriesEntry>& entries);

/// Numbers as the bytes of binary files, little-endian.
static_assert(std::endian::native == std::endian::little, "bytes are written as they lie in memory");

template <typename Number>
void put(std::string& bytes, Number value)
{
  char raw[sizeof value];
  std::memcpy(raw, &value, sizeof value);
  bytes.append(raw, sizeof value);
}

}  // namespace vrda
