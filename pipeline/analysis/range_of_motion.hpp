/// Range of motion: at which rotations one object can be in contact with the other without overlap, within
/// limits of translation, opening and fibre strain, and what prevents it elsewhere.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/fields.hpp"
#include "geometry/gap_query.hpp"
#include "job/case.hpp"
#include "model/coordinates.hpp"
#include "store/journal.hpp"

namespace vrda::analysis {

/// Why an attitude is in the range or not. The values are those of the files.
enum class RomStatus : std::int8_t { in_range, contact, border, fibre, nothing_ahead, not_converged };
inline constexpr Named<RomStatus> rom_status_names[] = {
    {RomStatus::in_range, "in_range", "in range: in contact without overlap, within the limits"},
    {RomStatus::contact, "contact", "contact: every position within the limits overlaps"},
    {RomStatus::border, "border", "border: the contact is where a surface ends"},
    {RomStatus::fibre, "fibre", "fibre: a fibre is strained beyond the limit"},
    {RomStatus::nothing_ahead, "nothing_ahead", "nothing ahead: no surface along Delta"},
    {RomStatus::not_converged, "not_converged", "not converged: the seat was not found to tolerance"}};
constexpr const auto& names_of(RomStatus)
{
  return rom_status_names;
}
using core::name_of;  // next to the room's own

/// Names of the three rotations, in the order of the axes.
inline constexpr const char* rotation_names[] = {"flexion", "varus", "internal"};

/// Rotations after Grood and Suntay, rad, each ascending with at least one value.
struct RomAxes {
  std::array<std::vector<double>, 3> rad;  ///< flexion, varus, internal rotation

