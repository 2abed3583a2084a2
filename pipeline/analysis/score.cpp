#include "analysis/score.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <limits>
#include <utility>

#include "analysis/sequence_program.hpp"
#include "core/text.hpp"
#include "model/linear_algebra.hpp"
#include "model/step_record.hpp"
#include "store/motion.hpp"

namespace vrda::analysis {
namespace {

const Eigen::Vector3d reflection(1.0, 1.0, -1.0);

/// From canonical axes to those of the coordinates, of a right joint.
Eigen::Matrix3d R_axes_canonical(const Convention& right)
{
  if (!right.long_axis) return Eigen::Matrix3d::Identity();
  return shortest_rotation(*right.long_axis, Eigen::Vector3d::UnitY());
}

/// The point whose displacement the translations are.
Eigen::Vector3d tracked_point_mm(const Convention& right)
{
  return right.translations == Translations::mesh_origin ? Eigen::Vector3d::Zero() : right.rotation_centre_mm;
}

}  // namespace

Pose reflected(const Pose& X)
{
  Pose result = Pose::Identity();
  result.linear() = reflection.asDiagonal() * X.linear() * reflection.asDiagonal();
  result.translation() = reflection.asDiagonal() * X.translation();
  return result;
}

Convention right_sided(Convention convention)
{
  if (convention.side == Side::right) return convention;
  convention.side = Side::right;
  convention.rotation_centre_mm.z() *= -1.0;
  if (convention.long_axis) convention.long_axis->z() *= -1.0;
  return convention;
}

Coordinates coordinates_of(const Pose& X_reference_moving, const Convention& convention)
{
  const Convention right = right_sided(convention);
  const Pose X = convention.side == Side::left ? reflected(X_reference_moving) : X_reference_moving;
  const Eigen::Vector3d p_mm = tracked_point_mm(right);
  // In axes whose origin is the point: its displacement is the translation.
  const Eigen::Matrix3d R = R_axes_canonical(right);
  Pose turned = Pose::Identity();
  turned.linear() = R * X.linear() * R.transpose();
  turned.translation() = R * (X * p_mm - p_mm);
  const ClinicalCoordinates c = clinical_coordinates(turned, Side::right, Eigen::Vector3d::Zero());
  Coordinates value{c.flexion_rad, c.varus_rad,   c.internal_rotation_rad,
                    c.anterior_mm, c.proximal_mm, c.lateral_mm};
  if (right.translations == Translations::mesh_origin) Eigen::Vector3d::Map(&value[3]) = turned.translation();
  return value;
}

Pose right_sided_pose(const Coordinates& value, const Convention& convention)
{
  const auto [flexion_rad, varus_rad, internal_rad, anterior_mm, proximal_mm, lateral_mm] = value;
  const Convention right = right_sided(convention);
  Pose turned = Pose::Identity();
  turned.linear() = rotation_z(-flexion_rad) * rotation_x(varus_rad) * rotation_y(internal_rad);
  turned.translation() << anterior_mm, proximal_mm, lateral_mm;
  if (right.translations == Translations::rotation_centre) {
    // The displacement from its components along axes that are not orthogonal: e1 . e3 = sin(varus);
    // schemas/clinical.md, remarks.
    const Eigen::Vector3d e1 = Eigen::Vector3d::UnitZ(), e3 = turned.linear().col(1);
    const Eigen::Vector3d e2 = e3.cross(e1).normalized();
    const double s = sine(varus_rad), cos_sq = (1.0 - s) * (1.0 + s);
    turned.translation() = anterior_mm * e2 + ((lateral_mm - proximal_mm * s) / cos_sq) * e1 +
                           ((proximal_mm - lateral_mm * s) / cos_sq) * e3;
  }
  const Eigen::Matrix3d R = R_axes_canonical(right);
  const Eigen::Vector3d p_mm = tracked_point_mm(right);
  Pose X = Pose::Identity();
  X.linear() = R.transpose() * turned.linear() * R;
  X.translation() = p_mm + R.transpose() * turned.translation() - X.linear() * p_mm;
  return X;
}

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

Sequence follower_sequence(const std::string& file, const store::MotionModel& model, const std::string& set,
                           const std::string& follower, const std::vector<double>& flexion_deg)
{
  std::vector<std::string> names;
  const store::FollowerRows* rows = nullptr;
  for (const store::FollowerRows& one : model.followers) {
    names.push_back(one.name);
    if (one.name == follower) rows = &one;
  }
  if (rows == nullptr)
    throw InputError({file, "--follower", "\"" + follower + "\"",
                      names.empty() ? "a motion model with bodies that follow the joint"
                                    : "a body that follows the joint: " + join_alternatives(names)});
  const store::Motion motion(model, set);
  Sequence sequence{file, "flexion_deg", flexion_deg.empty() ? model.flexion_deg : flexion_deg, {}};
  if (model.frames) {
    sequence.key_name = model.frames->key_name;
    sequence.key = model.frames->key;
  }
  for (const double key : sequence.key) {
    const store::JointPose pose =
        model.frames ? motion.at_frame(key)
                     : motion.at({rad_from_deg(key), motion.balanced_varus_rad(rad_from_deg(key))});
    Row& row = sequence.rows.emplace_back();
    if (pose.is_flexion_clamped) {
      row.missing = outside_range;
    } else if (const std::optional<Pose> X_of = pose.X_of(*rows)) {
      const JointCoordinates q = follower_coordinates(*X_of, side_named(model.side), rows->centre_mm);
      std::copy(q.begin(), q.end(), row.value.begin());
    } else {
      row.missing = unsolved_cell;
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

namespace {

double mean_of(const std::vector<double>& values)
{
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

/// Sum of the products of both quantities' deviations from their means.
double joint_deviation(const std::vector<double>& a, const std::vector<double>& b)
{
  const double mean_a = mean_of(a), mean_b = mean_of(b);
  double sum = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) sum += (a[k] - mean_a) * (b[k] - mean_b);
  return sum;
}

/// Whether the deviations from the mean are more than its rounding.
bool varies(const std::vector<double>& values)
{
  double largest = 0.0;
  for (const double value : values) largest = std::max(largest, std::abs(value));
  const double rounding = 1e-14 * largest;
  return joint_deviation(values, values) > static_cast<double>(values.size()) * rounding * rounding;
}

double rms_about(const std::vector<double>& values, double centre)
{
  double sum = 0.0;
  for (const double value : values) sum += (value - centre) * (value - centre);
  return std::sqrt(sum / static_cast<double>(values.size()));
}

}  // namespace

Statistics statistics(const std::vector<double>& found, const std::vector<double>& measured)
{
  check(found.size() == measured.size(), "a found value belongs to each measured one");
  Statistics result;
  result.n = found.size();
  if (found.empty()) return result;
  std::vector<double> differences;
  for (std::size_t k = 0; k < found.size(); ++k) differences.push_back(found[k] - measured[k]);
  result.rms = rms_about(differences, 0.0);
  result.bias = mean_of(differences);
  result.shape = rms_about(differences, result.bias);
  result.largest = 0.0;
  for (std::size_t k = 0; k < differences.size(); ++k) {
    if (std::abs(differences[k]) <= result.largest) continue;
    result.largest = std::abs(differences[k]);
    result.largest_at = k;
  }
  if (varies(found) && varies(measured)) {
    result.correlation = joint_deviation(found, measured) /
                         std::sqrt(joint_deviation(found, found) * joint_deviation(measured, measured));
  }
  return result;
}

Line constant(const std::vector<double>& values)
{
  check(!values.empty(), "a mean has values");
  return {0.0, mean_of(values), 0.0};
}

Line straight_line(const std::vector<double>& x, const std::vector<double>& values)
{
  check(x.size() == values.size(), "a line has a value for each x");
  if (x.empty() || !varies(x)) return constant(values);
  return {mean_of(x), mean_of(values), joint_deviation(x, values) / joint_deviation(x, x)};
}

double rms_of(const Line& line, const std::vector<double>& x, const std::vector<double>& values)
{
  check(x.size() == values.size(), "a line has a value for each x");
  if (values.empty()) return nan;
  std::vector<double> differences;
  for (std::size_t k = 0; k < values.size(); ++k) differences.push_back(line.at(x[k]) - values[k]);
  return rms_about(differences, 0.0);
}

namespace {

using Cloud = Eigen::Matrix<double, 3, 6>;
using Normal = Eigen::Matrix<double, 12, 12>;
using Step = Eigen::Matrix<double, 12, 1>;  ///< turn (times the radius) and shift of each frame, mm

constexpr int n_alternations = 30;
constexpr int most_alignment_steps = 100;
// Of points of some 100 mm with rounding of 1e-14 mm each.
constexpr double converged_step_mm = 1e-10;
// Directions in which a unit step moves the points by less than this, of the largest, count as undetermined.
constexpr double undetermined_sq = 1e-12;
// Frames that differ by a large rotation leave far more than the noise from the start at the identity.
constexpr double clearly_better = 2.0;
constexpr double same_mm = 1e-6;  ///< of distances that are rounding

struct Problem {
  const std::vector<Pose>& found;
  const std::vector<Pose>& measured;
  Eigen::Vector3d centre_mm;
  Cloud points_mm;
  double noise_mm = 0.0;  ///< distance that no transform removes; 0: unknown
};

Cloud around(const Eigen::Vector3d& centre_mm)
{
  Cloud points;
  const Eigen::Matrix3d axes = alignment_radius_mm * Eigen::Matrix3d::Identity();
  points << axes, -axes;
  return points.colwise() + centre_mm;
}

double rms_mm(const Problem& problem, const RigidAlignment& at)
{
  double sum = 0.0;
  for (std::size_t k = 0; k < problem.found.size(); ++k) {
    const Pose image = at.X_reference * problem.found[k] * at.X_moving;
    const Cloud left = (image * problem.points_mm) - (problem.measured[k] * problem.points_mm);
    sum += left.squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(6 * problem.found.size()));
}

void fit_moving(const Problem& problem, RigidAlignment& at)
{
  const auto n = static_cast<Eigen::Index>(problem.found.size());
  Eigen::Matrix3Xd to(3, 6 * n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const auto frame = static_cast<std::size_t>(k);
    const Pose image = (at.X_reference * problem.found[frame]).inverse() * problem.measured[frame];
    to.middleCols<6>(6 * k) = image * problem.points_mm;
  }
  at.X_moving = nearest_transform(problem.points_mm.replicate(1, n), to);
}

void fit_reference(const Problem& problem, RigidAlignment& at)
{
  const auto n = static_cast<Eigen::Index>(problem.found.size());
  Eigen::Matrix3Xd from(3, 6 * n), to(3, 6 * n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const auto frame = static_cast<std::size_t>(k);
    from.middleCols<6>(6 * k) = (problem.found[frame] * at.X_moving) * problem.points_mm;
    to.middleCols<6>(6 * k) = problem.measured[frame] * problem.points_mm;
  }
  at.X_reference = nearest_transform(from, to);
}

/// A small motion that turns about the centre; no sine is needed, as only its first order matters.
Pose moved_by(const Eigen::Ref<const Eigen::Matrix<double, 6, 1>>& step, const Eigen::Vector3d& centre_mm)
{
  const Eigen::Vector3d half_turn = 0.5 * step.head<3>() / alignment_radius_mm;
  const Eigen::Quaterniond turn =
      Eigen::Quaterniond(1.0, half_turn.x(), half_turn.y(), half_turn.z()).normalized();
  Pose X = Pose::Identity();
  X.linear() = turn.toRotationMatrix();
  X.translation() = centre_mm - X.linear() * centre_mm + step.tail<3>();
  return X;
}

/// The Gauss-Newton step of least norm.
Step newton_step(const Problem& problem, RigidAlignment& at)
{
  Normal H = Normal::Zero();
  Step g = Step::Zero();
  for (std::size_t k = 0; k < problem.found.size(); ++k) {
    const Pose image = at.X_reference * problem.found[k] * at.X_moving;
    for (Eigen::Index p = 0; p < problem.points_mm.cols(); ++p) {
      const Eigen::Vector3d point = problem.points_mm.col(p), q = image * point;
      Eigen::Matrix<double, 3, 12> J;
      J << -cross_matrix(q - problem.centre_mm) / alignment_radius_mm, Eigen::Matrix3d::Identity(),
          -image.linear() * cross_matrix(point - problem.centre_mm) / alignment_radius_mm, image.linear();
      H += J.transpose() * J;
      g += J.transpose() * (problem.measured[k] * point - q);
    }
  }
  const EigenSystem12 modes = eigen_system(H);
  // A short motion gives no information along a direction in which a radian, or the radius, changes less than
  // the noise: the transforms are not changed along it.
  const double relative_noise = problem.noise_mm / alignment_radius_mm;
  const double n_points = 6.0 * static_cast<double>(problem.found.size());
  const double smallest =
      std::max(undetermined_sq * modes.values.maxCoeff(), n_points * relative_noise * relative_noise);
  Step step = Step::Zero();
  at.n_determined = 0;
  for (Eigen::Index m = 0; m < 12; ++m) {
    if (modes.values[m] <= smallest) continue;
    step += modes.vectors.col(m) * (modes.vectors.col(m).dot(g) / modes.values[m]);
    ++at.n_determined;
  }
  return step;
}

/// Steps until they are as small as rounding; a step that does not come nearer is halved.
void refine(const Problem& problem, RigidAlignment& at)
{
  at.rms_mm = rms_mm(problem, at);
  for (int k = 0; k < most_alignment_steps && !at.is_converged; ++k) {
    Step step = newton_step(problem, at);
    RigidAlignment next = at;
    const auto take = [&] {
      next.X_reference = moved_by(step.head<6>(), problem.centre_mm) * at.X_reference;
      next.X_moving = at.X_moving * moved_by(step.tail<6>(), problem.centre_mm);
      next.rms_mm = rms_mm(problem, next);
    };
    take();
    while (next.rms_mm > at.rms_mm && step.norm() > converged_step_mm) {
      step *= 0.5;
      take();
    }
    at.is_converged = step.norm() <= converged_step_mm;
    if (next.rms_mm <= at.rms_mm) {
      next.is_converged = at.is_converged;
      at = next;
    }
  }
}

RigidAlignment from_rotation(const Problem& problem, const Eigen::Matrix3d& R_start)
{
  RigidAlignment at;
  at.X_reference.linear() = R_start;
  at.X_reference.translation() = problem.centre_mm - R_start * problem.centre_mm;
  for (int k = 0; k < n_alternations; ++k) {
    fit_moving(problem, at);
    fit_reference(problem, at);
  }
  refine(problem, at);
  return at;
}

/// The 24 rotations of a cube, the identity first.
std::vector<Eigen::Matrix3d> cube_rotations()
{
  std::vector<Eigen::Matrix3d> rotations;
  std::array<int, 3> order{0, 1, 2};
  do {
    for (int signs = 0; signs < 8; ++signs) {
      Eigen::Matrix3d R = Eigen::Matrix3d::Zero();
      for (int row = 0; row < 3; ++row)
        R(row, order[static_cast<std::size_t>(row)]) = (signs >> row) % 2 == 0 ? 1.0 : -1.0;
      if (R.determinant() > 0.0) rotations.push_back(R);
    }
  } while (std::next_permutation(order.begin(), order.end()));
  return rotations;
}

}  // namespace

RigidAlignment rigid_alignment(const std::vector<Pose>& found, const std::vector<Pose>& measured,
                               const Eigen::Vector3d& rotation_centre_mm)
{
  check(found.size() == measured.size() && !found.empty(), "an alignment has pairs of poses");
  Problem problem{found, measured, rotation_centre_mm, around(rotation_centre_mm)};
  RigidAlignment best;
  best.rms_mm = std::numeric_limits<double>::infinity();
  for (const Eigen::Matrix3d& R_start : cube_rotations()) {
    const RigidAlignment here = from_rotation(problem, R_start);
    if (here.rms_mm < best.rms_mm - same_mm) best = here;
  }
  problem.noise_mm = best.rms_mm;
  RigidAlignment near;
  refine(problem, near);
  if (near.rms_mm <= clearly_better * best.rms_mm + same_mm) return near;
  newton_step(problem, best);  // counts the determined directions
  return best;
}

namespace {

bool have_pose(const Row& found, const Row& measured)
{
  return found.missing.empty() && measured.missing.empty();
}

/// Rows of the range in which both motions have a pose.
std::vector<std::size_t> common_rows(const std::vector<Row>& found, const Sequence& measured,
                                     const RowRange& range)
{
  std::vector<std::size_t> rows;
  for (std::size_t k = 0; k < found.size(); ++k) {
    if (range.contains(k) && have_pose(found[k], measured.rows[k])) rows.push_back(k);
  }
  return rows;
}

void require_rows(const std::vector<std::size_t>& rows, const std::vector<Row>& found,
                  const Sequence& measured, const std::string& field)
{
  if (!rows.empty()) return;
  std::map<std::string, int> reasons;
  for (std::size_t k = 0; k < found.size(); ++k)
    ++reasons[measured.rows[k].missing.empty() ? found[k].missing
                                               : "measurement " + measured.rows[k].missing];
  std::string text = "no row with a pose in both motions";
  for (const auto& [reason, n] : reasons) {
    if (!reason.empty()) text += ", " + std::to_string(n) + " " + reason;
  }
  throw InputError(
      {measured.file, field, text, "at least one of the " + std::to_string(found.size()) + " rows"});
}

/// The coordinate's series in some rows: all have a pose that determines it.
struct Series {
  std::vector<std::size_t> rows;
  std::vector<double> found, measured, x;
};

/// The row's numbers nearest to those of another; `anterior` is along the floating axis or not.
Row nearest_row(Row row, const Row& to, Translations translations)
{
  const auto numbers = [](const Row& r) {
    ClinicalCoordinates c;
    c.flexion_rad = r.value[at_flexion];
    c.varus_rad = r.value[at_varus];
    c.internal_rotation_rad = r.value[at_internal];
    c.anterior_mm = r.value[n_angles];
    return c;
  };
  const ClinicalCoordinates c = nearest_numbers(numbers(row), numbers(to));
  row.value[at_flexion] = c.flexion_rad;
  row.value[at_varus] = c.varus_rad;
  row.value[at_internal] = c.internal_rotation_rad;
  if (translations == Translations::rotation_centre) row.value[n_angles] = c.anterior_mm;
  return row;
}

/// Both motions as curves: the measured one is continuous over its rows with a pose, so that a baseline has
/// no jumps, and each found row is nearest to the measured one.
void make_continuous(std::vector<Row>& found, std::vector<Row>& measured, Translations translations)
{
  const Row* before = nullptr;
  for (std::size_t k = 0; k < measured.size(); ++k) {
    if (!measured[k].missing.empty()) continue;
    if (before) measured[k] = nearest_row(measured[k], *before, translations);
    before = &measured[k];
    if (found[k].missing.empty()) found[k] = nearest_row(found[k], measured[k], translations);
  }
}

Series series_of(const std::vector<Row>& found, const Sequence& measured, std::size_t c,
                 const std::vector<std::size_t>& rows, LineOver over)
{
  Series series;
  for (const std::size_t k : rows) {
    if (!found[k].is_determined[c] || !measured.rows[k].is_determined[c]) continue;
    series.rows.push_back(k);
    series.measured.push_back(measured.rows[k].value[c]);
    series.found.push_back(found[k].value[c]);
    series.x.push_back(over == LineOver::flexion ? measured.rows[k].value[at_flexion] : measured.key[k]);
  }
  return series;
}

CoordinateScore coordinate_score(const Series& fit, Series scored, Alignment align)
{
  CoordinateScore result;
  if (fit.rows.empty() || scored.rows.empty()) return result;
  if (align == Alignment::constant) result.offset = statistics(fit.found, fit.measured).bias;
  for (double& value : scored.found) value -= result.offset;
  result.statistics = statistics(scored.found, scored.measured);
  result.largest_row = scored.rows[result.statistics.largest_at];
  result.constant_rms = rms_of(constant(fit.measured), scored.x, scored.measured);
  result.line_rms = rms_of(straight_line(fit.x, fit.measured), scored.x, scored.measured);
  return result;
}

std::vector<Pose> poses_of(const std::vector<Row>& rows, const std::vector<std::size_t>& chosen,
                           const Convention& convention)
{
  std::vector<Pose> poses;
  for (const std::size_t k : chosen) poses.push_back(right_sided_pose(rows[k].value, convention));
  return poses;
}

/// Fits both transforms in the rows `fit` and applies them to all. The fit is that of the joint reflected to
/// a right one, so that mirrored joints have equal scores.
RigidAlignment align_rigidly(std::vector<Row>& found, const Sequence& measured,
                             const std::vector<std::size_t>& fit, const Convention& convention)
{
  const Convention right = right_sided(convention);
  const RigidAlignment aligned = rigid_alignment(
      poses_of(found, fit, convention), poses_of(measured.rows, fit, convention), right.rotation_centre_mm);
  for (Row& row : found) {
    if (!row.missing.empty()) continue;
    const Pose X = right_sided_pose(row.value, convention);
    row.value = coordinates_of(aligned.X_reference * X * aligned.X_moving, right);
  }
  if (convention.side == Side::right) return aligned;
  RigidAlignment own = aligned;
  own.X_reference = reflected(aligned.X_reference);
  own.X_moving = reflected(aligned.X_moving);
  return own;
}

}  // namespace

Score score(const std::vector<Row>& found, const Sequence& measured, const ScoreOptions& options)
{
  check(found.size() == measured.rows.size() && measured.key.size() == found.size(),
        "each measured row has a found one");
  const std::vector<std::size_t> scored = common_rows(found, measured, options.scored);
  require_rows(scored, found, measured, "rows to score");
  const std::vector<std::size_t> fit = options.fit ? common_rows(found, measured, *options.fit) : scored;
  require_rows(fit, found, measured, "rows to fit");

  Score result;
  result.n_scored_rows = scored.size();
  result.n_fit_rows = fit.size();
  std::vector<Row> aligned = found;
  if (options.align == Alignment::rigid)
    result.rigid = align_rigidly(aligned, measured, fit, options.convention);
  Sequence curve = measured;
  make_continuous(aligned, curve.rows, options.convention.translations);
  for (std::size_t c = 0; c < n_scored; ++c) {
    const Series of_fit = series_of(aligned, curve, c, fit, options.line_over);
    const Series of_scored = series_of(aligned, curve, c, scored, options.line_over);
    result.coordinates[c] = coordinate_score(of_fit, of_scored, options.align);
    std::set_difference(scored.begin(), scored.end(), of_scored.rows.begin(), of_scored.rows.end(),
                        std::back_inserter(result.coordinates[c].undetermined));
  }
  for (std::size_t k = 0; k < found.size(); ++k) {
    if (!options.scored.contains(k) || have_pose(found[k], measured.rows[k])) continue;
    const bool is_measured = measured.rows[k].missing.empty();
    result.missing[is_measured ? found[k].missing : "measurement_" + measured.rows[k].missing].push_back(k);
  }
  return result;
}

}  // namespace vrda::analysis
