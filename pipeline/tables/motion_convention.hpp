/// How the numbers of a table of poses are meant. schemas/motion-files.md defines the terms.
#pragma once

#include <Eigen/Core>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "model/frames.hpp"
#include "model/mesh.hpp"

namespace vrda::tables {

enum class AngleUnit { degrees, radians };

/// Rotations about the body's own axes in this order: zxy is R = Rz Rx Ry.
enum class AngleOrder { xyz, xzy, yxz, yzx, zxy, zyx };

enum class Direction { moving_in_reference, reference_in_moving };

/// Axes and origins of the poses.
enum class TableAxes {
  canonical,  ///< of the motion model
  files,      ///< of the mesh files, before the frames of the job; lengths in the table's unit
};

/// The point whose position or displacement the three lengths are.
enum class LengthPoint {
  origin,        ///< origin of the moving mesh, along the axes of the reference
  centre,        ///< displacement of the rotation centre along the axes of the reference
  grood_suntay,  ///< the same along the Grood-Suntay axes (schemas/clinical.md)
};

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

inline constexpr AngleOrder all_orders[] = {AngleOrder::xyz, AngleOrder::xzy, AngleOrder::yxz,
                                            AngleOrder::yzx, AngleOrder::zxy, AngleOrder::zyx};

/// The words of the command line: "mm", "deg", "zxy", "moving-in-reference", "files", "left", "centre".
std::string length_unit_name(double length_mm);
const char* name_of(AngleUnit unit);
const char* name_of(AngleOrder order);
const char* name_of(Direction direction);
const char* name_of(TableAxes axes);
const char* name_of(LengthPoint point);
const char* name_of_side(Side side);

/// "deg" or "rad"; empty for another word.
std::optional<AngleUnit> angle_unit_named(const std::string& word);

/// NAME by COORDINATE of texts "COORDINATE=NAME". Throws InputError naming `command` and `option` for another
/// text and for a coordinate that is given twice.
std::map<std::string, std::string> names_by_coordinate(const std::string& command, const std::string& option,
                                                       const std::vector<std::string>& texts);

/// `stated`, else `file`, else the default of Convention; the side's default is that of the joint.
Convention completed(const StatedConvention& stated, const StatedConvention& file, Side joint_side);

}  // namespace vrda::tables
