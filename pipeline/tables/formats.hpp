/// A flexion motion in the formats of other programs (schemas/exports.md).
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "analysis/flexion_curves.hpp"
#include "tables/tables.hpp"

namespace vrda::tables {

/// Content of the .glb file: both bodies, one node and mesh per component, one material per name, and one
/// animation "flexion" with one key per frame for the rotation and translation of both bodies. Metres; Y (up)
/// is proximal, +Z is anterior (axes of glTF); the origin is the rotation centre.
std::string animated_glb(const store::MotionModel& model, const FlexionMotion& motion,
                         double degrees_per_second);

/// One row per flexion, or per frame with its key first: the six numbers of data/kinematics, then the
/// attitude, the surfaces in world W and the clinical translations, mm and degrees; last a column of each
/// curve. curves: analysis::flexion_curves() at the frames of the motion.
std::string flexion_csv(const FlexionMotion& motion, const std::vector<analysis::CurveGroup>& curves = {});

/// Whether flexion_csv() writes a column of this name.
bool is_flexion_csv_column(std::string_view name);

/// Names of the Grood-Suntay numbers in tables that also have the attitude, without their unit.
inline constexpr std::array<const char*, n_joint_coordinates> clinical_columns{
    "clinical_flexion", "clinical_varus", "internal_rotation", "anterior", "proximal", "lateral"};

/// One row per cell of the grid, flexion-major: all numbers of the cell, including the smoothed ones. Fields
/// without a value are empty; the status is written by name.
std::string cells_csv(const store::MotionModel& model);

/// Coordinates after `time`, in this order: three angles and the translation of the rotation centre along the
/// reference's axes.
inline constexpr std::array<const char*, 6> opensim_coordinates{"flexion", "varus", "internal",
                                                                "tx",      "ty",    "tz"};

struct OpenSimOptions {
  std::array<std::string, 6> columns;  ///< column name of each of opensim_coordinates
  bool in_degrees = false;             ///< angles in degrees; otherwise radians
  double degrees_per_second = 30.0;    ///< flexion rate that defines time; not used for a sequence
  /// The translations are those of the moving mesh's origin: for joints without offset frames.
  bool has_origin_translations = false;
  std::array<double, 6> sign{1, 1, 1, 1, 1, 1};  ///< of each column; the header names those of -1
};

/// knee_flex_r, knee_add_r, knee_rot_r, knee_tx_r, knee_ty_r, knee_tz_r: the knee of Lenhart (2015) and Smith
/// (2019). Another kind of joint has its name instead ("joint" for "other"); on a left joint they end in _l.
std::array<std::string, 6> opensim_columns(const std::string& joint, Side side);

/// Content of the .sto or .mot file. R = Rz(-flexion) Rx(varus) Ry(internal) takes the moving mesh's axes to
/// the reference's, both canonical; on a left joint varus and internal are rotations about -X and -Y. (tx,
/// ty, tz) in metres is the displacement of the moving point at the rotation centre, which the header names.
/// followers: analysis::follower_curves() at the frames of the motion, as further columns in rad or degrees
/// and m: "follower_patella_flexion_rad". Those of a body without a pose in some frame are left out.
std::string opensim_table(const FlexionMotion& motion, const OpenSimOptions& options,
                          const std::vector<analysis::CurveGroup>& followers = {});

/// Both bodies posed in world W (mm, single precision) as VTK PolyData in XML with appended raw arrays. Cell
/// data: `body` (0 reference, 1 moving), `component`, `material` and `has_contact`; field data: the names
/// indexed by `component` and `material`, the attitude and the clinical numbers.
std::string posed_vtp(const store::MotionModel& model, const FlexionFrame& frame);

/// The cell of the grid that has the pose of this frame of the set "raw", or -1.
Eigen::Index raw_cell(const store::MotionModel& model, const FlexionFrame& frame);

/// The contacts of the raw cell at this frame, as points in world W with `normal`, `distance_mm` and
/// `compartment`; empty if the frame is not a cell of the grid. Only for a motion of the set "raw".
std::string contacts_vtp(const store::MotionModel& model, const FlexionFrame& frame);

struct SeriesEntry {
  double time = 0.0;  ///< flexion in degrees, or the key of a frame
  int part = 0;       ///< 0 bodies, 1 contacts
  std::string file;   ///< relative to the .pvd file
};

/// The .pvd collection file, with the flexion in degrees or the key as time and the set in a comment.
std::string series_pvd(const FlexionMotion& motion, const std::vector<SeriesEntry>& entries);

/// Numbers are written to binary files in little-endian byte order.
static_assert(std::endian::native == std::endian::little, "numbers are copied from memory");

template <typename Number>
void append_value(std::string& bytes, Number value)
{
  char raw[sizeof value];
  std::memcpy(raw, &value, sizeof value);
  bytes.append(raw, sizeof value);
}

}  // namespace vrda::tables
