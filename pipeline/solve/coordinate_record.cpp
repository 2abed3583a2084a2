// The certificate of a step with roles for the coordinates, and its record.
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/trig.hpp"
#include "solve/coordinate_run.hpp"
#include "solve/quadratic_program.hpp"

namespace vrda::solve {

using namespace coordinate_rules;

void CoordinateEquilibrium::Run::add_touching(const std::vector<ContactConstraint>& features)
{
  const SolverPosition at = position(current_);
  for (const ContactConstraint& feature : features) {
    const FeatureDistance d = feature_distance(feature, at, state_.scale.pivot_mm);
    if (d.distance_mm < -overlap_rounding_mm || d.distance_mm > touching_within_tolerances * tolerance_mm_)
      continue;
    touching_.push_back(feature);
    distances_.push_back(d);
  }
}

void CoordinateEquilibrium::Run::update_balance()
{
  const SolverPosition at = position(current_);
  const Matrix6d twists = state_.map.twists(current_, at);
  Vector6d wrench;
  energy_nmm_ = energy_nmm(at, wrench);
  gradient_ = twists.transpose() * wrench;
  Vector6d mask = unit_;
  for (std::size_t k = 0; k < n_joint_coordinates; ++k) {
    if (!is_free_[k]) mask(static_cast<Eigen::Index>(k)) = 0.0;
  }
  std::vector<HalfSpaceOf<6>> rows;
  std::vector<double> length;
  over_coordinates_.clear();
  for (const FeatureDistance& d : distances_) {
    over_coordinates_.push_back(twists.transpose() * d.wrench);
    const Vector6d normal = mask.cwiseProduct(over_coordinates_.back());
    length.push_back(std::max(normal.norm(), std::numeric_limits<double>::min()));
    rows.push_back({normal / length.back(), 0.0});
  }
  const QpSolutionOf<6> qp =
      solve_quadratic_program<6>(Matrix6d::Identity(), mask.cwiseProduct(gradient_), rows);
  unbalanced_n_ = qp.d;
  force_n_.assign(distances_.size(), 0.0);
  for (std::size_t k = 0; k < qp.n_active; ++k)
    force_n_[qp.active[k].row] = std::max(qp.active[k].multiplier, 0.0) / length[qp.active[k].row];
}

bool CoordinateEquilibrium::Run::is_certified()
{
  touching_.clear();
  distances_.clear();
  add_touching(sampled_.features);
  update_balance();
  // A constraint that is missing is a small step away, along the residual force.
  double probe_mm = tolerance_mm_;
  for (int k = 0; k < 4 && unbalanced_n_.norm() > 1e-4 * push_n_; ++k) {
    Sampled probe;
    const Vector6d step = unit_.cwiseProduct(unbalanced_n_) * (probe_mm / unbalanced_n_.norm());
    sample(current_ + step, probe, touching_within_tolerances * tolerance_mm_);
    const double before_n = unbalanced_n_.norm();
    add_touching(probe.features);
    update_balance();
    if (unbalanced_n_.norm() > 0.99 * before_n) probe_mm *= 3.0;
  }
  return unbalanced_n_.norm() <= residual_share * push_n_;
}

bool CoordinateEquilibrium::Run::resists(std::size_t coordinate, double shift)
{
  const auto row = static_cast<Eigen::Index>(coordinate);
  const double limit_mm = merit_mm(current_) + determined_tolerances * tolerance_mm_;
  JointCoordinates from = current_;
  from(row) += shift;
  is_free_[coordinate] = false;
  std::vector<ContactConstraint> features = sampled_.features;
  Sampled trial;
  bool result = true;
  for (int k = 0; k < most_trials; ++k) {
    const Plan plan = minimise(from, features, 4.0 * state_.scale.lever_mm * trial_rotation_rad);
    if (plan.violation_mm > infeasible_mm || merit_mm(plan.end) > limit_mm) break;
    sample(plan.end, trial, state_.band_mm);
    if (!std::isfinite(trial.travel_mm) || trial.travel_mm >= -tolerance_mm_) {
      result = false;
      break;
    }
    const std::size_t before = features.size();
    features.insert(features.end(), trial.features.begin(), trial.features.end());
    if (features.size() == before) break;
  }
  is_free_[coordinate] = true;
  return result;
}

// The loads that count as constant along the coordinates do no work on flexion, about the axis of which they
// have a moment all the same: over the coordinates, for what is held.
Vector6d CoordinateEquilibrium::Run::flexing_force() const
{
  const SolverPosition at = position(current_);
  const Loads& loads = task_.loads;
  const Eigen::Vector3d t = at.pose.translation_mm;
  Eigen::Vector3d moment_nmm =
      loads.point_mm.cross(loads.force_n) + loads.moment_nmm * Eigen::Vector3d::UnitY();
  if (has_applied_) {
    Loads none;
    none.force_n.setZero();
    LoadPotential exact = applied_;
    exact.constant.setZero();
    const Vector6d counted = work_of(none, &exact, at).wrench;
    moment_nmm +=
        wrench_of(loads, at.attitude, at.pose).moment_nmm - (counted.head<3>() + t.cross(counted.tail<3>()));
  }
  const SinCos varus = sin_cos(at.attitude.varus_rad);
  const double about_axis = varus.sin * moment_nmm.y() + varus.cos * moment_nmm.z();
  Vector6d wrench = Vector6d::Zero();
  wrench(2) = about_axis / varus.cos;
  return state_.map.twists(current_, at).transpose() * wrench;
}

void CoordinateEquilibrium::Run::fill_balance(StepRecord& record)
{
  Balance& out = record.balance;
  out.energy_nmm = energy_nmm_;
  out.residual_n = unbalanced_n_.norm();
  out.worst_gap_mm = sampled_.travel_mm;
  CoordinateForces held;
  Vector6d force = gradient_;
  double sum_n = 0.0, weighted = 0.0;
  for (std::size_t i = 0; i < touching_.size(); ++i) {
    if (force_n_[i] <= 0.0) continue;
    const FeatureDistance& d = distances_[i];
    ContactForce f;
    f.point_solver_mm = d.point_mm;
    f.normal_solver = d.normal;
    f.along_delta_n = force_n_[i] * -d.normal.y();
    f.triangle_reference = touching_[i].triangles.reference;
    f.triangle_moving = touching_[i].triangles.moving;
    if (!state_.joint.compartment_of_triangle.empty()) {
      f.compartment = static_cast<std::int8_t>(
          state_.joint.compartment_of_triangle[static_cast<std::size_t>(f.triangle_moving)]);
    }
    out.forces.push_back(f);
    sum_n += force_n_[i];
    weighted += force_n_[i] * std::max(d.distance_mm, 0.0);
    force -= force_n_[i] * over_coordinates_[i];
  }
  out.complementarity_mm = sum_n > 0.0 ? weighted / sum_n : 0.0;
  force -= flexing_force();
  for (std::size_t k = 0; k < n_joint_coordinates; ++k)
    held.holding[k] = is_free_[k] ? nan : force(static_cast<Eigen::Index>(k));
  out.flexion_moment_nmm = is_free_[0] ? 0.0 : held.holding[0];
  out.varus_moment_nmm = is_free_[1] ? 0.0 : held.holding[1];
  record.coordinates = held;
}

void CoordinateEquilibrium::Run::measure(StepRecord& record)
{
  const SolverPosition at = position(current_);
  contact::ContactOptions exact;
  exact.band_mm = state_.options.contact_resolution_mm;
  state_.gap.set_attitude(at.attitude);
  measure_contacts(
      state_.joint,
      contact::find_contacts(state_.joint.reference, state_.joint.moving, {at.attitude, at.pose},
                             state_.gap.close_pairs(at.pose, exact.band_mm), state_.narrow_phase, exact),
      exact.band_mm, record);
  measure_gaps(state_.joint, at.attitude, at.pose, record);
  for (std::size_t k = 0; k < n_joint_coordinates; ++k) {
    const double shift = is_rotation(k) ? trial_rotation_rad : trial_translation_mm;
    if (is_free_[k]) record.coordinates->determined[k] = resists(k, -shift) && resists(k, shift) ? 1 : 0;
  }
  record.theta_determined = record.coordinates->determined[2] != 0;
}

}  // namespace vrda::solve
