#include "analysis/sequence.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>

#include "model/clinical.hpp"
#include "core/error.hpp"
#include "model/step_record.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "store/poses.hpp"
#include "analysis/statistics.hpp"

namespace vrda::analysis {
namespace {

// Tolerance for equal angles of two files: rounding.
constexpr double same_angle_rad = rad_from_deg(1e-9);
constexpr double same_key = 1e-9;  // of keys of some 1, relative for larger ones

using Determined = decltype(Row::is_determined);
const Determined all_determined = Row{}.is_determined;

Row row_of(const Pose& X_reference_moving, const Determined& determined, const Convention& convention)
{
  Row row{coordinates_of(X_reference_moving, convention)};
  row.is_determined = determined;
  return row;
}

Row missing_row(const std::string& reason, double flexion_rad)
{
  Row row;
  row.value.fill(nan);
  row.value[at_flexion] = flexion_rad;
  row.missing = reason;
  return row;
}

/// Of the cell: theta as internal rotation, and the free coordinates of a job that has roles.
Determined determined_in(const store::MotionModel& model, Eigen::Index i, Eigen::Index j)
{
  Determined determined = all_determined;
  determined[at_internal] = model.theta_determined(i, j) != 0;
  if (!model.coordinates) return determined;
  const auto cell = static_cast<std::size_t>(i * model.status.cols() + j);
  for (std::size_t c = 0; c < n_scored; ++c)
    determined[c] = determined[c] && model.coordinates->determined[n_scored * cell + c] != 0;
  return determined;
}

Row raw_row(const store::MotionModel& model, Eigen::Index i, Eigen::Index j, const Convention& convention)
{
  const auto flexion_rad = rad_from_deg(model.flexion_deg[static_cast<std::size_t>(i)]);
  if (model.status(i, j) != status_stable)
    return missing_row(name_of(static_cast<StepStatus>(model.status(i, j))), flexion_rad);
  const auto cell = static_cast<std::size_t>(i * model.status.cols() + j);
  return row_of(store::pose_in(model.X_reference_moving, cell), determined_in(model, i, j), convention);
}

Row row_at(const store::Motion& motion, const Attitude& attitude, const Determined& determined,
           const Convention& convention)
{
  const store::JointPose pose = motion.at(attitude);
  if (pose.status != store::PoseStatus::solved) return missing_row(unsolved_cell, attitude.flexion_rad);
  return row_of(pose.X_reference_moving, determined, convention);
}

bool is_same_key(double a, double b)
{
  return std::abs(a - b) <= same_key * std::max(1.0, std::max(std::abs(a), std::abs(b)));
}

/// `first` + share of the way to `second`, by the shorter way around for the angles.
Row between(const Row& first, const Row& second, double share)
{
  Row row = first;
  for (std::size_t c = 0; c < n_scored; ++c) {
    const double end = c < n_angles ? nearest_turn(second.value[c], first.value[c]) : second.value[c];
    row.value[c] = first.value[c] + share * (end - first.value[c]);
    row.is_determined[c] = first.is_determined[c] && second.is_determined[c];
  }
  return row;
}

/// Rows with a pose by ascending flexion, for evaluation between them.
class OverFlexion {
 public:
  OverFlexion(const Sequence& found, bool bridges)
  {
    bool is_after_hole = false;
    for (const Row& row : found.rows) {
      if (row.missing.empty()) {
        require_ascending(found, row);
        rows_.push_back(row);
        is_after_hole_.push_back(is_after_hole && !bridges);
      }
      is_after_hole = !row.missing.empty();
    }
  }

  Row at(double flexion_rad) const
  {
    if (rows_.empty() || flexion_rad < rows_.front().value[at_flexion] - same_angle_rad ||
        flexion_rad > rows_.back().value[at_flexion] + same_angle_rad)
      return missing_row(outside_range, flexion_rad);
    const auto after = std::lower_bound(rows_.begin(), rows_.end(), flexion_rad - same_angle_rad,
                                        [](const Row& row, double x) { return row.value[at_flexion] < x; });
    if (after == rows_.end()) return rows_.back();
    if (after == rows_.begin() || after->value[at_flexion] <= flexion_rad + same_angle_rad) return *after;
    if (is_after_hole_[static_cast<std::size_t>(after - rows_.begin())])
      return missing_row(unsolved_cell, flexion_rad);
    const Row& first = *std::prev(after);
    const double width_rad = after->value[at_flexion] - first.value[at_flexion];
    return between(first, *after, (flexion_rad - first.value[at_flexion]) / width_rad);
  }

 private:
  void require_ascending(const Sequence& found, const Row& row) const
  {
    if (rows_.empty() || rows_.back().value[at_flexion] < row.value[at_flexion]) return;
    throw InputError(
        {found.file, "flexion",
         shortest_decimal(deg_from_rad(row.value[at_flexion])) + " after " +
             shortest_decimal(deg_from_rad(rows_.back().value[at_flexion])) + " degrees",
         "flexions that ascend; --match key if both motions have the same key, or --long-axis for a motion "
         "that bends about other axes"});
  }

