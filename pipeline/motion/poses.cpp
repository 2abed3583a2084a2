#include "motion/poses.hpp"

#include <algorithm>

#include "core/error.hpp"
#include "core/units.hpp"

namespace vrda {
namespace {

std::string name_of(const SmoothedSet& set)
{
  return "degree_" + std::to_string(set.degree);
}

std::vector<Attitude> solved_spine(const MotionModel& model, const RawSurfaces& raw)
{
  std::vector<Attitude> spine;
  if (model.is_spine.size() == 0) return spine;
  const std::size_t n_varus = raw.varus_rad.size();
  check(model.is_spine.rows() == model.status.rows() && model.is_spine.cols() == model.status.cols(),
        "is_spine has the size of the axes");
  for (std::size_t i = 0; i < raw.flexion_rad.size(); ++i) {
    for (std::size_t j = 0; j < n_varus; ++j) {
      const bool is_spine = model.is_spine(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) == 1;
      if (!is_spine || !raw.nodes[i * n_varus + j].is_solved) continue;
      spine.push_back({raw.flexion_rad[i], raw.varus_rad[j]});
      break;
    }
  }
  return spine;
}

Eigen::Matrix3d rotation_world_solver(const SolverFrame& frame)
{
  Eigen::Matrix3d R;
  for (int axis = 0; axis < 3; ++axis) R.col(axis) = world_from_solver(frame, Eigen::Vector3d::Unit(axis));
  return R;
}

/// Delta of each flexion, or nothing where there is only one.
std::vector<Eigen::Vector3d> turning_deltas(const MotionModel& model)
{
  const Points& delta = model.push.delta;
  check(delta.rows() == static_cast<Eigen::Index>(model.flexion_deg.size()), "a push has a row a flexion");
  std::vector<Eigen::Vector3d> deltas;
  if (delta == delta.row(0).replicate(delta.rows(), 1)) return deltas;
  for (Eigen::Index i = 0; i < delta.rows(); ++i) deltas.emplace_back(delta.row(i).transpose());
  return deltas;
}

/// The varus that was found at each solved flexion, or nothing where it was that of the axis.
std::vector<Attitude> free_varus(const MotionModel& model, const RawSurfaces& raw)
{
  std::vector<Attitude> found;
  if (raw.varus_rad.size() > 1) return found;
  bool is_free = false;
  for (std::size_t i = 0; i < raw.flexion_rad.size(); ++i) {
    if (!raw.nodes[i].is_solved) continue;
    const double varus_deg = model.varus_solved_deg(static_cast<Eigen::Index>(i), 0);
    is_free = is_free || varus_deg != model.varus_deg.front();
    found.push_back({raw.flexion_rad[i], rad_from_deg(varus_deg)});
  }
  if (!is_free) found.clear();
  return found;
}

/// Linear in flexion between the attitudes, constant beyond the first and last. There must be one.
double varus_between(const std::vector<Attitude>& attitudes, double flexion_rad)
{
  const auto after =
      std::lower_bound(attitudes.begin(), attitudes.end(), flexion_rad,
                       [](const Attitude& cell, double flexion) { return cell.flexion_rad < flexion; });
  if (after == attitudes.begin()) return after->varus_rad;
  if (after == attitudes.end()) return attitudes.back().varus_rad;
  const Attitude& before = *(after - 1);
  const double s = (flexion_rad - before.flexion_rad) / (after->flexion_rad - before.flexion_rad);
  return before.varus_rad + s * (after->varus_rad - before.varus_rad);
}

/// Turns about the rotation centre, then shifts: stored vertices to W.
Pose about_centre(const Eigen::Matrix3d& R_world, const Eigen::Vector3d& shift_mm,
                  const Eigen::Vector3d& centre_mm)
{
  Pose X = Pose::Identity();
  X.linear() = R_world;
  X.translation() = shift_mm - R_world * centre_mm;
  return X;
}

}  // namespace

const char* name_of(PoseStatus status)
{
  switch (status) {
    case PoseStatus::solved:
      return "solved";
    case PoseStatus::unsolved_cell:
      return "unsolved_cell";
  }
  throw InternalError("a pose status has a name");
}

std::vector<std::string> set_names(const MotionModel& model)
{
  std::vector<const SmoothedSet*> sets;
  sets.reserve(model.smoothed.size());
  for (const SmoothedSet& set : model.smoothed) sets.push_back(&set);
  std::sort(sets.begin(), sets.end(),
            [](const SmoothedSet* a, const SmoothedSet* b) { return a->degree > b->degree; });
  std::vector<std::string> names;
  names.reserve(sets.size() + 1);
  for (const SmoothedSet* set : sets) names.push_back(name_of(*set));
  names.push_back("raw");
  return names;
}

Motion::Motion(const MotionModel& model, const std::string& set)
    : frame_{model.side == "left" ? Side::left : Side::right, model.rotation_centre_mm, model.delta},
      R_world_solver_(rotation_world_solver(frame_)),
      deltas_(turning_deltas(model)),
      raw_(raw_surfaces(model))
{
  check(model.side == "right" || model.side == "left", "the side of a motion model is right or left");
  spine_ = solved_spine(model, raw_);
  free_varus_ = free_varus(model, raw_);
  first_varus_rad_ = raw_.varus_rad.front();
  last_varus_rad_ = raw_.varus_rad.back();
  if (!free_varus_.empty()) first_varus_rad_ = last_varus_rad_ = free_varus_.front().varus_rad;
  for (const Attitude& found : free_varus_) {
    first_varus_rad_ = std::min(first_varus_rad_, found.varus_rad);
    last_varus_rad_ = std::max(last_varus_rad_, found.varus_rad);
  }
  if (set == "raw") return;
  const auto found = std::find_if(model.smoothed.begin(), model.smoothed.end(),
                                  [&](const SmoothedSet& candidate) { return name_of(candidate) == set; });
  check(found != model.smoothed.end(), "the set asked of a motion model is one of set_names");
  smoothed_ = smoothed_surfaces(model, *found);
}

RawSample Motion::numbers_at(const Attitude& attitude) const
{
  if (!smoothed_) return sample(raw_, attitude);
  return {evaluate(*smoothed_, attitude), true};
}

double Motion::varus_at(const Attitude& wanted) const
{
  if (!free_varus_.empty()) return varus_between(free_varus_, wanted.flexion_rad);
  return std::clamp(wanted.varus_rad, first_varus_rad(), last_varus_rad());
}

/// The rule of the job's table: components linear between the rows, held beyond the ends, then normalised.
Eigen::Matrix3d Motion::R_world_solver(double flexion_rad) const
{
  if (deltas_.empty()) return R_world_solver_;
  const std::vector<double>& at = raw_.flexion_rad;
  SolverFrame frame = frame_;
  if (flexion_rad <= at.front()) {
    frame.delta = deltas_.front();
  } else if (flexion_rad >= at.back()) {
    frame.delta = deltas_.back();
  } else {
    const auto after = std::upper_bound(at.begin(), at.end(), flexion_rad);
    const auto i = static_cast<std::size_t>(after - at.begin());
    const double s = (flexion_rad - at[i - 1]) / (at[i] - at[i - 1]);
    frame.delta = (deltas_[i - 1] + s * (deltas_[i] - deltas_[i - 1])).normalized();
  }
  return rotation_world_solver(frame);
}

JointPose Motion::at(const Attitude& wanted) const
{
  JointPose pose;
  pose.attitude.flexion_rad = std::clamp(wanted.flexion_rad, first_flexion_rad(), last_flexion_rad());
  pose.attitude.varus_rad = varus_at({pose.attitude.flexion_rad, wanted.varus_rad});
  pose.is_flexion_clamped = pose.attitude.flexion_rad != wanted.flexion_rad;
  pose.is_varus_clamped = pose.attitude.varus_rad != wanted.varus_rad;
  const RawSample found = numbers_at(pose.attitude);
  if (!found.is_solved) return pose;
  JointPose here = placed(pose.attitude, found.numbers);
  here.is_flexion_clamped = pose.is_flexion_clamped;
  here.is_varus_clamped = pose.is_varus_clamped;
  return here;
}

JointPose Motion::placed(const Attitude& attitude, const PoseNumbers& numbers) const
{
  JointPose pose;
  pose.attitude = attitude;
  pose.status = PoseStatus::solved;
  pose.theta_rad = numbers[3];

  // The attitude and theta are turns of the solver's frame: conjugated, they act in W of the own side.
  const Eigen::Matrix3d R = R_world_solver(attitude.flexion_rad);
  const Eigen::Matrix3d R_solver_world = R.transpose();
  const Eigen::Matrix3d R_attitude = R * reference_rotation(pose.attitude) * R_solver_world;
  const Eigen::Matrix3d R_theta = R * rotation_y(pose.theta_rad) * R_solver_world;
  const Eigen::Vector3d shift_mm(numbers[0], numbers[1], numbers[2]);
  pose.X_world_reference = about_centre(R_attitude, Eigen::Vector3d::Zero(), frame_.rotation_centre_mm);
  pose.X_world_moving = about_centre(R_theta, shift_mm, frame_.rotation_centre_mm);
  pose.X_reference_moving = pose.X_world_reference.inverse() * pose.X_world_moving;
  return pose;
}

double Motion::balanced_varus_rad(double flexion_rad) const
{
  if (!free_varus_.empty()) return varus_between(free_varus_, flexion_rad);
  if (spine_.empty()) return std::clamp(0.0, first_varus_rad(), last_varus_rad());
  return varus_between(spine_, flexion_rad);
}

}  // namespace vrda