  std::size_t n_cells() const { return rad[0].size() * rad[1].size() * rad[2].size(); }
  /// Rows of the three rotations at a cell; the last rotation changes first.
  std::array<std::size_t, 3> rows_at(std::size_t cell) const
  {
    const std::size_t n_varus = rad[1].size(), n_internal = rad[2].size();
    return {cell / (n_varus * n_internal), cell / n_internal % n_varus, cell % n_internal};
  }
  std::array<double, 3> rotations_at(std::size_t cell) const
  {
    const std::array<std::size_t, 3> at = rows_at(cell);
    return {rad[0][at[0]], rad[1][at[1]], rad[2][at[2]]};
  }
};

struct RomLimits {
  double translation_mm =
      2.0;                  ///< of the rotation centre from the neutral seat, along each axis across Delta
  double opening_mm = 0.5;  ///< of the rotation centre from the neutral seat, against Delta
  double strain = 0.1;      ///< of any fibre
};

struct RomCell {
  RomStatus status = RomStatus::not_converged;
  /// Of the rotation centre's moving point from the neutral seat, along the reference's canonical axes of the
  /// joint's own side, at the highest seat within the limits.
  Eigen::Vector3d translation_mm = Eigen::Vector3d::Zero();
  double opening_mm = nan;      ///< its part against Delta; negative: deeper than the neutral seat
  double largest_strain = nan;  ///< of the fibres; NaN without any
  std::int32_t fibre = -1;      ///< row of the fibre with that strain
  std::int32_t component_reference = -1, component_moving = -1;  ///< in contact
  bool is_connected = false;  ///< in range, and so are all cells of a path of neighbours from the neutral one
};

/// What a journal holds of it.
constexpr auto fields_of(const RomCell*)
{
  return std::tuple{Field{"status", &RomCell::status},
                    Field{"translation_mm", &RomCell::translation_mm, unit::mm},
                    Field{"opening_mm", &RomCell::opening_mm, unit::mm},
                    Field{"largest_strain", &RomCell::largest_strain},
                    Field{"fibre", &RomCell::fibre},
                    Field{"component_reference", &RomCell::component_reference},
                    Field{"component_moving", &RomCell::component_moving}};
}

/// A cell as it was solved.
struct SolvedCell {
  RomCell cell;
  /// Position of its seat from the neutral one, across Delta in the query's frame: the next cell's start.
  Eigen::Vector2d across_mm = Eigen::Vector2d::Zero();
};

constexpr auto fields_of(const SolvedCell*)
{
  return std::tuple{Field{"cell", &SolvedCell::cell}, Field{"across_mm", &SolvedCell::across_mm, unit::mm}};
}

/// Cells along one axis, solved outward from the neutral one by one thread.
struct RomLine {
  std::int8_t axis = 0;
  std::array<std::int32_t, 3> at{};  ///< rows of the other axes; 0 of its own
  std::vector<SolvedCell> cells;     ///< all of the axis
};

constexpr auto fields_of(const RomLine*)
{
  return std::tuple{Field{"axis", &RomLine::axis}, Field{"at", &RomLine::at},
                    Field{"cells", &RomLine::cells}};
}
inline bool is_sound(const RomLine& line)
{
  return line.axis >= 0 && line.axis < 3;
}

struct RangeOfMotion {
  RomAxes axes;
  RomLimits limits;
  BodyIndex delta_body = BodyIndex::moving;
  std::array<std::size_t, 3> neutral{};  ///< the cell nearest to zero rotations
  Pose X_neutral = Pose::Identity();     ///< X_reference_moving of the neutral seat, canonical
  std::vector<RomCell> cells;            ///< [n_flexion, n_varus, n_internal]
};

struct RomPlan {
  RomAxes axes;
  RomLimits limits;
  BodyIndex delta_body = BodyIndex::moving;
  int n_threads = 1;
  std::function<void(std::size_t n_done)> on_progress = {};  ///< called from any worker
  std::function<bool()> is_stopped = {};                     ///< true: returns with no cells
  /// `recall` returns a line of an earlier run, or nothing; `keep` stores a new one. Called from any worker.
  std::function<std::optional<RomLine>(std::int8_t axis, const std::array<std::int32_t, 3>& at)> recall = {};
  std::function<void(const RomLine&)> keep = {};
  /// Solves, besides the line along flexion, only every count-th flexion from the number-th on, and returns
  /// with no cells: its result is the lines passed to `keep`.
  std::optional<store::Shard> shard = {};
};

/// The neutral seat is searched from the job's start pose, at the cell nearest to zero. A cell's seat is
/// searched from that of its neighbour towards the neutral cell, from the neutral seat, and next to the range
/// from four positions between; the first within the limits counts. The same bits for any number of threads.
/// Throws InputError naming the job's title if the objects have no seat at the neutral cell.
RangeOfMotion range_of_motion(const job::Case& job_case, const RomPlan& plan);

/// Row of a cell.
inline std::size_t cell_at(const RomAxes& axes, std::size_t i, std::size_t j, std::size_t k)
{
  return (i * axes.rad[1].size() + j) * axes.rad[2].size() + k;
}

/// Number of cells in range, and the volume that they represent in degrees to the power of the number of
/// driven rotations: each axis by the trapezoidal rule, so that a range filled to the ends is the driven box.
struct RomVolume {
  std::size_t n_cells = 0;
  double volume = 0.0, driven_volume = 0.0;
  int n_driven = 0;  ///< rotations with more than one value
};
RomVolume volume_of(const RangeOfMotion& range, const std::function<bool(std::size_t cell)>& counts);
RomVolume volume_of(const RangeOfMotion& range);

// The seat of an object that is pressed along Delta and held in all rotations: the position across Delta,
// within limits, where it rises highest. Lengths in mm, frame S (model/frames.hpp), rad.

struct SeatTask {
  MovingPose centre;      ///< of the limits; its height is not used
  double limit_mm = 0.0;  ///< largest distance from the centre along X and along Z; may be infinite
  Eigen::Vector2d start_mm = Eigen::Vector2d::Zero();  ///< from the centre along X and Z, within the limit
};

struct Seat {
  MovingPose pose;  ///< in contact
  std::vector<geometry::GapFeature> contacts;
  bool is_found = false;      ///< false: nothing ahead of the start
  bool is_converged = false;  ///< to 1e-5 mm of height
};

/// A local maximum over the two translations across Delta of the height of first contact of an object that
/// approaches along Delta. At fixed rotations each feature of a contact limits the height by a plane, so each
/// step is the highest point below the planes found so far, in a trust region. Depends on the task only.
Seat highest_seat(geometry::GapQuery& query, const SeatTask& task);

}  // namespace vrda::analysis
