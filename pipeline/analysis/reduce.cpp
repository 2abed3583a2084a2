#include "analysis/reduce.hpp"

#include <boost/math/tools/toms748_solve.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "analysis/audit.hpp"
#include "analysis/smooth.hpp"
#include "core/axis.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "model/coordinates.hpp"
#include "model/frames.hpp"

namespace vrda::analysis {
namespace {

// A mean of two columns this close to a third column is that column: rounding of degrees.
constexpr double same_varus_deg = 1e-9;

/// One flexion of the grid.
struct Row {
  const store::MotionModel& model;
  Eigen::Index flexion;
  double spine_varus_deg;

  Eigen::Index n_columns() const { return model.status.cols(); }
  double varus_deg(Eigen::Index j) const { return model.varus_deg[static_cast<std::size_t>(j)]; }
  bool is_solved(Eigen::Index j) const { return model.status(flexion, j) == status_stable; }
  bool has_both_contacts(Eigen::Index j) const
  {
    return model.is_in_contact[0](flexion, j) == 1 && model.is_in_contact[1](flexion, j) == 1;
  }
  /// NaN if a compartment has no facing surface.
  double imbalance_mm(Eigen::Index j) const
  {
    return model.gap_mm[0](flexion, j) - model.gap_mm[1](flexion, j);
  }
};

struct Run {
  Eigen::Index first, last;
};

/// Runs of columns with both contacts, separated by solved columns without.
std::vector<Run> touching_runs(const Row& row)
{
  std::vector<Run> runs;
  bool is_open = false;
  for (Eigen::Index j = 0; j < row.n_columns(); ++j) {
    if (!row.is_solved(j)) continue;
    const bool has_both = row.has_both_contacts(j);
    if (has_both && is_open) runs.back().last = j;
    if (has_both && !is_open) runs.push_back({j, j});
    is_open = has_both;
  }
  return runs;
}

double distance_deg(const Row& row, const Run& run)
{
  return std::max(
      {row.varus_deg(run.first) - row.spine_varus_deg, 0.0, row.spine_varus_deg - row.varus_deg(run.last)});
}

/// Finds the columns around `varus_deg`, which must be between solved columns.
VarusChoice between_columns(const Row& row, store::ZeroVarusSource source, double varus_deg)
{
  VarusChoice choice;
  choice.source = source;
  choice.varus_deg = varus_deg;
  for (Eigen::Index j = row.n_columns(); j-- > 0;) {
    if (row.is_solved(j) && row.varus_deg(j) >= varus_deg - same_varus_deg) choice.after = j;
  }
  for (Eigen::Index j = 0; j < row.n_columns(); ++j) {
    if (row.is_solved(j) && row.varus_deg(j) <= varus_deg + same_varus_deg) choice.before = j;
  }
  const double before_deg = row.varus_deg(choice.before), after_deg = row.varus_deg(choice.after);
  if (choice.before != choice.after)
    choice.weight_after = (varus_deg - before_deg) / (after_deg - before_deg);
  return choice;
}

VarusChoice mean_of(const Row& row, const std::vector<Run>& runs)
{
  const Run run = *std::min_element(runs.begin(), runs.end(), [&](const Run& a, const Run& b) {
    return distance_deg(row, a) < distance_deg(row, b);
  });
  const double first_deg = row.varus_deg(run.first), last_deg = row.varus_deg(run.last);
  VarusChoice choice = between_columns(row, store::ZeroVarusSource::both_touch, 0.5 * (first_deg + last_deg));
  choice.first_deg = first_deg;
  choice.last_deg = last_deg;
  choice.is_cut_off = row.n_columns() > 1 && (run.first == 0 || run.last == row.n_columns() - 1);
  return choice;
}

/// Varus of every sign change of the imbalance, ascending.
std::vector<double> balanced_deg(const Row& row)
{
  std::vector<double> roots_deg;
  std::optional<Eigen::Index> before;
  for (Eigen::Index j = 0; j < row.n_columns(); ++j) {
    if (!row.is_solved(j) || std::isnan(row.imbalance_mm(j))) continue;
    const double here_mm = row.imbalance_mm(j);
    if (here_mm == 0.0) roots_deg.push_back(row.varus_deg(j));
    const double before_mm = before ? row.imbalance_mm(*before) : here_mm;
    if (before_mm * here_mm < 0.0) {
      const double width_deg = row.varus_deg(j) - row.varus_deg(*before);
      roots_deg.push_back(row.varus_deg(*before) + width_deg * (before_mm / (before_mm - here_mm)));
    }
    before = j;
  }
  return roots_deg;
}

VarusChoice given_varus_choice(const Row& row)
{
  const std::vector<Run> runs = touching_runs(row);
  if (!runs.empty()) return mean_of(row, runs);
  const std::vector<double> roots_deg = balanced_deg(row);
  if (roots_deg.empty()) return {};
  const double nearest_deg = *std::min_element(roots_deg.begin(), roots_deg.end(), [&](double a, double b) {
    return std::abs(a - row.spine_varus_deg) < std::abs(b - row.spine_varus_deg);
  });
  return between_columns(row, store::ZeroVarusSource::interpolated, nearest_deg);
}

VarusChoice free_varus_choice(const Row& row)
{
  VarusChoice choice;
  if (!row.is_solved(0)) return choice;
  choice.source = store::ZeroVarusSource::free;
  choice.varus_deg = row.model.varus_solved_deg(row.flexion, 0);
  return choice;
}

}  // namespace

std::vector<VarusChoice> varus_choices(const store::MotionModel& model, const store::Motion& raw)
{
  std::vector<VarusChoice> choices;
  for (Eigen::Index i = 0; i < model.status.rows(); ++i) {
    const double flexion_rad = rad_from_deg(model.flexion_deg[static_cast<std::size_t>(i)]);
    const Row row{model, i, deg_from_rad(raw.balanced_varus_rad(flexion_rad))};
    choices.push_back(raw.is_varus_free() ? free_varus_choice(row) : given_varus_choice(row));
  }
  return choices;
}

namespace {

double forward_mm(const Eigen::Vector3d& travel_mm)
{
  const double length_mm = std::sqrt(travel_mm.x() * travel_mm.x() + travel_mm.y() * travel_mm.y());
  return travel_mm.x() < 0.0 ? -length_mm : length_mm;
}

double shared_mm(double a_mm, double b_mm)
{
  if (a_mm * b_mm <= 0.0) return 0.0;
  return a_mm > 0.0 ? std::min(a_mm, b_mm) : std::max(a_mm, b_mm);
}

}  // namespace

Rolling rolling_between(const CompartmentContact& start, const CompartmentContact& end)
{
  const Eigen::Matrix3d R_reference_moving =
      midpoint_orientation(start.X_reference_moving, end.X_reference_moving);
  Rolling rolling;
  rolling.reference_mm =
      forward_mm(R_reference_moving.transpose() * (end.p_reference_mm - start.p_reference_mm));
  rolling.moving_mm = forward_mm(end.p_moving_mm - start.p_moving_mm);
  rolling.rolling_mm = shared_mm(rolling.reference_mm, rolling.moving_mm);
  rolling.sliding_mm = rolling.moving_mm - rolling.reference_mm;
  return rolling;
}

namespace {

using Matrix4 = Eigen::Matrix<double, 4, 4, Eigen::RowMajor>;

/// The pose of one flexion and its surface values.
struct ReducedPose {
  Pose X_reference_moving = Pose::Identity();
  Eigen::Vector3d t_mm = Eigen::Vector3d::Zero();  ///< tx, ty, tz
  double theta_deg = 0.0;
  double varus_deg = 0.0;
};

ReducedPose cell_pose(const store::MotionModel& model, Eigen::Index i, Eigen::Index j)
{
  ReducedPose pose;
  pose.t_mm = {model.tx_mm(i, j), model.ty_mm(i, j), model.tz_mm(i, j)};
  pose.theta_deg = model.theta_deg(i, j);
  const auto cell = static_cast<std::size_t>(i * model.status.cols() + j);
  pose.X_reference_moving = store::pose_in(model.X_reference_moving, cell);
  return pose;
}

ReducedPose raw_pose(const store::MotionModel& model, const store::Motion& raw, Eigen::Index i,
                     const VarusChoice& choice)
{
  ReducedPose pose = cell_pose(model, i, choice.before);
  pose.varus_deg = choice.varus_deg;
  if (choice.before == choice.after) return pose;
  const ReducedPose after = cell_pose(model, i, choice.after);
  pose.t_mm += choice.weight_after * (after.t_mm - pose.t_mm);
  pose.theta_deg += choice.weight_after * (after.theta_deg - pose.theta_deg);
  const Attitude attitude{rad_from_deg(model.flexion_deg[static_cast<std::size_t>(i)]),
                          rad_from_deg(choice.varus_deg)};
  const store::PoseCoordinates numbers{pose.t_mm.x(), pose.t_mm.y(), pose.t_mm.z(),
                                       rad_from_deg(pose.theta_deg)};
  pose.X_reference_moving = raw.joint_pose(attitude, numbers).X_reference_moving;
  return pose;
}

/// Empty if the set has no pose.
std::optional<ReducedPose> set_pose(const store::MotionModel& model, const store::Motion& motion,
                                    Eigen::Index i, const VarusChoice& choice)
{
  const Attitude wanted{rad_from_deg(model.flexion_deg[static_cast<std::size_t>(i)]),
                        rad_from_deg(choice.varus_deg)};
  const store::JointPose joint = motion.at(wanted);
  if (joint.status != store::PoseStatus::solved) return {};
  ReducedPose pose;
  pose.X_reference_moving = joint.X_reference_moving;
  pose.t_mm = joint.X_world_moving * model.rotation_centre_mm;
  pose.theta_deg = deg_from_rad(joint.theta_rad);
  // A set may have its own varus: the two-sided motion, or a smoothed set where varus was free.
  pose.varus_deg = joint.attitude.varus_rad == wanted.varus_rad ? choice.varus_deg
                                                                : deg_from_rad(joint.attitude.varus_rad);
  return pose;
}

store::ZeroVarus empty_table(const store::MotionModel& model)
{
  const std::size_t n = model.flexion_deg.size(), n_steps = n - 1;
  store::ZeroVarus z;
  z.source.assign(n, static_cast<std::int8_t>(store::ZeroVarusSource::none));
  z.is_cut_off.assign(n, 0);
  z.resize(n);
  for (auto* of_flexion : {&z.varus_first_deg, &z.varus_last_deg}) of_flexion->assign(n, nan);
  z.clinical.fill(std::vector<double>(n, nan));
  z.X_reference_moving.assign(16 * n, nan);
  for (auto* of_step : {&z.helical_rotation_deg, &z.helical_translation_mm}) of_step->assign(n_steps, nan);
  for (auto* of_step : {&z.helical_direction, &z.helical_point_mm}) of_step->assign(3 * n_steps, nan);
  z.instant_centre_mm.assign(2 * n_steps, nan);
  if (!model.has_compartments) return z;
  const std::vector<double> no_points(3 * n, nan), no_steps(n_steps, nan);
  z.centres.fill({no_points, no_points});
  z.rolling.fill({no_steps, no_steps});
  return z;
}

void put_pose(store::ZeroVarus& z, const store::MotionModel& model, std::size_t i, const ReducedPose& pose)
{
  z.PoseRows::set(i, pose.t_mm, pose.theta_deg, pose.varus_deg);
  Eigen::Map<Matrix4>(&z.X_reference_moving[16 * i]) = pose.X_reference_moving.matrix();
  const auto clinical = in_files(
      clinical_coordinates(pose.X_reference_moving, side_named(model.side), model.rotation_centre_mm));
  for (std::size_t k = 0; k < clinical.size(); ++k) z.clinical[k][i] = clinical[k];
}

Eigen::Vector3d row3(const std::vector<double>& rows, std::size_t row)
{
  return Eigen::Map<const Eigen::Vector3d>(&rows[3 * row]);
}

void put_row3(std::vector<double>& rows, std::size_t row, const Eigen::Vector3d& values)
{
  Eigen::Map<Eigen::Vector3d>{&rows[3 * row]} = values;
}

/// Linear between the adjacent columns; if one has no contact, the point of the other.
Eigen::Vector3d point_between(const std::vector<double>& path_mm, std::size_t first_cell,
                              const VarusChoice& choice)
{
  const Eigen::Vector3d before = row3(path_mm, first_cell + static_cast<std::size_t>(choice.before));
  const Eigen::Vector3d after = row3(path_mm, first_cell + static_cast<std::size_t>(choice.after));
  if (std::isnan(after.x())) return before;
  if (std::isnan(before.x())) return after;
  return before + choice.weight_after * (after - before);
}

void put_contacts(store::ZeroVarus& z, const store::MotionModel& model, std::size_t i,
                  const VarusChoice& choice)
{
  if (!model.contact_paths) return;
  const std::size_t first_cell = i * model.varus_deg.size();
  for (const Compartment side : all_compartments) {
    const store::ContactPath& path = (*model.contact_paths)[side];
    put_row3(z.centres[side].reference_mm, i, point_between(path.reference_mm, first_cell, choice));
    put_row3(z.centres[side].moving_mm, i, point_between(path.moving_mm, first_cell, choice));
  }
}

void put_axes(store::ZeroVarus& z, std::size_t k, const Eigen::Vector3d& centre_mm)
{
  const Pose start = store::pose_in(z.X_reference_moving, k),
             end = store::pose_in(z.X_reference_moving, k + 1);
  if (const std::optional<HelicalAxis> axis = helical_axis(start, end, centre_mm)) {
    z.helical_rotation_deg[k] = deg_from_rad(axis->rotation_rad);
    z.helical_translation_mm[k] = axis->translation_mm;
    put_row3(z.helical_direction, k, axis->direction);
    put_row3(z.helical_point_mm, k, axis->point_mm);
  }
  if (const std::optional<Eigen::Vector2d> centre = instant_centre_mm(start, end, centre_mm))
    Eigen::Map<Eigen::Vector2d>(&z.instant_centre_mm[2 * k]) = *centre;
}

/// Empty unless the compartment is in contact at both ends.
std::optional<Rolling> rolling_of(const store::ZeroVarus& z, std::size_t k, const store::ContactPath& path)
{
  const auto at = [&](std::size_t row) {
    return CompartmentContact{store::pose_in(z.X_reference_moving, row), row3(path.reference_mm, row),
                              row3(path.moving_mm, row)};
  };
  const CompartmentContact start = at(k), end = at(k + 1);
  if (std::isnan(start.p_reference_mm.x()) || std::isnan(end.p_reference_mm.x())) return {};
  return rolling_between(start, end);
}

void put_rolling(store::ZeroVarus& z, std::size_t k)
{
  for (const Compartment side : all_compartments) {
    const std::optional<Rolling> found = rolling_of(z, k, z.centres[side]);
    if (!found) continue;
    z.rolling[side].rolling_mm[k] = found->rolling_mm;
    z.rolling[side].sliding_mm[k] = found->sliding_mm;
  }
}

bool has_pose(const store::ZeroVarus& z, std::size_t i)
{
  return z.source[i] != static_cast<std::int8_t>(store::ZeroVarusSource::none);
}

}  // namespace

bool is_reducible(const store::MotionModel& model)
{
  return !model.frames && (model.has_compartments || store::Motion(model, "raw").is_varus_free());
}

store::ZeroVarus reduce(const store::MotionModel& model, const std::string& set)
{
  check(is_reducible(model), "a joint without compartments and with given varus has no zero varus");
  const store::Motion raw(model, "raw"), motion(model, set);
  const std::vector<VarusChoice> choices = varus_choices(model, raw);
  store::ZeroVarus z = empty_table(model);
  z.set = set;
  for (std::size_t i = 0; i < choices.size(); ++i) {
    const VarusChoice& choice = choices[i];
    if (choice.source == store::ZeroVarusSource::none) continue;
    const auto row = static_cast<Eigen::Index>(i);
    const std::optional<ReducedPose> pose =
        set == "raw" ? raw_pose(model, raw, row, choice) : set_pose(model, motion, row, choice);
    if (!pose) continue;
    z.source[i] = static_cast<std::int8_t>(choice.source);
    z.varus_first_deg[i] = choice.first_deg;
    z.varus_last_deg[i] = choice.last_deg;
    z.is_cut_off[i] = choice.is_cut_off ? 1 : 0;
    if (choice.source == store::ZeroVarusSource::both_touch && pose->varus_deg != choice.varus_deg) {
      // The two-sided motion has the varus of equal gaps, not the mean of the columns in contact.
      z.source[i] = static_cast<std::int8_t>(store::ZeroVarusSource::interpolated);
      z.varus_first_deg[i] = z.varus_last_deg[i] = nan;
      z.is_cut_off[i] = 0;
    }
    put_pose(z, model, i, *pose);
    put_contacts(z, model, i, choice);
  }
  for (std::size_t k = 0; k + 1 < choices.size(); ++k) {
    if (!has_pose(z, k) || !has_pose(z, k + 1)) continue;
    put_axes(z, k, model.rotation_centre_mm);
    if (model.has_compartments) put_rolling(z, k);
  }
  return z;
}

std::string cut_off_warning(const store::ZeroVarus& zero_varus)
{
  const auto n = std::count(zero_varus.is_cut_off.begin(), zero_varus.is_cut_off.end(), 1);
  if (n == 0) return "";
  return "zero varus at " + std::to_string(n) + " of " + std::to_string(zero_varus.is_cut_off.size()) +
         " flexions: the band with both contacts reaches the border of the grid; widen "
         "grid.varus";
}

int n_reduced_flexions(const store::ZeroVarus& zero_varus)
{
  const auto none = static_cast<std::int8_t>(store::ZeroVarusSource::none);
  return static_cast<int>(
      zero_varus.source.size() -
      static_cast<std::size_t>(std::count(zero_varus.source.begin(), zero_varus.source.end(), none)));
}

namespace {

constexpr double first_bracket_rad = rad_from_deg(0.25);
constexpr double largest_bracket_rad = rad_from_deg(8.0);
// Far below what the gaps resolve: 1e-12 rad over 100 mm is 1e-10 mm.
constexpr double root_tolerance_rad = 1e-12;
constexpr std::uintmax_t max_root_evaluations = 100;
// A gap up to this is contact: well above the margin of a recontacted pose, far below what can be seen.
constexpr double contact_gap_mm = 0.01;

store::GridD column_of(const std::vector<double>& values)
{
  return Eigen::Map<const store::GridD>(values.data(), static_cast<Eigen::Index>(values.size()), 1);
}

SmoothInput course_of(const store::MotionModel& model, const store::PoseRows& poses, store::GridB status)
{
  SmoothInput input;
  input.name = model.title;
  input.flexion_deg = model.flexion_deg;
  input.varus_deg = {0.0};
  input.tx_mm = column_of(poses.tx_mm);
  input.ty_mm = column_of(poses.ty_mm);
  input.tz_mm = column_of(poses.tz_mm);
  input.theta_deg = column_of(poses.theta_deg);
  input.varus_solved_deg = column_of(poses.varus_deg);
  input.theta_determined = store::GridB::Constant(status.rows(), 1, 1);
  input.status = std::move(status);
  return input;
}

/// Raw poses over flexion, [n_flexion, 1]; varus is their own.
SmoothInput raw_course(const store::MotionModel& model)
{
  const auto n = static_cast<Eigen::Index>(model.flexion_deg.size());
  store::GridB status(n, 1);
  if (model.equilibrium) {
    const store::FreeSpine& spine = model.equilibrium->spine;
    for (Eigen::Index i = 0; i < n; ++i) status(i, 0) = spine.status[static_cast<std::size_t>(i)];
    return course_of(model, spine, std::move(status));
  }
  const store::ZeroVarus poses = reduce(model, "raw");
  for (Eigen::Index i = 0; i < n; ++i) {
    const bool has_pose =
        poses.source[static_cast<std::size_t>(i)] != store::code_of(store::ZeroVarusSource::none);
    status(i, 0) = has_pose ? status_stable : store::code_of(StepStatus::pending);
  }
  return course_of(model, poses, std::move(status));
}

/// [n_flexion] medial less lateral gap where the raw equilibrium lifts a side off, else 0.
std::vector<double> lift_off_mm(const store::MotionModel& model, const store::Motion& motion,
                                const SmoothInput& course, const Measuring& with)
{
  std::vector<double> difference_mm(course.flexion_deg.size(), 0.0);
  if (!model.equilibrium) return difference_mm;
  for_each_row(model, motion, course.flexion_deg, with, [&](std::size_t row, PoseMeter& meter) {
    const auto i = static_cast<Eigen::Index>(row);
    if (course.status(i, 0) != status_stable) return;
    const Attitude attitude{rad_from_deg(course.flexion_deg[row]),
                            rad_from_deg(course.varus_solved_deg(i, 0))};
    const store::JointPose pose = motion.joint_pose(
        attitude,
        {course.tx_mm(i, 0), course.ty_mm(i, 0), course.tz_mm(i, 0), rad_from_deg(course.theta_deg(i, 0))});
    const CompartmentGaps gaps = meter.compartment_gaps(attitude, pose.X_reference_moving);
    if (std::max(gaps[0], gaps[1]) > model.contact_resolution_mm) difference_mm[row] = gaps[0] - gaps[1];
  });
  return difference_mm;
}

/// The varus near `start_rad` at which `imbalance_mm` (of varus) is 0.
template <typename Imbalance>
std::optional<double> balanced_varus_rad(const Imbalance& imbalance_mm, double start_rad)
{
  for (double reach_rad = first_bracket_rad; reach_rad <= largest_bracket_rad; reach_rad *= 2.0) {
    const double low_rad = start_rad - reach_rad, high_rad = start_rad + reach_rad;
    const double low_mm = imbalance_mm(low_rad), high_mm = imbalance_mm(high_rad);
    if (low_mm == 0.0) return low_rad;
    if (high_mm == 0.0) return high_rad;
    if (!(low_mm * high_mm < 0.0)) continue;
    std::uintmax_t n_evaluations = max_root_evaluations;
    const auto is_close = [](double a, double b) { return std::abs(a - b) <= root_tolerance_rad; };
    const auto [a, b] = boost::math::tools::toms748_solve(imbalance_mm, low_rad, high_rad, low_mm, high_mm,
                                                          is_close, n_evaluations);
    return 0.5 * (a + b);
  }
  return std::nullopt;
}

store::TwoSided without_poses(std::vector<double> flexion_deg, int degree)
{
  const std::size_t n = flexion_deg.size();
  store::TwoSided result;
  result.degree = degree;
  result.flexion_deg = std::move(flexion_deg);
  result.contact.assign(n, store::code_of(store::TwoSidedContact::no_pose));
  result.resize(n);
  result.gap_mm.fill(std::vector<double>(n, nan));
  return result;
}

store::TwoSidedContact contact_of(const CompartmentGaps& gaps)
{
  if (std::max(gaps[0], gaps[1]) <= contact_gap_mm) return store::TwoSidedContact::both;
  return gaps[0] < gaps[1] ? store::TwoSidedContact::medial : store::TwoSidedContact::lateral;
}

int steps_per_interval(const std::vector<double>& flexion_deg, double spacing_deg)
{
  double widest_deg = spacing_deg;
  for (std::size_t i = 1; i < flexion_deg.size(); ++i)
    widest_deg = std::max(widest_deg, flexion_deg[i] - flexion_deg[i - 1]);
  return static_cast<int>(std::ceil(widest_deg / spacing_deg));
}

}  // namespace

std::optional<store::TwoSided> two_sided(const store::MotionModel& model, const TwoSidedOptions& options,
                                         const Measuring& with)
{
  if (!model.has_compartments || model.frames) return std::nullopt;
  const SmoothInput course = raw_course(model);
  const int degree = largest_degree(course, options.degree);
  if (degree < 0) return std::nullopt;
  const store::SmoothedSurfaces smooth_course =
      store::smoothed_surfaces(model, smooth(course, degree, {options.is_robust}));
  const store::Motion motion(model, "raw");
  const std::vector<double> difference_mm = lift_off_mm(model, motion, course, with);

  std::vector<std::size_t> posed;
  for (std::size_t i = 0; i < course.flexion_deg.size(); ++i)
    if (course.status(static_cast<Eigen::Index>(i), 0) == status_stable) posed.push_back(i);
  const double first_deg = course.flexion_deg[posed.front()], last_deg = course.flexion_deg[posed.back()];

  store::TwoSided result = without_poses(
      refined(model.flexion_deg, steps_per_interval(model.flexion_deg, options.spacing_deg)), degree);
  for_each_row(model, motion, result.flexion_deg, with, [&](std::size_t row, PoseMeter& meter) {
    const double flexion_deg = result.flexion_deg[row], flexion_rad = rad_from_deg(flexion_deg);
    if (flexion_deg < first_deg || flexion_deg > last_deg) return;
    const store::PoseAndVarus smooth_pose = store::evaluate(smooth_course, {flexion_rad, 0.0});
    store::PoseCoordinates numbers{smooth_pose[0], smooth_pose[1], smooth_pose[2], smooth_pose[3]};
    const auto pose_at = [&](double varus_rad) {
      return motion.joint_pose({flexion_rad, varus_rad}, numbers).X_reference_moving;
    };
    const auto gaps_at = [&](double varus_rad) {
      return meter.compartment_gaps({flexion_rad, varus_rad}, pose_at(varus_rad));
    };
    const auto [before, share] = position_on(course.flexion_deg, flexion_deg);
    double wanted_mm = difference_mm[before];
    if (share > 0.0) wanted_mm += share * (difference_mm[before + 1] - wanted_mm);
    const auto imbalance_mm = [&](double varus_rad) {
      const CompartmentGaps gaps = gaps_at(varus_rad);
      return gaps[0] - gaps[1] - wanted_mm;
    };
    const std::optional<double> varus_rad = balanced_varus_rad(imbalance_mm, smooth_pose[4]);
    if (!varus_rad) return;
    const double travel_mm = meter.travel_into_contact_mm({flexion_rad, *varus_rad}, pose_at(*varus_rad));
    if (std::isnan(travel_mm)) return;
    const Eigen::Vector3d shift_mm = travel_mm * motion.delta(flexion_rad);
    for (std::size_t axis = 0; axis < 3; ++axis) numbers[axis] += shift_mm[static_cast<Eigen::Index>(axis)];
    const CompartmentGaps gaps = gaps_at(*varus_rad);
    result.contact[row] = store::code_of(contact_of(gaps));
    result.set(row, {numbers[0], numbers[1], numbers[2]}, deg_from_rad(numbers[3]), deg_from_rad(*varus_rad));
    for (std::size_t side = 0; side < gaps.size(); ++side) result.gap_mm[side][row] = gaps[side];
  });
  if (std::ranges::all_of(result.contact,
                          [](std::int8_t c) { return c == store::code_of(store::TwoSidedContact::no_pose); }))
    return std::nullopt;
  return result;
}

}  // namespace vrda::analysis
