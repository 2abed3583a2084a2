/// Transfer of solved steps to the cells of a motion model.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <string>
#include <variant>
#include <vector>

#include "core/units.hpp"
#include "model/step_record.hpp"
#include "store/dataset.hpp"
#include "store/motion_model.hpp"

namespace vrda::store {

/// The solver's frame at a flexion index of the grid; Delta may depend on flexion.
SolverFrame solver_frame(const MotionModel& model, std::int32_t flexion);

/// Sets the surfaces of the record's cell: status and counts always, the other values if it is stable. The
/// record must be at the model's scale (core's scaled()); `model` must have axes, push and surfaces.
void set_cell(MotionModel& model, const StepRecord& record);

/// `/clinical` as continuous curves (ContinuousCoordinates): over the rows at the spine's cells, from these
/// along varus. Every use of the surfaces as a curve or a range has them from here; the file keeps the
/// numbers of clinical_coordinates(), which are the same but for whole turns and gimbal lock.
struct ClinicalCurves {
  ClinicalSurfaces surfaces;
  int n_locked = 0;  ///< cells at gimbal lock or beyond
};
ClinicalCurves clinical_curves(const MotionModel& model);

/// Index of the spine cell of each flexion; -1 if it is missing or not stable.
std::vector<Eigen::Index> solved_spine(const MotionModel& model);

/// The poses of a set at flexions (degrees): of the raw motion the spine's cells, else at the varus of
/// `varus_deg` (a row for each flexion; missing or NaN: Motion::balanced_varus_rad).
std::vector<std::optional<Pose>> poses_over_flexion(const store::MotionModel& model, const std::string& set,
                                                    const std::vector<double>& flexion_deg,
                                                    const std::vector<double>& varus_deg = {});

/// The contacts of all cells; `cells` is in grid order.
ContactRows contact_rows(const MotionModel& model, const std::vector<StepRecord>& cells);

/// Compressed rows, cell by cell, of the contacts that `contacts_of(record)` returns (a span of ContactRecord
/// or ContactForce), in W; `measure` and `measures` are the member specific to that type.
template <typename Rows, typename Contact, typename ContactsOf>
Rows compressed_rows(const MotionModel& model, const std::vector<StepRecord>& cells,
                     const ContactsOf& contacts_of, double Contact::*measure,
                     std::vector<double> Rows::*measures)
{
  std::size_t n = 0;
  for (const StepRecord& r : cells) n += contacts_of(r).size();
  Rows rows;
  rows.point_world_mm.resize(static_cast<Eigen::Index>(n), 3);
  rows.normal_world.resize(static_cast<Eigen::Index>(n), 3);
  rows.row_start.push_back(0);
  Eigen::Index row = 0;
  for (const StepRecord& r : cells) {
    const SolverFrame frame = solver_frame(model, r.key.flexion);
    for (const Contact& contact : contacts_of(r)) {
      rows.point_world_mm.row(row) = world_from_solver(frame, contact.point_solver_mm).transpose();
      rows.normal_world.row(row) = world_from_solver(frame, contact.normal_solver).transpose();
      (rows.*measures).push_back(contact.*measure);
      rows.triangle_reference.push_back(contact.triangle_reference);
      rows.triangle_moving.push_back(contact.triangle_moving);
      rows.compartment.push_back(contact.compartment);
      ++row;
    }
    rows.row_start.push_back(row);
  }
  return rows;
}

// Index of a campaign: a table with one row per case and one column per property, and its HDF5 file
// (schemas/campaign.md).

struct IndexColumn {
  std::string name;       ///< letters, digits and '_'
  std::string units;      ///< of numbers: "mm", "degree", "N", "1"; else empty
  std::string long_name;  ///< description for users
  /// [n_rows] texts, numbers (NaN: no value) or codes of `flags`.
  std::variant<std::vector<std::string>, std::vector<double>, std::vector<std::int8_t>> values;
  FlagSet flags = FlagSet::none;
};

struct IndexTable {
  std::string title;
  std::vector<IndexColumn> columns;  ///< the first one is text: the name of each row, unique
};

inline constexpr const char* index_format_name = "vrda campaign index";
inline constexpr const char* index_format_version = "1.0";

/// `table` as a netCDF-4 file whose one dimension is the first column. Equal tables give equal bytes. `path`:
/// its future name, for errors.
std::string index_bytes(const std::string& path, const IndexTable& table);

/// The table as CSV (RFC 4180): a heading, then one line per row; codes as words, NaN as an empty field.
std::string index_csv(const IndexTable& table);

// Figures of a curve over flexion: those of a rotation along the spine (screw-home) that are printed.

/// The finite number for which `is_beyond` any other finite one, of a vector or array; NaN without one.
template <typename Values, typename Compare>
double extreme_of(const Values& values, const Compare& is_beyond)
{
  double extreme = nan;
  for (decltype(values.size()) k = 0; k < values.size(); ++k) {
    const double value = values.data()[k];
    if (std::isfinite(value) && (std::isnan(extreme) || is_beyond(value, extreme))) extreme = value;
  }
  return extreme;
}
/// Largest and smallest finite number of a vector or array; NaN without one.
template <typename Values>
double largest_of(const Values& values)
{
  return extreme_of(values, std::greater<>());
}
template <typename Values>
double smallest_of(const Values& values)
{
  return extreme_of(values, std::less<>());
}

/// Contact forces along Delta of a cell, N.
struct CellForces {
  double all_n = 0.0;
  std::array<double, 3> of_n{};  ///< by Compartment
};
CellForces forces_in(const ForceRows& forces, std::size_t cell);

/// Values (degrees or mm) at flexions; NaN where there is no pose.
struct FlexionCurve {
  std::vector<double> flexion_deg, value;

