/// Motions as rows of coordinates, and the rows of a found motion that belong to the frames of a measured
/// one.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "analysis/coordinates.hpp"
#include "store/motion_model.hpp"

namespace vrda::analysis {

/// The coordinates of one frame.
struct Row {
  Coordinates value{};
  std::array<bool, n_scored> is_determined{true, true, true, true, true, true};
  /// Why there is no pose: a status of the model, or one of the reasons below. Empty: there is one.
  std::string missing = {};
};

inline constexpr const char* outside_range = "outside_range";  ///< of the found motion's poses
inline constexpr const char* unsolved_cell = "unsolved_cell";  ///< between attitudes of which one is unsolved
inline constexpr const char* no_such_key = "no_such_key";      ///< in the found motion

struct Sequence {
  std::string file;
  std::string key_name;     ///< "time_s", "frame", "flexion_deg", ...
  std::vector<double> key;  ///< [n]
  std::vector<Row> rows;    ///< [n]
};

/// The poses of a measured motion as rows.
Sequence sequence_of(const std::string& file, const std::string& key_name, const std::vector<double>& key,
                     const std::vector<Pose>& X_reference_moving, const Convention& convention);

/// Whether each row of the model has one pose: varus was free, or the set depends on flexion only.
bool is_sequence(const store::MotionModel& model, const std::string& set);

/// The poses of a set at the flexions of the model, a row each; of a grid with given varus at each cell,
/// flexion by flexion. `set` is one of store::all_set_names(model). A row without a pose keeps its flexion.
Sequence sequence_of(const std::string& file, const store::MotionModel& model, const std::string& set,
                     const Convention& convention);

/// For each row of `measured` the row of `found` with the same key (to nine digits).
std::vector<Row> rows_by_key(const Sequence& found, const Sequence& measured);

/// For each row of `measured` the coordinates of `found` at the measured flexion, linear between its rows.
/// Empty across a row without a pose, unless `bridges`. Throws InputError if the flexions of `found`
/// do not ascend.
std::vector<Row> rows_over_flexion(const Sequence& found, const Sequence& measured, bool bridges);

/// For each measured pose (X_reference_moving, canonical) the pose of the model's set at its attitude:
/// flexion and varus about the model's own axes (Delta). The model's varus is given.
std::vector<Row> rows_at_attitudes(const store::MotionModel& model, const std::string& set,
                                   const Sequence& measured, const Convention& convention);

}  // namespace vrda::analysis
