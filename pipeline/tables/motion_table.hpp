/// How the numbers of a table of poses are meant. schemas/motion-files.md defines the terms.
#pragma once

#include <Eigen/Core>

#include <array>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/fields.hpp"
#include "model/coordinates.hpp"
#include "model/frames.hpp"
#include "model/mesh.hpp"

namespace vrda::tables {

enum class AngleUnit { degrees, radians };
inline constexpr Named<AngleUnit> angle_unit_names[] = {{AngleUnit::degrees, "deg"},
                                                        {AngleUnit::radians, "rad"}};
constexpr const auto& names_of(AngleUnit)
{
  return angle_unit_names;
}

/// Rotations about the body's own axes in this order: zxy is R = Rz Rx Ry.
enum class AngleOrder { xyz, xzy, yxz, yzx, zxy, zyx };
inline constexpr Named<AngleOrder> angle_order_names[] = {{AngleOrder::xyz, "xyz"}, {AngleOrder::xzy, "xzy"},
                                                          {AngleOrder::yxz, "yxz"}, {AngleOrder::yzx, "yzx"},
                                                          {AngleOrder::zxy, "zxy"}, {AngleOrder::zyx, "zyx"}};
constexpr const auto& names_of(AngleOrder)
{
  return angle_order_names;
}
inline constexpr auto all_orders = values_in(angle_order_names);

enum class Direction { moving_in_reference, reference_in_moving };
inline constexpr Named<Direction> direction_names[] = {
    {Direction::moving_in_reference, "moving-in-reference"},
    {Direction::reference_in_moving, "reference-in-moving"}};
constexpr const auto& names_of(Direction)
{
  return direction_names;
}

/// Axes and origins of the poses.
enum class TableAxes {
  canonical,  ///< of the motion model
  files,      ///< of the mesh files, before the frames of the job; lengths in the table's unit
};
inline constexpr Named<TableAxes> table_axes_names[] = {{TableAxes::canonical, "canonical"},
                                                        {TableAxes::files, "files"}};
constexpr const auto& names_of(TableAxes)
{
  return table_axes_names;
}

/// The point whose position or displacement the three lengths are.
enum class LengthPoint {
  origin,        ///< origin of the moving mesh, along the axes of the reference
  centre,        ///< displacement of the rotation centre along the axes of the reference
  grood_suntay,  ///< the same along the Grood-Suntay axes (schemas/clinical.md)
};
inline constexpr Named<LengthPoint> length_point_names[] = {{LengthPoint::origin, "origin"},
                                                            {LengthPoint::centre, "centre"},
                                                            {LengthPoint::grood_suntay, "grood-suntay"}};
constexpr const auto& names_of(LengthPoint)
{
  return length_point_names;
}

/// A complete convention. `side` is the one for which the signs of the table hold.
struct Convention {
  double length_mm = 1.0;  ///< of the table's unit of length
  AngleUnit angles = AngleUnit::degrees;
  AngleOrder order = AngleOrder::zxy;
  Direction direction = Direction::moving_in_reference;
  TableAxes axes = TableAxes::canonical;
  Side side = Side::right;
  LengthPoint lengths = LengthPoint::origin;
};

/// The part of a convention that a user or a file states.
struct StatedConvention {
  std::optional<double> length_mm;
  std::optional<AngleUnit> angles;
  std::optional<AngleOrder> order;
  std::optional<Direction> direction;
  std::optional<TableAxes> axes;
  std::optional<Side> side;
  std::optional<LengthPoint> lengths;
};

/// What a job contributes. The poses map points of the mesh files, in mm, to canonical coordinates.
struct JointFrame {
  Side side = Side::right;
  Eigen::Vector3d rotation_centre_mm = Eigen::Vector3d::Zero();  ///< canonical
  Pose X_canonical_reference = Pose::Identity();
  Pose X_canonical_moving = Pose::Identity();
  /// False: it may turn more about its other axes; empty: unknown.
  std::optional<bool> has_large_flexion = {};
};

/// Columns of a table that its names do not state.
struct TableColumns {
  /// Column of a coordinate: flexion, varus, internal, rx, ry, rz, tx, ty, tz, anterior, proximal, lateral.
  /// After an optional sign, by which its numbers are multiplied: "-knee_angle_r". Without one the sign is
  /// the one that the header states.
  std::map<std::string, std::string> of_coordinate;
  bool may_be_absent = false;  ///< a column of `of_coordinate`: its coordinate then has the usual names
  std::string key;  ///< empty: time, time_s, frame, gait_percent or stance_percent, else the frames' numbers
  std::string moving_prefix;     ///< of T11 to T34: "tibia_proximal_r_"
  std::string reference_prefix;  ///< if set, both poses are in a common frame, e.g. of a scanner
  std::string reference_file;    ///< if set, the file with the poses of the reference in that frame
};

struct MotionConvention {
  StatedConvention stated;
  JointFrame joint;
  TableColumns columns;
};

/// "mm", "cm" or "m".
std::string length_unit_name(double length_mm);

/// NAME by COORDINATE of texts "COORDINATE=NAME". Throws InputError naming `command` and `option` for another
/// text and for a coordinate that is given twice.
std::map<std::string, std::string> names_by_coordinate(const std::string& command, const std::string& option,
                                                       const std::vector<std::string>& texts);

/// `stated`, else `file`, else the default of Convention; the side's default is that of the joint.
Convention completed(const StatedConvention& stated, const StatedConvention& file, Side joint_side);

// The numbers of a table of poses, and what its names and header state about their meaning.

/// Entries of a pose [R t; 0 1], row by row, without the last row.
using PoseEntries = std::array<double, 12>;

/// Three angles about X, Y and Z in the unit of the table, with the sign of the column's definition on a
/// right joint (flexion is about -Z), and three lengths along them.
struct PoseCoordinates {
  std::array<double, 3> angle{};
  std::array<double, 3> length{};
};

/// Either matrices or coordinates of each frame.
struct MotionTable {
  std::string file;
  std::string key_name;
  std::vector<double> key;                ///< [n] strictly ascending
  std::vector<int> line;                  ///< [n] of the file
  std::vector<PoseEntries> matrices;      ///< [n], or empty
  std::vector<PoseEntries> of_reference;  ///< [n] if both bodies are given in a common frame
  std::vector<PoseCoordinates> coordinates;
  bool are_angles_clinical = false;   ///< named flexion, varus, internal: positive on both sides
  bool are_lengths_clinical = false;  ///< lateral is positive on both sides
  StatedConvention stated;            ///< by names and header
  /// The point of the lengths `centre` and `grood_suntay` that the file names, canonical; else the job's.
  std::optional<Eigen::Vector3d> point_mm;
  std::array<std::string, 3> angle_columns;  ///< of `coordinates`
  std::vector<std::string> absent_columns;   ///< with TableColumns::may_be_absent
  std::vector<std::string> warnings;         ///< one line each

