#include "solve/step_plan.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

namespace vrda {
namespace {

// Newton on a handful of smooth constraints takes three to six.
constexpr int most_iterations = 20;
constexpr int most_corrections = 2;
// A trial that rises is tried again shorter by this.
constexpr double shorter = 0.25;
// The height is bounded by this many radii: steeper flanks than that are left to the next plan.
constexpr double heights_per_radius = 8.0;

// Squared share of a unit normal below which it adds nothing to the others.
constexpr double dependent_sq = 1e-16;

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
  const QpMatrix& V = eigen.eigenvectors();
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
  const Rotations rotations(at.place, forces_.flexion_rad);
  Matrix5d H = at.potential.hessian;
  Matrix5d bent = H;
  QpMatrix along = QpMatrix::Identity();  // onto what the bearing obstacles leave free
  for (std::size_t k = 0; k < obstacles.size(); ++k) {
    if (!(multipliers_[k] > 0.0)) continue;
    bent -= multipliers_[k] * clearance_bend(obstacles[k], rotations);
    const QpVector across = along * half_spaces_[k].normal;
    const double length_sq = across.squaredNorm();
    if (length_sq > dependent_sq) along -= across * across.transpose() / length_sq;
  }
  const double least = spring_.stiffness_n_mm;
  H = made_positive(scaled(H, options), least);
  if (along.isIdentity(0.0)) return H;
  const QpMatrix across = QpMatrix::Identity() - along;
  const QpMatrix sum = along * scaled(bent, options) * along + across * H * across;
  return made_positive(0.5 * (sum + sum.transpose()), least);
}

// With the spring, angles times the lever, held coordinates taken out.
QpMatrix StepPlanner::scaled(const Matrix5d& hessian, const PlanOptions& options) const
{
  const Vector5d s = scaling(forces_.grip);
  QpMatrix H = s.asDiagonal() * hessian * s.asDiagonal();
  for (Eigen::Index k = 0; k < n_coordinates; ++k) {
    if (k != along_y) H(k, k) += spring_.stiffness_n_mm;
    if (options.is_free[static_cast<std::size_t>(k)]) continue;
    H.row(k).setZero();
    H.col(k).setZero();
    H(k, k) = 1.0;
  }
  return H;
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
  for (const Clearance& c : linear_) {
    HalfSpace row{s.cwiseProduct(c.gradient), options.standoff_mm - c.travel_mm};
    for (Eigen::Index k = 0; k < n_coordinates; ++k) row.normal(k) = is_free(k) ? row.normal(k) : 0.0;
    const double length = std::max(row.normal.norm(), std::numeric_limits<double>::min());
    row_length_.push_back(length);
    half_spaces_.push_back({row.normal / length, row.offset / length});
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

Rest StepPlanner::rest_after(const Rest& at, const QpVector& d, const std::vector<Obstacle>& obstacles,
                             const PlanOptions& options)
{
  const Place place = moved(at.place, d, forces_.grip);
  look(obstacles, place);
  const Rest rest = rest_along_delta(
      forces_, place, {ceiling_mm(next_, place, options), options.reach_mm, options.force_tolerance_n});
  sunk_mm_ = place.pivot_mm.y() - rest.place.pivot_mm.y();
  return rest;
}

// What bends away from the tangent is met again where the step really led, by the same step corrected:
// without it a turn about a contact, which is free, would seem to cost height.
Rest StepPlanner::corrected(const Rest& at, const Vector5d& gone, QpVector d,
                            const std::vector<Obstacle>& obstacles, const PlanOptions& options)
{
  Rest rest = at;
  const Vector5d s = scaling(forces_.grip);
  for (int k = 0; k < most_corrections; ++k) {
    for (std::size_t i = 0; i < obstacles.size(); ++i)
      linear_[i] = {next_[i].travel_mm - clearances_[i].gradient.dot(s.cwiseProduct(d)),
                    clearances_[i].gradient};
    const QpSolution qp = solve_linearised(at, gone, obstacles, options, options.radius_mm);
    if (!qp.is_solved) break;
    d = qp.d;
    rest = rest_after(at, d, obstacles, options);
    if (rest.is_bounded && merit_nmm(rest) < merit_nmm(at)) break;
  }
  return rest;
}

StepPlan StepPlanner::plan(const Rest& from, const std::vector<Obstacle>& obstacles,
                           const PlanOptions& options)
{
  StepPlan plan{from};
  forces_.near = forces_.ligaments.fibres.empty() ? nullptr : &from;
  multipliers_.assign(obstacles.size(), 0.0);
  look(obstacles, from.place);
  clearances_.swap(next_);
  const double merit_from = merit_nmm(from);
  double merit = merit_from, radius_mm = options.radius_mm;
  bool knows_curvature = false;
  for (int k = 0; k < most_iterations && radius_mm > 0.01 * options.tolerance_mm; ++k) {
    const Vector5d gone = step_between(from.place, plan.end.place, forces_.grip);
    linear_ = clearances_;
    // Beyond rounding an iterate keeps its standoff: this keeps it a possible answer.
    for (Clearance& c : linear_) c.travel_mm = std::max(c.travel_mm, options.standoff_mm);
    const QpSolution qp = solve_linearised(plan.end, gone, obstacles, options, radius_mm);
    if (!qp.is_solved) {
      radius_mm *= shorter;
      continue;
    }
    take_support(qp, plan, obstacles.size());
    if (largest_across(qp.d) <= 0.1 * options.tolerance_mm) break;
    Rest rest = rest_after(plan.end, qp.d, obstacles, options);
    if (!(rest.is_bounded && merit_nmm(rest) < merit) && knows_curvature)
      rest = corrected(plan.end, gone, qp.d, obstacles, options);
    if (rest.is_bounded && merit_nmm(rest) < merit) {
      for (Clearance& c : next_) c.travel_mm += sunk_mm_;
      clearances_.swap(next_);
      plan.end = rest;
      merit = merit_nmm(rest);
      knows_curvature = true;
    } else if (!knows_curvature) {
      knows_curvature = true;  // the same again with the curvature of what bears load
    } else {
      radius_mm = shorter * std::min(radius_mm, largest_across(qp.d));
    }
  }
  plan.length_mm = largest_across(step_between(from.place, plan.end.place, forces_.grip));
  plan.gain_nmm = merit_from - merit;
  forces_.near = nullptr;
  return plan;
}

void StepPlanner::take_support(const QpSolution& qp, StepPlan& plan, std::size_t n_obstacles)
{
  std::fill(multipliers_.begin(), multipliers_.end(), 0.0);
  plan.n_bearing = 0;
  for (std::size_t i = 0; i < qp.n_support; ++i) {
    const QpSolution::Support& held = qp.support[i];
    if (held.row >= n_obstacles) continue;
    multipliers_[held.row] = held.multiplier / row_length_[held.row];
    plan.bearing[plan.n_bearing++] = held.row;
  }
}

}  // namespace vrda
