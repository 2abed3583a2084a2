#include "store/poses.hpp"

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "model/side.hpp"
#include "core/units.hpp"

namespace vrda::store {
namespace {

std::string name_of(const store::SmoothedSet& set)
{
  return "degree_" + std::to_string(set.degree);
}

/// Suffix of the name of a recontacted set.
constexpr const char* recontacted = "_recontacted";

bool is_pose(std::int8_t source)
{
  return source != static_cast<std::int8_t>(store::ZeroVarusSource::none);
}

bool has_pose(const std::optional<store::ZeroVarus>& table)
{
  return table && std::any_of(table->source.begin(), table->source.end(), is_pose);
}

std::vector<Attitude> solved_spine(const store::MotionModel& model, const RawSurfaces& raw)
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

/// Delta of each flexion; empty if all are equal.
std::vector<Eigen::Vector3d> deltas_by_flexion(const store::MotionModel& model)
{
  const Points& delta = model.push.delta;
  check(delta.rows() == static_cast<Eigen::Index>(model.flexion_deg.size()),
        "a push has one row per flexion");
  std::vector<Eigen::Vector3d> deltas;
  if (delta == delta.row(0).replicate(delta.rows(), 1)) return deltas;
  for (Eigen::Index i = 0; i < delta.rows(); ++i) deltas.emplace_back(delta.row(i).transpose());
  return deltas;
}

/// The varus solved at each flexion; empty if it is that of the axis.
std::vector<Attitude> free_varus(const store::MotionModel& model, const RawSurfaces& raw)
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

/// Linear in flexion between the attitudes, constant beyond the first and last. Needs at least one.
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

/// Rotates about the rotation centre, then translates: maps stored vertices to W.
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

std::vector<std::string> set_names(const store::MotionModel& model)
{
  std::vector<const store::SmoothedSet*> sets;
  sets.reserve(model.smoothed.size());
  for (const store::SmoothedSet& set : model.smoothed) sets.push_back(&set);
  std::sort(sets.begin(), sets.end(),
            [](const store::SmoothedSet* a, const store::SmoothedSet* b) { return a->degree > b->degree; });
  std::vector<std::string> listed;
  if (model.two_sided) listed.emplace_back("two_sided");
  for (const store::SmoothedSet* set : sets) {
    if (set->recontact_mm) listed.push_back(name_of(*set) + recontacted);
    listed.push_back(name_of(*set));
  }
  listed.emplace_back("raw");
  if (has_pose(model.zero_varus)) listed.emplace_back("zero_varus");
  return listed;
}

store::DefaultMotion default_motion(const store::MotionModel& model)
{
  const std::vector<std::string> sets = set_names(model);
  const bool is_there =
      model.default_motion && std::find(sets.begin(), sets.end(), model.default_motion->set) != sets.end();
  return is_there ? *model.default_motion : store::DefaultMotion{sets.front(), ""};
}

std::string chosen_set(const store::MotionModel& model, const std::string& file, const std::string& set)
{
  if (set.empty()) return default_motion(model).set;
  std::string known;
  for (const std::string& name : all_set_names(model)) {
    if (name == set) return name;
    known += (known.empty() ? "" : ", ") + name;
  }
  throw InputError({file, "--set", set, known});
}

Motion::Motion(const store::MotionModel& model)
    : frame_{side_named(model.side), model.rotation_centre_mm, model.delta},
      R_world_solver_(rotation_world_solver(frame_)),
      deltas_(deltas_by_flexion(model)),
      raw_(model.frames ? RawSurfaces{} : raw_surfaces(model))
{
  check(model.side == "right" || model.side == "left", "the side of a motion model is right or left");
  if (model.frames) {
    use_frames(model);
    return;
  }
  spine_ = solved_spine(model, raw_);
  free_varus_ = free_varus(model, raw_);
}

Motion::Motion(const store::MotionModel& model, const store::SmoothedSet& set) : Motion(model)
{
  use_smoothed(model, set);
  set_varus_range();
}

Motion::Motion(const store::MotionModel& model, const std::string& set) : Motion(model)
{
  const auto found =
      std::find_if(model.smoothed.begin(), model.smoothed.end(), [&](const store::SmoothedSet& candidate) {
        return name_of(candidate) == set || name_of(candidate) + recontacted == set;
      });
  if (set == "two_sided") {
    check(model.two_sided.has_value(), "the set is one of set_names");
    use_two_sided(*model.two_sided);
  } else if (set == "zero_varus") {
    check(has_pose(model.zero_varus), "the set is one of set_names");
    use_zero_varus(*model.zero_varus);
  } else if (const auto sample = quantile_motion(model, set)) {
    use_flexion_table(raw_.flexion_rad, sample->contact, *sample);
  } else if (set != "raw") {
    check(found != model.smoothed.end(), "the set is one of set_names");
    use_smoothed(model, *found);
    if (set != name_of(*found)) {
      check(found->recontact_mm.has_value(), "the recontacted set has travels");
      use_travel(*found->recontact_mm);
    }
  }
  set_varus_range();
}

void Motion::set_varus_range()
{
  if (track_) return;
  first_varus_rad_ = raw_.varus_rad.front();
  last_varus_rad_ = raw_.varus_rad.back();
  if (!free_varus_.empty()) first_varus_rad_ = last_varus_rad_ = free_varus_.front().varus_rad;
  for (const Attitude& found : free_varus_) {
    first_varus_rad_ = std::min(first_varus_rad_, found.varus_rad);
    last_varus_rad_ = std::max(last_varus_rad_, found.varus_rad);
  }
}

void Motion::use_smoothed(const store::MotionModel& model, const store::SmoothedSet& set)
{
  smoothed_ = smoothed_surfaces(model, set);
  if (!smoothed_->has_varus) return;
  free_varus_.clear();
  for (const double flexion_rad : raw_.flexion_rad) {
    free_varus_.push_back({flexion_rad, evaluate(*smoothed_, {flexion_rad, 0.0})[4]});
  }
}

void Motion::use_travel(const store::GridD& travel_mm)
{
  travel_ = HermiteGrid<1>{raw_.flexion_rad, raw_.varus_rad, {}};
  check(static_cast<std::size_t>(travel_mm.rows()) == raw_.flexion_rad.size() &&
            static_cast<std::size_t>(travel_mm.cols()) == raw_.varus_rad.size(),
        "a recontacted set has a travel at every attitude of the axes");
  for (Eigen::Index cell = 0; cell < travel_mm.size(); ++cell) {
    HermiteNode<1>& node = travel_->nodes.emplace_back();
    node.is_solved = !std::isnan(travel_mm.data()[cell]);
    if (node.is_solved) node.value = {travel_mm.data()[cell]};
  }
  set_slopes(*travel_);
}

void Motion::use_two_sided(const store::TwoSided& table)
{
  std::vector<double> flexion_rad;
  for (const double flexion_deg : table.flexion_deg) flexion_rad.push_back(rad_from_deg(flexion_deg));
  use_flexion_table(flexion_rad, table.contact, table);
}

void Motion::use_zero_varus(const store::ZeroVarus& table)
{
  use_flexion_table(raw_.flexion_rad, table.source, table);
}

template <typename Table>
void Motion::use_flexion_table(const std::vector<double>& flexion_rad, const std::vector<std::int8_t>& state,
                               const Table& table)
{
  const std::size_t n = flexion_rad.size();
  for (const std::vector<double>* column :
       {&table.tx_mm, &table.ty_mm, &table.tz_mm, &table.theta_deg, &table.varus_deg}) {
    check(column->size() == n && state.size() == n, "a motion over flexion has one row per flexion");
  }
  by_flexion_ = HermiteGrid<5>{flexion_rad, {0.0}, {}};
  free_varus_.clear();
  for (std::size_t i = 0; i < n; ++i) {
    HermiteNode<5>& node = by_flexion_->nodes.emplace_back();
    node.is_solved = is_pose(state[i]);
    if (!node.is_solved) continue;
    node.value = {table.tx_mm[i], table.ty_mm[i], table.tz_mm[i], rad_from_deg(table.theta_deg[i]),
                  rad_from_deg(table.varus_deg[i])};
    free_varus_.push_back({flexion_rad[i], node.value[4]});
  }
  set_slopes(*by_flexion_);
}

/// Of the numbers of each attitude those nearest to the ones before.
void Motion::use_frames(const store::MotionModel& model)
{
  key_name_ = model.frames->key_name;
  keys_ = model.frames->key;
  track_ = HermiteGrid<6>{keys_, {0.0}, {}};
  std::optional<ClinicalCoordinates> before;
  constexpr double rounding_rad = 1e-9;
  track_->nodes.resize(keys_.size());
  for (std::size_t i = 0; i < keys_.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    if (model.status(row, 0) != status_stable) continue;
    HermiteNode<6>& node = track_->nodes[i];
    node.is_solved = true;
    ClinicalCoordinates c;
    c.flexion_rad = rad_from_deg(model.flexion_deg[i]);
    c.varus_rad = rad_from_deg(model.varus_solved_deg(row, 0));
    c.internal_rotation_rad = rad_from_deg(model.theta_deg(row, 0));
    Eigen::Vector3d shift_mm(model.tx_mm(row, 0), model.ty_mm(row, 0), model.tz_mm(row, 0));
    if (before) {
      c = nearest_numbers(c, *before);
      // Past gimbal lock another theta turns W about Delta.
      const double turn_rad = c.internal_rotation_rad - rad_from_deg(model.theta_deg(row, 0));
      const Eigen::Matrix3d R = R_world_solver(delta_on(keys_, keys_[i]));
      if (std::abs(nearest_turn(turn_rad, 0.0)) > rounding_rad)
        shift_mm = R * rotation_y(turn_rad) * R.transpose() * shift_mm;
    }
    node.value = {shift_mm.x(), shift_mm.y(), shift_mm.z(), c.internal_rotation_rad,
                  c.varus_rad,  c.flexion_rad};
    first_varus_rad_ = before ? std::min(first_varus_rad_, c.varus_rad) : c.varus_rad;
    last_varus_rad_ = before ? std::max(last_varus_rad_, c.varus_rad) : c.varus_rad;
    before = c;
  }
  set_slopes(*track_);
}

JointPose Motion::at_frame(double key) const
{
  check(track_.has_value(), "only a sequence of frames is evaluated by its key");
  const double used = std::clamp(key, keys_.front(), keys_.back());
  const HermiteSample<6> here = sample(*track_, {used, 0.0});
  JointPose pose;
  if (here.is_solved) {
    const auto& [tx, ty, tz, theta_rad, varus_rad, flexion_rad] = here.values;
    const auto within_turn = [](double angle_rad) {
      return angle_rad - 2.0 * pi * std::round(angle_rad / (2.0 * pi));
    };
    pose = pose_along(delta_on(keys_, used), {within_turn(flexion_rad), varus_rad},
                      {tx, ty, tz, within_turn(theta_rad)});
  }
  pose.key = used;
  pose.is_flexion_clamped = used != key;
  return pose;
}

double Motion::key_at(double position) const
{
  check(track_.has_value(), "only a sequence of frames has keys");
  const double last = static_cast<double>(keys_.size() - 1);
  const double at = std::clamp(position, 0.0, last), below = std::floor(at);
  const auto i = static_cast<std::size_t>(below);
  // Exact at the frames.
  return at == below ? keys_[i] : keys_[i] + (at - below) * (keys_[i + 1] - keys_[i]);
}

double Motion::position_of(double key) const
{
  check(track_.has_value(), "only a sequence of frames has keys");
  const auto above = std::upper_bound(keys_.begin(), keys_.end(), key);
  if (above == keys_.begin()) return 0.0;
  const double i = static_cast<double>(above - keys_.begin() - 1);
  if (above == keys_.end()) return i;
  return i + (key - *(above - 1)) / (*above - *(above - 1));
}

Eigen::Vector3d Motion::delta_of(const JointPose& pose) const
{
  return track_ ? delta_on(keys_, pose.key) : delta(pose.attitude.flexion_rad);
}

Motion::Evaluation Motion::smoothed_at(const Attitude& attitude) const
{
  const PoseAndVarus here = evaluate(*smoothed_, attitude);
  Evaluation found{attitude, {here[0], here[1], here[2], here[3]}, true};
  if (smoothed_->has_varus) found.attitude.varus_rad = here[4];
  if (!travel_) return found;
  const HermiteSample<1> travel = sample(*travel_, attitude);
  found.is_solved = travel.is_solved;
  const Eigen::Vector3d shift_mm = travel.values[0] * delta(attitude.flexion_rad);
  for (int axis = 0; axis < 3; ++axis) found.numbers[static_cast<std::size_t>(axis)] += shift_mm[axis];
  return found;
}

Motion::Evaluation Motion::flexion_table_at(const Attitude& attitude) const
{
  const HermiteSample<5> here = sample(*by_flexion_, attitude);
  if (!here.is_solved) return {attitude, {}, false};
  return {{attitude.flexion_rad, here.values[4]},
          {here.values[0], here.values[1], here.values[2], here.values[3]},
          true};
}

Attitude Motion::with_set_varus(const Attitude& wanted) const
{
  if (free_varus_.empty()) return wanted;
  return {wanted.flexion_rad, varus_between(free_varus_, wanted.flexion_rad)};
}

/// `wanted` must be within the axes; the returned attitude has the set's own varus if there is one.
Motion::Evaluation Motion::evaluation_at(const Attitude& wanted) const
{
  const Attitude attitude = with_set_varus(wanted);
  if (by_flexion_) return flexion_table_at(attitude);
  if (smoothed_) return smoothed_at(attitude);
  const RawSample here = sample(raw_, attitude);
  return {attitude, here.values, here.is_solved};
}

std::optional<ClinicalCoordinates> Motion::own_coordinates(const JointPose& pose) const
{
  const bool is_proximal = deltas_.empty() && frame_.delta == Eigen::Vector3d::UnitY();
  if (is_proximal || pose.status != PoseStatus::solved) return std::nullopt;
  return clinical_coordinates(pose.X_reference_moving, frame_.side, frame_.rotation_centre_mm);
}

Eigen::Vector3d Motion::delta(double flexion_rad) const
{
  check(!track_ || deltas_.empty(), "Delta of a sequence of frames is that of a pose");
  return delta_on(raw_.flexion_rad, flexion_rad);
}

Eigen::Vector3d Motion::delta_on(const std::vector<double>& at, double x) const
{
  if (deltas_.empty()) return frame_.delta;
  if (x <= at.front()) return deltas_.front();
  if (x >= at.back()) return deltas_.back();
  const auto after = std::upper_bound(at.begin(), at.end(), x);
  const auto i = static_cast<std::size_t>(after - at.begin());
  if (at[i - 1] == x) return deltas_[i - 1];
  const double s = (x - at[i - 1]) / (at[i] - at[i - 1]);
  return (deltas_[i - 1] + s * (deltas_[i] - deltas_[i - 1])).normalized();
}

Eigen::Matrix3d Motion::R_world_solver(const Eigen::Vector3d& delta) const
{
  if (deltas_.empty()) return R_world_solver_;
  SolverFrame frame = frame_;
  frame.delta = delta;
  return rotation_world_solver(frame);
}

Attitude Motion::clamped(const Attitude& wanted) const
{
  return {std::clamp(wanted.flexion_rad, first_flexion_rad(), last_flexion_rad()),
          std::clamp(wanted.varus_rad, first_varus_rad(), last_varus_rad())};
}

JointPose Motion::at(const Attitude& wanted) const
{
  check(!track_, "a sequence of frames is evaluated by its key");
  return posed(evaluation_at(clamped(wanted)), wanted);
}

JointPose Motion::posed(const Evaluation& found, const Attitude& wanted) const
{
  JointPose pose;
  if (found.is_solved) pose = joint_pose(found.attitude, found.numbers);
  pose.attitude = found.attitude;
  pose.is_flexion_clamped = pose.attitude.flexion_rad != wanted.flexion_rad;
  pose.is_varus_clamped = pose.attitude.varus_rad != wanted.varus_rad;
  return pose;
}

JointPose Motion::joint_pose(const Attitude& attitude, const PoseCoordinates& numbers) const
{
  return pose_along(delta(attitude.flexion_rad), attitude, numbers);
}

JointPose Motion::pose_along(const Eigen::Vector3d& delta, const Attitude& attitude,
                             const PoseCoordinates& numbers) const
{
  JointPose pose;
  pose.attitude = attitude;
  pose.status = PoseStatus::solved;
  pose.theta_rad = numbers[3];

  // Attitude and theta rotate in the solver's frame; conjugation maps them to W of the joint's own side.
  const Eigen::Matrix3d R = R_world_solver(delta);
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
  check(!track_, "varus of a sequence of frames is that of a pose");
  if (!free_varus_.empty()) {
    return evaluation_at({std::clamp(flexion_rad, first_flexion_rad(), last_flexion_rad()), 0.0})
        .attitude.varus_rad;
  }
  if (spine_.empty()) return std::clamp(0.0, first_varus_rad(), last_varus_rad());
  return varus_between(spine_, flexion_rad);
}

}  // namespace vrda::store
