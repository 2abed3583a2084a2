#include "analysis/two_sided.hpp"

#include <algorithm>
#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "analysis/pose_meter.hpp"
#include "core/units.hpp"
#include "store/poses.hpp"
#include "store/surfaces.hpp"
#include "analysis/reduce.hpp"
#include "analysis/smooth.hpp"

namespace vrda::analysis {
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

/// `Poses` is FreeSpine or ZeroVarus.
template <typename Poses>
analysis::SmoothInput course_of(const store::MotionModel& model, const Poses& poses, store::GridB status)
{
  analysis::SmoothInput input;
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
analysis::SmoothInput raw_course(const store::MotionModel& model)
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
                                const analysis::SmoothInput& course, int n_threads)
{
  std::vector<double> difference_mm(course.flexion_deg.size(), 0.0);
  if (!model.equilibrium) return difference_mm;
  analysis::for_each_row(
      model, motion, course.flexion_deg, n_threads, [&](std::size_t row, analysis::PoseMeter& meter) {
        const auto i = static_cast<Eigen::Index>(row);
        if (course.status(i, 0) != status_stable) return;
        const Attitude attitude{rad_from_deg(course.flexion_deg[row]),
                                rad_from_deg(course.varus_solved_deg(i, 0))};
        const store::JointPose pose =
            motion.joint_pose(attitude, {course.tx_mm(i, 0), course.ty_mm(i, 0), course.tz_mm(i, 0),
                                         rad_from_deg(course.theta_deg(i, 0))});
        const analysis::CompartmentGaps gaps = meter.compartment_gaps(attitude, pose.X_reference_moving);
        if (std::max(gaps.medial_mm, gaps.lateral_mm) > model.contact_resolution_mm)
          difference_mm[row] = gaps.medial_mm - gaps.lateral_mm;
      });
  return difference_mm;
}

double linear_at(const std::vector<double>& axis, const std::vector<double>& values, double x)
{
  const auto after = std::lower_bound(axis.begin(), axis.end(), x);
  const auto i = static_cast<std::size_t>(after - axis.begin());
  if (i == 0 || axis[i] == x) return values[i];
  const double s = (x - axis[i - 1]) / (axis[i] - axis[i - 1]);
  return values[i - 1] + s * (values[i] - values[i - 1]);
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
  for (std::vector<double>* column : {&result.tx_mm, &result.ty_mm, &result.tz_mm, &result.theta_deg,
                                      &result.varus_deg, &result.gap_medial_mm, &result.gap_lateral_mm})
    column->assign(n, nan);
  return result;
}

store::TwoSidedContact contact_of(const analysis::CompartmentGaps& gaps)
{
  if (std::max(gaps.medial_mm, gaps.lateral_mm) <= contact_gap_mm) return store::TwoSidedContact::both;
  return gaps.medial_mm < gaps.lateral_mm ? store::TwoSidedContact::medial : store::TwoSidedContact::lateral;
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
                                         int n_threads)
{
  if (!model.has_compartments || model.frames) return std::nullopt;
  const analysis::SmoothInput course = raw_course(model);
  const int degree = analysis::largest_degree(course, options.degree);
  if (degree < 0) return std::nullopt;
  const store::SmoothedSurfaces smooth_course =
      store::smoothed_surfaces(model, analysis::smooth(course, degree, {options.is_robust}));
  const store::Motion motion(model, "raw");
  const std::vector<double> difference_mm = lift_off_mm(model, motion, course, n_threads);

  std::vector<std::size_t> posed;
  for (std::size_t i = 0; i < course.flexion_deg.size(); ++i)
    if (course.status(static_cast<Eigen::Index>(i), 0) == status_stable) posed.push_back(i);
  const double first_deg = course.flexion_deg[posed.front()], last_deg = course.flexion_deg[posed.back()];

  store::TwoSided result = without_poses(
      analysis::refined(model.flexion_deg, steps_per_interval(model.flexion_deg, options.spacing_deg)), degree);
  analysis::for_each_row(
      model, motion, result.flexion_deg, n_threads, [&](std::size_t row, analysis::PoseMeter& meter) {
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
        const double wanted_mm = linear_at(course.flexion_deg, difference_mm, flexion_deg);
        const auto imbalance_mm = [&](double varus_rad) {
          const analysis::CompartmentGaps gaps = gaps_at(varus_rad);
          return gaps.medial_mm - gaps.lateral_mm - wanted_mm;
        };
        const std::optional<double> varus_rad = balanced_varus_rad(imbalance_mm, smooth_pose[4]);
        if (!varus_rad) return;
        const double travel_mm = meter.travel_into_contact_mm({flexion_rad, *varus_rad}, pose_at(*varus_rad));
        if (std::isnan(travel_mm)) return;
        const Eigen::Vector3d shift_mm = travel_mm * motion.delta(flexion_rad);
        for (std::size_t axis = 0; axis < 3; ++axis)
          numbers[axis] += shift_mm[static_cast<Eigen::Index>(axis)];
        const analysis::CompartmentGaps gaps = gaps_at(*varus_rad);
        result.contact[row] = store::code_of(contact_of(gaps));
        result.tx_mm[row] = numbers[0];
        result.ty_mm[row] = numbers[1];
        result.tz_mm[row] = numbers[2];
        result.theta_deg[row] = deg_from_rad(numbers[3]);
        result.varus_deg[row] = deg_from_rad(*varus_rad);
        result.gap_medial_mm[row] = gaps.medial_mm;
        result.gap_lateral_mm[row] = gaps.lateral_mm;
      });
  if (std::ranges::all_of(result.contact,
                          [](std::int8_t c) { return c == store::code_of(store::TwoSidedContact::no_pose); }))
    return std::nullopt;
  return result;
}

}  // namespace vrda::analysis
