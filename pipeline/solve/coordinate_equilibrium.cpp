#include "solve/coordinate_equilibrium.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <iterator>

#include "solve/coordinate_run.hpp"

namespace vrda::solve {

using namespace coordinate_rules;

CoordinateEquilibrium::Run::Run(State& state, const Task& task)
    : state_(state),
      task_(task),
      is_free_(task.is_free),
      push_n_(task.loads.force_n.norm() > 0.0 ? task.loads.force_n.norm() : 1.0),
      tolerance_mm_(state.options.tolerance_mm),
      standoff_mm_(standoff_share_of_tolerance * tolerance_mm_)
{
  for (std::size_t k = 0; k < n_joint_coordinates; ++k)
    unit_(static_cast<Eigen::Index>(k)) = is_rotation(k) ? 1.0 / state.scale.lever_mm : 1.0;
}

StepRecord CoordinateEquilibrium::Run::run()
{
  n_queries_before_ = state_.gap.n_queries();
  StepRecord record;
  record.status = find_with_turned_loads();
  const SolverPosition at = position(current_);
  record.pose = at.pose;
  record.flexion_rad = at.attitude.flexion_rad;
  record.varus_rad = at.attitude.varus_rad;
  record.iterations = iteration_;
  record.residual_mm = residual_mm_;
  if (record.status == StepStatus::stable) {
    fill_balance(record);
    if (task_.is_measured) measure(record);
  }
  record.queries += state_.gap.n_queries() - n_queries_before_;
  return record;
}

void CoordinateEquilibrium::Run::sample(const JointCoordinates& q, Sampled& out, double band_mm)
{
  const SolverPosition at = position(q);
  state_.gap.set_attitude(at.attitude);
  const geometry::GapResult& found = state_.gap.features(at.pose, band_mm);
  out.travel_mm = found.travel_mm;
  out.features.clear();
  const Configuration configuration = configuration_at(at.pose, at.attitude.varus_rad, state_.scale);
  const Rotations rotations(configuration, at.attitude.flexion_rad);
  const ConstraintMeshes meshes{state_.joint.reference.tree_mesh.mesh, state_.joint.moving.tree_mesh.mesh,
                                state_.scale};
  for (const geometry::GapFeature& feature : found.features) {
    if (out.features.size() == most_features) break;
    const ContactConstraint constraint = contact_constraint_of(feature, meshes, configuration, rotations);
    if (can_carry_load(constraint, state_.joint)) out.features.push_back(constraint);
  }
}

std::optional<Vector6d> CoordinateEquilibrium::Run::lift_at(const JointCoordinates& q) const
{
  const Matrix6d twists = state_.map.twists(q, position(q));
  Vector6d lift = Vector6d::Zero();
  Eigen::Matrix3d JJ = Eigen::Matrix3d::Zero();
  for (std::size_t k = 3; k < n_joint_coordinates; ++k) {
    const Eigen::Vector3d v = twists.col(static_cast<Eigen::Index>(k)).tail<3>();
    if (is_free_[k]) JJ += v * v.transpose();
  }
  // Least squares with a small ridge: a held coordinate leaves a direction without an answer.
  const Eigen::Vector3d y = (JJ + 1e-9 * Eigen::Matrix3d::Identity()).inverse() * Eigen::Vector3d::UnitY();
  Eigen::Vector3d motion = Eigen::Vector3d::Zero();
  for (std::size_t k = 3; k < n_joint_coordinates; ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    if (!is_free_[k]) continue;
    lift(row) = twists.col(row).tail<3>().dot(y);
    motion += lift(row) * twists.col(row).tail<3>();
  }
  if (motion.y() < 0.5) return std::nullopt;
  return Vector6d(lift / motion.y());
}

bool CoordinateEquilibrium::Run::bring_to_contact(JointCoordinates& q, Sampled& sampled, bool only_down)
{
  for (int k = 0; k < most_lifts; ++k) {
    sample(q, sampled, state_.band_mm);
    if (!std::isfinite(sampled.travel_mm)) return false;
    const double way_mm = sampled.travel_mm - standoff_mm_;
    const bool is_there =
        only_down ? sampled.travel_mm >= -overlap_rounding_mm : std::abs(way_mm) <= standoff_mm_;
    if (is_there) return true;
    const std::optional<Vector6d> lift = lift_at(q);
    if (!lift) return only_down ? false : sampled.travel_mm >= -overlap_rounding_mm;
    q += way_mm * *lift;
  }
  return sampled.travel_mm >= -overlap_rounding_mm;
}

bool CoordinateEquilibrium::Run::leave_overlap()
{
  for (int k = 0; k < most_lifts; ++k) {
    const Plan plan = minimise(current_, sampled_.features, first_step_mm, true);
    if (plan.length_mm <= 1e-9) return false;
    current_ = plan.end;
    sample(current_, sampled_, state_.band_mm);
    if (!std::isfinite(sampled_.travel_mm)) return false;
    if (sampled_.travel_mm >= -overlap_rounding_mm) return true;
  }
  return false;
}

StepStatus CoordinateEquilibrium::Run::find_with_turned_loads()
{
  current_ = task_.seed;
  has_applied_ = !task_.loads.applied.empty() || !task_.loads.lines.empty();
  if (!has_applied_) return find_equilibrium();
  const auto at_position = [&] {
    const SolverPosition at = position(current_);
    return potential_near(task_.loads, at.attitude, at.pose);
  };
  applied_ = at_position();
  for (int k = 0; k < most_turns; ++k) {
    const StepStatus status = find_equilibrium();
    if (status != StepStatus::stable) return status;
    const SolverPosition at = position(current_);
    const LoadPotential before = applied_;
    const Vector6d wrench = work_of(task_.loads, &before, at).wrench;
    applied_ = at_position();
    const Vector6d change = unit_.cwiseProduct(state_.map.twists(current_, at).transpose() *
                                               Vector6d(work_of(task_.loads, &applied_, at).wrench - wrench));
    update_balance();  // of the forces at this position
    if (change.norm() <= turned_load_share * push_n_) return status;
  }
  return StepStatus::iteration_limit;
}

StepStatus CoordinateEquilibrium::Run::find_equilibrium()
{
  if (!bring_to_contact(current_, sampled_, false)) {
    if (!std::isfinite(sampled_.travel_mm)) return StepStatus::no_contact;
    if (n_free() == 0 || !leave_overlap()) return StepStatus::no_clearance;
  }
  double radius_mm = first_step_mm;
  int n_rejections = 0;
  std::vector<ContactConstraint> cuts;
  Sampled trial;
  for (iteration_ = 1; iteration_ <= state_.options.max_iterations; ++iteration_) {
    std::vector<ContactConstraint> features = sampled_.features;
    features.insert(features.end(), cuts.begin(), cuts.end());
    const double merit = merit_mm(current_);
    Plan plan = minimise(current_, features, radius_mm);
    const double predicted_mm = merit - plan.energy_mm;
    residual_mm_ = plan.length_mm;
    const bool is_small = plan.length_mm <= tolerance_mm_ || predicted_mm <= 1e-6 * tolerance_mm_;
    if (is_small || plan.violation_mm > infeasible_mm) {
      if (is_small && is_certified()) {
        if (!crosses_ridge()) return StepStatus::stable;
        radius_mm = first_step_mm;
      } else {
        radius_mm *= 0.25;
        if (radius_mm < 0.1 * tolerance_mm_) break;
      }
      cuts.clear();
      n_rejections = 0;
      continue;
    }
    JointCoordinates end = plan.end;
    const bool is_clear = bring_to_contact(end, trial, true);
    if (!std::isfinite(trial.travel_mm)) {
      radius_mm = 0.25 * std::min(radius_mm, plan.length_mm);
      if (radius_mm < tolerance_mm_) return StepStatus::unbounded;
      continue;
    }
    const double gain_mm = is_clear ? merit - merit_mm(end) : 0.0;
    if (gain_mm < enough_of_predicted * predicted_mm) {
      if (!is_clear || gain_mm < 0.0) sample(plan.end, trial, state_.band_mm);
      if (!add_cuts(trial.features, cuts) || ++n_rejections >= most_rejections) {
        radius_mm = 0.25 * plan.length_mm;
        n_rejections = 0;
      }
      continue;
    }
    current_ = end;
    std::swap(sampled_, trial);
    cuts.clear();
    n_rejections = 0;
    if (gain_mm > good_of_predicted * predicted_mm && plan.length_mm > 0.8 * radius_mm)
      radius_mm = std::min(2.0 * radius_mm, longest_step_mm);
  }
  iteration_ = std::min(iteration_, state_.options.max_iterations);
  return StepStatus::iteration_limit;
}

bool CoordinateEquilibrium::Run::add_cuts(const std::vector<ContactConstraint>& found,
                                          std::vector<ContactConstraint>& cuts) const
{
  const SolverPosition at = position(current_);
  const std::size_t before = cuts.size();
  for (const ContactConstraint& feature : found) {
    if (feature_distance(feature, at, state_.scale.pivot_mm).distance_mm >= 0.5 * standoff_mm_)
      cuts.push_back(feature);
  }
  return cuts.size() > before;
}

bool CoordinateEquilibrium::Run::crosses_ridge()
{
  const std::vector<ContactConstraint> touching = touching_;
  const std::vector<FeatureDistance> distances = distances_;
  const double near_mm = touching_within_tolerances * tolerance_mm_;
  const SolverPosition at = position(current_);
  const auto point = [&](const ContactConstraint& c) {
    return feature_distance(c, at, state_.scale.pivot_mm).point_mm;
  };
  for (std::size_t a = 0; a < touching.size(); ++a) {
    if (force_n_[a] <= 0.0) continue;
    const auto is_at_point = [&](const ContactConstraint& c) {
      return (point(c) - distances[a].point_mm).cwiseAbs().maxCoeff() <= near_mm;
    };
    if (std::count_if(touching.begin(), touching.end(), is_at_point) < 2) continue;
    std::vector<ContactConstraint> features;
    std::remove_copy_if(sampled_.features.begin(), sampled_.features.end(), std::back_inserter(features),
                        is_at_point);
    for (const ContactConstraint& single : touching) {
      if (!is_at_point(single)) continue;
      features.push_back(single);
      if (accept_if_lower(features)) return true;
      features.pop_back();
    }
  }
  return false;
}

bool CoordinateEquilibrium::Run::accept_if_lower(const std::vector<ContactConstraint>& features)
{
  const double merit = merit_mm(current_);
  const Plan plan = minimise(current_, features, crossing_step_mm);
  const double predicted_mm = merit - plan.energy_mm;
  if (plan.violation_mm > infeasible_mm || predicted_mm <= tolerance_mm_) return false;
  JointCoordinates end = plan.end;
  Sampled trial;
  if (!bring_to_contact(end, trial, true)) return false;
  if (merit - merit_mm(end) < 0.5 * predicted_mm) return false;
  current_ = end;
  sampled_ = std::move(trial);
  return true;
}

CoordinateEquilibrium::CoordinateEquilibrium(const Joint& joint, const model::Ligaments& ligaments,
                                             const SolverFrame& frame, const EquilibriumOptions& options)
    : state_(std::make_unique<State>(joint, ligaments, frame, options))
{
}

CoordinateEquilibrium::~CoordinateEquilibrium() = default;
CoordinateEquilibrium::CoordinateEquilibrium(CoordinateEquilibrium&&) noexcept = default;

StepRecord CoordinateEquilibrium::solve(const Task& task)
{
  return Run(*state_, task).run();
}

}  // namespace vrda::solve