  bool has_matrices() const { return !matrices.empty(); }
};

/// The most frames that a file may have.
inline constexpr std::size_t max_frames = 100000;

/// Reads a .csv, .sto, .mot or .tra file by its name; any other name as CSV. Throws InputError naming file,
/// line and column: no or too many rows, a missing column, a field that is not a finite number of magnitude
/// up to 1e9, a key that does not increase.
MotionTable read_motion_table(const std::string& file, const TableColumns& columns);
/// The same from the text of a file. `columns.reference_file` is not read.
MotionTable motion_table_from_text(const std::string& file, const std::string& text,
                                   const TableColumns& columns);

/// The coordinates of a body that follows the joint in each frame; empty without its columns. Names: with
/// `follower_NAME_` or `NAME_` before the names of its coordinates (schemas/followers.md) and a unit, as in
/// an export, or those of `columns`, by COORDINATE, after an optional sign. Throws InputError as
/// read_motion_table(), and for a part of the six.
std::vector<JointCoordinates> read_follower(const std::string& file, const std::string& follower,
                                            const std::map<std::string, std::string>& columns = {});

/// The coordinate of an OpenSim column: "knee_flex_r" for "/jointset/knee_r/knee_flex_r/value".
std::string coordinate_name(std::string_view column);

/// `names`, then those of `vrda export` for every kind of joint and side: of "flex" knee_flex_r, knee_flex_l,
/// hip_flex_r ...
std::vector<std::string> with_opensim_names(std::vector<std::string> names, const std::string& coordinate);

// The header of an OpenSim table: key=value lines and text up to `endheader`.

/// What the keys state; unknown keys and text state nothing.
struct TableHeader {
  std::optional<AngleUnit> angles = {};           ///< inDegrees
  std::optional<LengthPoint> lengths = {};        ///< translations
  std::optional<Eigen::Vector3d> point_mm = {};   ///< rotation_centre_mm, canonical
  std::string key_name = {};                      ///< key
  std::vector<std::string> negated_columns = {};  ///< negated
  std::vector<std::string> warnings = {};         ///< one line each, with file and line
};

/// Reads the lines of `text` before line `end_line` (from 1). Case, quotes, and blanks, `_` and `-` in a key
/// or word do not matter. Warns of a key that differs from a known one by a typing slip, and of a known key
/// in a comment. Throws InputError naming file, line and key for another value than the known ones, and for
/// two lines of one key that differ.
TableHeader table_header(const std::string& file, std::string_view text, std::size_t end_line);

/// OpenSim's names are parts of paths: characters but letters, digits, "_", "-" and "." become underscores.
std::string opensim_name(const std::string& text);

/// The poses of the table's frames under `convention`. Throws InputError naming file and line for a matrix
/// that is not a rotation within 0.01 per element of R^T R, or mirrors, and for a position beyond 1e9 mm.
std::vector<Pose> poses_of(const MotionTable& table, const Convention& convention, const JointFrame& joint);

}  // namespace vrda::tables
