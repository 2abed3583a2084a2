/// The six numbers of a pose that are scored, and the pose of six numbers (schemas/clinical.md).
#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/units.hpp"
#include "model/coordinates.hpp"
#include "model/mesh.hpp"
#include "store/motion_model.hpp"

namespace vrda::analysis {

/// The translations of the coordinates.
enum class Translations {
  rotation_centre,  ///< of the rotation centre along the Grood-Suntay axes: anterior, proximal, lateral
  mesh_origin,      ///< of the moving meshes' origin along the reference's axes: ant, prox, lat of an export
};

/// What the numbers of a pose depend on.
struct Convention {
  Side side = Side::right;
  Eigen::Vector3d rotation_centre_mm = Eigen::Vector3d::Zero();  ///< canonical, joint's own side
  Translations translations = Translations::rotation_centre;
  /// Unit, canonical, joint's own side: the axes are turned by the shortest rotation from this direction to
  /// +Y, as for a Delta of this direction. Empty: the joint's own axes.
  std::optional<Eigen::Vector3d> long_axis = std::nullopt;
};

/// flexion, varus, internal rotation (rad), anterior, proximal, lateral (mm); signs of model/coordinates.hpp.
using Coordinates = std::array<double, 6>;
inline constexpr std::size_t n_scored = 6, n_angles = 3;
/// Indices of Coordinates.
inline constexpr std::size_t at_flexion = 0, at_varus = 1, at_internal = 2;

Coordinates coordinates_of(const Pose& X_reference_moving, const Convention& convention);

/// The convention of the same joint reflected to a right one. Coordinates do not change.
Convention right_sided(Convention convention);

/// The pose X_reference_moving with these coordinates, of the joint reflected to a right one if it is left.
Pose right_sided_pose(const Coordinates& value, const Convention& convention);

/// A rigid transform of canonical coordinates, reflected in the sagittal plane.
Pose reflected(const Pose& X);

// Motions as rows of coordinates, and the rows of a found motion that belong to the frames of a measured
// one.

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

/// The coordinates of a follower (model/coordinates.hpp) in a set: at the frames of a sequence, or at the
/// flexions `flexion_deg` (empty: the model's) with the set's own varus. Throws InputError naming `file` for
/// a body that the model does not have.
Sequence follower_sequence(const std::string& file, const store::MotionModel& model, const std::string& set,
                           const std::string& follower, const std::vector<double>& flexion_deg = {});

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

// How far a found quantity is from a measured one, and the scores of a constant and a straight
// line.

/// Of d = found - measured over n frames, in the unit of the quantity; all but n are NaN without frames.
struct Statistics {
  std::size_t n = 0;
  double rms = nan;
  double bias = nan;           ///< mean of d
  double shape = nan;          ///< RMS of d - bias: rms^2 = bias^2 + shape^2
  double correlation = nan;    ///< Pearson's, of found and measured; NaN where one of them is constant
  double largest = nan;        ///< absolute value of d
  std::size_t largest_at = 0;  ///< the first frame that has it
};

/// `found` and `measured` have the same length.
Statistics statistics(const std::vector<double>& found, const std::vector<double>& measured);

/// value = mean + slope (x - mean_x).
struct Line {
  double mean_x = 0.0, mean = 0.0, slope = 0.0;
  double at(double x) const { return mean + slope * (x - mean_x); }
};

/// The mean of `values`, which are not empty.
Line constant(const std::vector<double>& values);

/// The least-squares line of `values` over `x`, of the same length; the constant where all x are equal.
Line straight_line(const std::vector<double>& x, const std::vector<double>& values);

/// RMS of the line's values minus the values; NaN without values.
double rms_of(const Line& line, const std::vector<double>& x, const std::vector<double>& values);

// The rigid transform of each body's frame that brings found poses nearest to measured ones: the frames of a
// measurement and of the meshes rarely coincide.

/// measured ~ X_reference * found * X_moving.
struct RigidAlignment {
  Pose X_reference = Pose::Identity();  ///< moves the found reference object to the measured one
  Pose X_moving = Pose::Identity();     ///< takes the measured moving object's vertices to the found one's
  double rms_mm = 0.0;   ///< distance left between both images of the points `alignment_points_mm`
  int n_determined = 0;  ///< directions of the twelve in which the poses determine both transforms
  bool is_converged = false;
};

/// Six points, this far from the rotation centre along the moving object's axes, carry the distance that is
/// minimised: half the width of a condyle pair, so that a degree counts as 0.5 mm.
inline constexpr double alignment_radius_mm = 30.0;

/// Least squares over both transforms, for all frames together. Both lists have the same length, at least 1.
/// Method: from the 24 rotations of a cube for X_reference, alternating closed-form fits (Umeyama (1991) IEEE
/// PAMI 13:376-380, without scale), then Gauss-Newton on both. The best of these gives the noise. From
/// the identity, Gauss-Newton then steps only along directions whose effect exceeds that noise (a hinge
/// leaves its axis undetermined, a short motion almost). Its result is used unless the best has less than
/// half its distance.
RigidAlignment rigid_alignment(const std::vector<Pose>& found, const std::vector<Pose>& measured,
                               const Eigen::Vector3d& rotation_centre_mm);

// The comparison of a found motion with a measured one, coordinate by coordinate.

/// What is fitted to the measurement before it is scored.
enum class Alignment {
  none,
  constant,  ///< an offset of each coordinate
  rigid,     ///< a rigid transform of each body's frame
};

/// What the straight line of the baseline depends on.
enum class LineOver { flexion, key };

/// Rows [first, last) of the measurement.
struct RowRange {
  std::size_t first = 0;
  std::size_t last = static_cast<std::size_t>(-1);
  bool contains(std::size_t row) const { return row >= first && row < last; }
};

struct ScoreOptions {
  Convention convention;
  Alignment align = Alignment::none;
  LineOver line_over = LineOver::flexion;
  RowRange scored;              ///< rows to score
  std::optional<RowRange> fit;  ///< rows that fit alignment and baselines; default: those scored
};

/// Of one coordinate; rad or mm.
struct CoordinateScore {
  Statistics statistics;
  std::size_t largest_row = 0;            ///< of the measurement
  double offset = 0.0;                    ///< subtracted from the found values
  double constant_rms = nan;              ///< baseline: the mean of the measurement
  double line_rms = nan;                  ///< baseline: its least-squares line
  std::vector<std::size_t> undetermined;  ///< rows with a pose that does not determine the coordinate
};

struct Score {
  std::array<CoordinateScore, n_scored> coordinates;
  std::size_t n_scored_rows = 0, n_fit_rows = 0;
  std::map<std::string, std::vector<std::size_t>> missing;  ///< rows to score without a pose, by reason
  std::optional<RigidAlignment> rigid;  ///< of the joint's own side; with Alignment::rigid
};

/// Scores `found`, a row for each of `measured`. A row counts if both have a pose; of these a coordinate
/// counts where both determine it. Baselines and offsets are fitted to the same rows. Throws InputError
/// naming the measurement if no row to score or to fit counts.
Score score(const std::vector<Row>& found, const Sequence& measured, const ScoreOptions& options);

}  // namespace vrda::analysis