  void add(double at_deg, double of)
  {
    flexion_deg.push_back(at_deg);
    value.push_back(of);
  }
};

/// Linear between neighbours of ascending flexions, which are equal within `rounding_deg`; NaN beyond the
/// ends and next to a NaN.
double value_at(const FlexionCurve& curve, double flexion_deg, double rounding_deg);

/// Signed changes in degrees and the flexions where they are; NaN without two values.
struct CurveFigures {
  double first_deg = nan, last_deg = nan;    ///< flexions of the first and last value
  double net_deg = nan;                      ///< last value less the first
  double peak_deg = nan, peak_at_deg = nan;  ///< value farthest from the first, less that
  double change_deg = nan, change_from_deg = nan, change_to_deg = nan;  ///< largest within change_window_deg
};
inline constexpr double change_window_deg = 5.0;

/// The largest change is that of the polygon through the values between two flexions at most
/// change_window_deg apart; NaN if flexion does not increase, as in a sequence of frames.
CurveFigures curve_figures(const FlexionCurve& curve);

/// Internal rotation at the spine cell of each flexion that has one.
FlexionCurve spine_rotation(const store::MotionModel& model);

/// The largest change of theta between neighbouring flexions of the spine that are both solved; NaN without,
/// and for a sequence of frames.
struct SpineJump {
  double change_deg = nan;  ///< absolute
  double from_deg = nan, to_deg = nan;
};
/// A larger change is a discontinuity.
inline constexpr double spine_jump_deg = 3.0;
SpineJump spine_jump(const store::MotionModel& model);

/// "theta jumps by 12.6 degrees between flexion 5 and 10 of the spine"; empty up to spine_jump_deg.
std::string text_of(const SpineJump& jump);

/// "net +2.1 degrees from flexion 0 to 90, peak +9.8 at 38, largest change +11.8 per 5 degrees of flexion (40
/// to 45)"; "none" without two values.
std::string text_of(const CurveFigures& figures);

}  // namespace vrda::store
