/// The numbers of a table of poses, and what its names and header state about their meaning.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tables/motion_convention.hpp"

namespace vrda::tables {

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

/// The coordinate of an OpenSim column: "knee_flex_r" for "/jointset/knee_r/knee_flex_r/value".
std::string coordinate_name(std::string_view column);

/// `names`, then those of `vrda export` for every kind of joint and side: of "flex" knee_flex_r, knee_flex_l,
/// hip_flex_r ...
std::vector<std::string> with_opensim_names(std::vector<std::string> names, const std::string& coordinate);

}  // namespace vrda::tables
