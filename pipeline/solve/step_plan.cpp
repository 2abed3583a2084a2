#include "solve/step_plan.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

namespace vrda {
namespace {

// Newton on a handful of smooth constraints takes three to six.
constexpr int most_iterations = 20;
// A trial that rises is tried again shorter by this.
constexpr double shorter = 0.25;
// The height is bounded by this many radii: steeper flanks than that are left to the next plan.
constexpr double heights_per_radius = 8.0;

// Angles to millimetres.
Vector5d scaling(const Grip& grip)
{
  Vector5d s;
  s << 1.0, 1.0, 1.0, 1.0 / grip.lever_mm, 1.0 / grip.lever_mm;
  return s;
}

// Eigenvalues below `least` raised to it.
QpMatrix made_positive(const QpMatrix& H, double least)
{
  const Eigen::SelfAdjointEigenSolver<QpMatrix> eigen(H);
  if (eigen.eigenvalues()(0) >= least) return H;
  const QpVector raised = eigen.eigenvalues().cwiseMax(least);
  const QpMatrix V = eigen.eigenvectors();
  const QpMatrix out = V * raised.asDiagonal() * V.transpose();
  return 0.5 * (out + out.transpose());
}

double ceiling_mm(const std::vector<Clearance>& clearances, const Place& place, const PlanOptions& options)
{
  double least = options.reach_mm;
  for (const Clearance& c : clearances) least = std::min(least, c.travel_mm);
  return place.pivot_mm.y() + least - options.standoff_mm;
}

double largest_across(const Vector5d& step)
{
  return std::max({std::abs(step(along_x)), std::abs(step(along_z)), std::abs(step(about_y)),
                   std::abs(step(about_varus))});
}

}  // namespace

double StepPlanner::merit_nmm(const Rest& rest) const
{
  Vector5d away = step_between(spring_.seed, rest.place, forces_.grip);
  away(along_y) = 0.0;
  return rest.potential.energy_nmm + 0.5 * spring_.stiffness_n_mm * away.squaredNorm();
}

void StepPlanner::look(const std::vector<Obstacle>& obstacles, const Place& place)
{
  const Rotations rotations(place, forces_.flexion_rad);
  next_.resize(obstacles.size());
  for (std::size_t k = 0; k < obstacles.size(); ++k) next_[k] = clearance(obstacles[k], place, rotations);
}

QpMatrix StepPlanner::curvature(const Rest& at, const std::vector<Obstacle>& obstacles,
                                const PlanOptions& options) const
{
  Matrix5d H = at.potential.hessian;
  const Rotations rotations(at.place, forces_.flexion_rad);
  for (std::size_t k = 0; k < obstacles.size(); ++k) {
    if (multipliers_[k] > 0.0) H -= multipliers_[k] * clearance_bend(obstacles[k], rotations);
  }
  const Vector5d s = scaling(forces_.grip);
  H = s.asDiagonal() * H * s.asDiagonal();
  for (Eigen::Index k = 0; k < n_coordinates; ++k) {
    if (k != along_y) H(k, k) += spring_.stiffness_n_mm;
    if (options.is_free[static_cast<std::size_t>(k)]) continue;
    H.row(k).setZero();
    H.col(k).setZero();
    H(k, k) = 1.0;
  }
  return made_positive(H, spring_.stiffness_n_mm);
}

// `gone`: from the start of the plan to `at`.
QpSolution StepPlanner::solve_linearised(const Rest& at, const Vector5d& gone,
                                         const std::vector<Obstacle>& obstacles, const PlanOptions& options,
                                         double radius_mm)
{
  const Vector5d s = scaling(forces_.grip);
  const auto is_free = [&](Eigen::Index k) { return options.is_free[static_cast<std::size_t>(k)]; };
  half_spaces_.clear();
  row_length_.clear();
  for (const Clearance& c : clearances_) {
    HalfSpace row{s.cwiseProduct(c.gradient), options.standoff_mm - c.travel_mm};
    for (Eigen::Index k = 0; k < n_coordinates; ++k) row.normal(k) = is_free(k) ? row.normal(k) : 0.0;
    const double length = std::max(row.normal.norm(), std::numeric_limits<double>::min());
    row_length_.push_back(length);
    // Beyond rounding an iterate keeps its standoff: this keeps it a possible answer.
    half_spaces_.push_back({row.normal / length, std::min(row.offset / length, 0.0)});
  }
  for (Eigen::Index k = 0; k < n_coordinates; ++k) {
    if (!is_free(k)) continue;
    const double room = k == along_y ? heights_per_radius * options.radius_mm : options.radius_mm;
    HalfSpace wall;
    wall.normal(k) = 1.0;
    wall.offset = std::min(0.0, std::max(-room - gone(k), -room * radius_mm / options.radius_mm));
    half_spaces_.push_back(wall);
    wall.normal(k) = -1.0;
    wall.offset = std::min(0.0, std::max(gone(k) - room, -room * radius_mm / options.radius_mm));
    half_spaces_.push_back(wall);
  }
  Vector5d away = step_between(spring_.seed, at.place, forces_.grip);
  away(along_y) = 0.0;
  QpVector g = s.cwiseProduct(at.potential.gradient) + spring_.stiffness_n_mm * away;
  for (Eigen::Index k = 0; k < n_coordinates; ++k) g(k) = is_free(k) ? g(k) : 0.0;
  return solve_quadratic_program(curvature(at, obstacles, options), g, half_spaces_);
}

StepPlan StepPlanner::plan(const Rest& from, const std::vector<Obstacle>& obstacles,
                           const PlanOptions& options)
{
  StepPlan plan{from};
  multipliers_.assign(obstacles.size(), 0.0);
  look(obstacles, from.place);
  clearances_.swap(next_);
  const double merit_from = merit_nmm(from);
  double merit = merit_from, radius_mm = options.radius_mm;
  bool knows_curvature = false;
  for (int k = 0; k < most_iterations && radius_mm > 0.01 * options.tolerance_mm; ++k) {
    const Vector5d gone = step_between(from.place, plan.end.place, forces_.grip);
    const QpSolution qp = solve_linearised(plan.end, gone, obstacles, options, radius_mm);
    if (!qp.is_solved) {
      radius_mm *= shorter;
      continue;
    }
    std::fill(multipliers_.begin(), multipliers_.end(), 0.0);
    plan.n_bearing = 0;
    for (std::size_t i = 0; i < qp.n_support; ++i) {
      const QpSolution::Support& held = qp.support[i];
      if (held.row >= obstacles.size()) continue;
      multipliers_[held.row] = held.multiplier / row_length_[held.row];
      plan.bearing[plan.n_bearing++] = held.row;
    }
    if (largest_across(qp.d) <= 0.1 * options.tolerance_mm) break;
    const Place place = moved(plan.end.place, qp.d, forces_.grip);
    look(obstacles, place);
    const Rest rest = rest_along_delta(
        forces_, place, {ceiling_mm(next_, place, options), options.reach_mm, options.force_tolerance_n});
    const double next_merit = merit_nmm(rest);
    if (rest.is_bounded && next_merit < merit) {
      for (Clearance& c : next_) c.travel_mm -= rest.place.pivot_mm.y() - place.pivot_mm.y();
      clearances_.swap(next_);
      plan.end = rest;
      merit = next_merit;
      knows_curvature = true;
    } else if (!knows_curvature) {
      knows_curvature = true;  // the same again with the curvature of what bears load
    } else {
      radius_mm = shorter * std::min(radius_mm, largest_across(qp.d));
      knows_curvature = false;
    }
  }
  plan.length_mm = largest_across(step_between(from.place, plan.end.place, forces_.grip));
  plan.gain_nmm = merit_from - merit;
  return plan;
}

}  // namespace vrda