  std::vector<Row> rows_;
  std::vector<bool> is_after_hole_;
};

/// Index of the interval of the axis that contains the value; the nearest one for a value outside.
std::size_t interval_of(const std::vector<double>& axis, double value)
{
  const auto after = std::upper_bound(axis.begin(), axis.end(), value);
  const auto i = std::max<std::ptrdiff_t>(after - axis.begin() - 1, 0);
  return std::min(static_cast<std::size_t>(i), axis.size() < 2 ? 0 : axis.size() - 2);
}

/// Whether each coordinate is determined at all cells around the attitude.
Determined determined_around(const store::MotionModel& model, const Attitude& attitude)
{
  Determined determined = all_determined;
  const std::size_t i = interval_of(model.flexion_deg, deg_from_rad(attitude.flexion_rad));
  const std::size_t j = interval_of(model.varus_deg, deg_from_rad(attitude.varus_rad));
  for (std::size_t a = i; a < std::min(i + 2, model.flexion_deg.size()); ++a) {
    for (std::size_t b = j; b < std::min(j + 2, model.varus_deg.size()); ++b) {
      const Determined here =
          determined_in(model, static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b));
      for (std::size_t c = 0; c < n_scored; ++c) determined[c] = determined[c] && here[c];
    }
  }
  return determined;
}

/// The attitude of a pose about the model's own axes: R_S = Rz(-flexion) Rx(varus) Ry(theta) in the solver's
/// frame. Delta may depend on flexion, so the flexion that chose it is found by repetition.
Attitude attitude_of(const Row& row, const Convention& convention, const store::Motion& motion)
{
  const Pose X = right_sided_pose(row.value, convention);
  const bool is_left = convention.side == Side::left;
  Attitude attitude{row.value[at_flexion], row.value[at_varus]};
  for (int k = 0; k < 50; ++k) {
    Eigen::Vector3d delta = motion.delta(attitude.flexion_rad);
    if (is_left) delta.z() *= -1.0;
    const SolverFrame frame{Side::right, right_sided(convention).rotation_centre_mm, delta};
    const ClinicalCoordinates c =
        clinical_coordinates(X_solver_reference_moving(frame, X), Side::right, Eigen::Vector3d::Zero());
    const bool is_same = std::abs(c.flexion_rad - attitude.flexion_rad) <= 1e-12;
    attitude = {c.flexion_rad, c.varus_rad};
    if (is_same) break;
  }
  return attitude;
}

bool is_in(double value, double first, double last)
{
  return value >= first - same_angle_rad && value <= last + same_angle_rad;
}

}  // namespace

Sequence sequence_of(const std::string& file, const std::string& key_name, const std::vector<double>& key,
                     const std::vector<Pose>& X_reference_moving, const Convention& convention)
{
  check(key.size() == X_reference_moving.size(), "each pose of a motion has a key");
  Sequence sequence{file, key_name, key, {}};
  for (const Pose& X : X_reference_moving) sequence.rows.push_back(row_of(X, all_determined, convention));
  return sequence;
}

bool is_sequence(const store::MotionModel& model, const std::string& set)
{
  return model.varus_deg.size() == 1 || store::Motion(model, set).is_varus_free();
}

Sequence sequence_of(const std::string& file, const store::MotionModel& model, const std::string& set,
                     const Convention& convention)
{
  Sequence sequence{file, "flexion_deg", model.flexion_deg, {}};
  if (model.frames) {
    sequence.key_name = model.frames->key_name;
    sequence.key = model.frames->key;
  }
  const bool has_cells = !is_sequence(model, set);
  if (has_cells) {
    sequence.key_name = "cell";
    sequence.key.clear();
    for (Eigen::Index c = 0; c < model.status.size(); ++c) sequence.key.push_back(static_cast<double>(c));
  }
  std::optional<store::Motion> motion;
  if (set != "raw") motion.emplace(model, set);
  for (Eigen::Index i = 0; i < model.status.rows(); ++i) {
    for (Eigen::Index j = 0; j < (has_cells ? model.status.cols() : 1); ++j) {
      const Attitude attitude{rad_from_deg(model.flexion_deg[static_cast<std::size_t>(i)]),
                              rad_from_deg(model.varus_deg[static_cast<std::size_t>(j)])};
      sequence.rows.push_back(motion ? row_at(*motion, attitude, determined_in(model, i, j), convention)
                                     : raw_row(model, i, j, convention));
    }
  }
  return sequence;
}

std::vector<Row> rows_by_key(const Sequence& found, const Sequence& measured)
{
  std::vector<Row> rows;
  for (std::size_t k = 0; k < measured.key.size(); ++k) {
    const auto same = std::find_if(found.key.begin(), found.key.end(),
                                   [&](double key) { return is_same_key(key, measured.key[k]); });
    rows.push_back(same == found.key.end() ? missing_row(no_such_key, measured.rows[k].value[at_flexion])
                                           : found.rows[static_cast<std::size_t>(same - found.key.begin())]);
  }
  return rows;
}

std::vector<Row> rows_over_flexion(const Sequence& found, const Sequence& measured, bool bridges)
{
  const OverFlexion over(found, bridges);
  std::vector<Row> rows;
  for (const Row& row : measured.rows)
    rows.push_back(row.missing.empty() ? over.at(row.value[at_flexion]) : row);
  return rows;
}

std::vector<Row> rows_at_attitudes(const store::MotionModel& model, const std::string& set,
                                   const Sequence& measured, const Convention& convention)
{
  const store::Motion motion(model, set);
  std::vector<Row> rows;
  for (const Row& row : measured.rows) {
    if (!row.missing.empty()) {
      rows.push_back(row);
      continue;
    }
    const Attitude wanted = attitude_of(row, convention, motion);
    const bool is_covered =
        is_in(wanted.flexion_rad, motion.first_flexion_rad(), motion.last_flexion_rad()) &&
        is_in(wanted.varus_rad, motion.first_varus_rad(), motion.last_varus_rad());
    rows.push_back(is_covered ? row_at(motion, wanted, determined_around(model, wanted), convention)
                              : missing_row(outside_range, wanted.flexion_rad));
  }
  return rows;
}

}  // namespace vrda::analysis
