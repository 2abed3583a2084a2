/// Transfer of solved steps to the cells of a motion model.
#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

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

/// The contacts of all cells; `cells` is in grid order.
ContactRows contact_rows(const MotionModel& model, const std::vector<StepRecord>& cells);

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

}  // namespace vrda::store
