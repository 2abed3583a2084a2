#include "solve/step_plan.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

namespace vrda::solve {
namespace {

// With a few smooth constraints Newton's method takes three to six.
constexpr int max_plan_iterations = 20;
constexpr int max_corrections = 2;
// Reduction of the trust radius when a trial does not decrease the merit.
constexpr double shrink_factor = 0.25;
// Bound of the height in radii: steeper flanks are left to the next plan.
constexpr double heights_per_radius = 8.0;

// Squared component of a unit normal below which it depends linearly on the others.
constexpr double dependent_sq = 1e-16;

// Derivatives of the coordinates over the scaled step.
Vector5d scaling(const RotationScale& scale)
{
  Vector5d s;
  s << 1.0, 1.0, 1.0, 1.0 / scale.lever_mm, 1.0 / scale.lever_mm;
  return s;
}

// Raises eigenvalues below `least` to it. Most matrices have none: a Cholesky decomposition of the rest,
// clear of rounding, shows it at a tenth of the cost.
QpMatrix make_positive_definite(const QpMatrix& H, double least)
{
  if (H.isDiagonal(0.0)) return H.diagonal().cwiseMax(least).asDiagonal();
  constexpr double clear_share = 1.001;
  const QpMatrix rest = H - clear_share * least * QpMatrix::Identity();
  if (Eigen::LLT<QpMatrix>(rest).info() == Eigen::Success) return H;
  const Eigen::SelfAdjointEigenSolver<QpMatrix> eigen(H);
  if (eigen.eigenvalues()(0) >= least) return H;
  const QpVector raised = eigen.eigenvalues().cwiseMax(least);
  const QpMatrix& V = eigen.eigenvectors();
  const QpMatrix out = V * raised.asDiagonal() * V.transpose();
  return 0.5 * (out + out.transpose());
}

double ceiling_mm(const std::vector<Clearance>& clearances, const Configuration& configuration,
                  const PlanOptions& options)
{
  double least = options.reach_mm;
  for (const Clearance& c : clearances) least = std::min(least, c.travel_mm);
  return configuration.pivot_mm.y() + least - options.standoff_mm;
}

}  // namespace

double largest_but_height(const Vector5d& step)
{
  return std::max({std::abs(step(along_x)), std::abs(step(along_z)), std::abs(step(about_y)),
                   std::abs(step(about_varus))});
}

double StepPlanner::merit_nmm(const EquilibriumCandidate& candidate) const
{
  Vector5d from_seed = step_between(spring_.seed, candidate.configuration, forces_.scale);
  from_seed(along_y) = 0.0;
  return candidate.potential.energy_nmm + 0.5 * spring_.stiffness_n_mm * from_seed.squaredNorm();
}

void StepPlanner::sample_constraints(const std::vector<ContactConstraint>& constraints,
                                     const Configuration& configuration)
{
  const Rotations rotations(configuration, forces_.flexion_rad);
  trial_.resize(constraints.size());
  for (std::size_t k = 0; k < constraints.size(); ++k)
    trial_[k] = clearance(constraints[k], configuration, rotations);
}

QpMatrix StepPlanner::curvature(const EquilibriumCandidate& at,
                                const std::vector<ContactConstraint>& constraints, const PlanOptions& options)
{
  const Rotations rotations(at.configuration, forces_.flexion_rad);
  Matrix5d H = at.potential.hessian;
  Matrix5d lagrangian = H;
  QpMatrix null_space = QpMatrix::Identity();  // projector on the null space of the active constraints
  for (std::size_t k = 0; k < constraints.size(); ++k) {
    if (!(multipliers_[k] > 0.0)) continue;
    lagrangian -= multipliers_[k] * clearance_hessian(constraints[k], at.configuration, rotations);
    const QpVector across = null_space * half_spaces_[k].normal;
    const double length_sq = across.squaredNorm();
    if (length_sq > dependent_sq) null_space -= across * across.transpose() / length_sq;
  }
  const double least = spring_.stiffness_n_mm;
  if (!base_ || base_->of != H) base_ = {H, make_positive_definite(scaled(H, options), least)};
  H = base_->positive;
  if (null_space.isIdentity(0.0)) return H;
  const QpMatrix across = QpMatrix::Identity() - null_space;
  const QpMatrix sum = null_space * scaled(lagrangian, options) * null_space + across * H * across;
  return make_positive_definite(0.5 * (sum + sum.transpose()), least);
}

// Adds the proximal term, scales angles by the lever and removes held coordinates.
QpMatrix StepPlanner::scaled(const Matrix5d& hessian, const PlanOptions& options) const
{
  const Vector5d s = scaling(forces_.scale);
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

// `travelled`: from the start of the plan to `at`.
QpSolution StepPlanner::solve_linearised(const EquilibriumCandidate& at, const Vector5d& travelled,
                                         const std::vector<ContactConstraint>& constraints,
                                         const PlanOptions& options, double radius_mm)
{
  const Vector5d s = scaling(forces_.scale);
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
    const double max_mm = k == along_y ? heights_per_radius * options.radius_mm : options.radius_mm;
    HalfSpace bound;
    bound.normal(k) = 1.0;
    bound.offset = std::min(0.0, std::max(-max_mm - travelled(k), -max_mm * radius_mm / options.radius_mm));
    half_spaces_.push_back(bound);
    bound.normal(k) = -1.0;
    bound.offset = std::min(0.0, std::max(travelled(k) - max_mm, -max_mm * radius_mm / options.radius_mm));
    half_spaces_.push_back(bound);
  }
  Vector5d from_seed = step_between(spring_.seed, at.configuration, forces_.scale);
  from_seed(along_y) = 0.0;
  QpVector g = s.cwiseProduct(at.potential.gradient) + spring_.stiffness_n_mm * from_seed;
  for (Eigen::Index k = 0; k < n_coordinates; ++k) g(k) = is_free(k) ? g(k) : 0.0;
  return solve_quadratic_program<5>(curvature(at, constraints, options), g, half_spaces_);
}

EquilibriumCandidate StepPlanner::candidate_after(const EquilibriumCandidate& at, const QpVector& d,
                                                  const std::vector<ContactConstraint>& constraints,
                                                  const PlanOptions& options)
{
  const Configuration configuration = moved(at.configuration, d, forces_.scale);
  sample_constraints(constraints, configuration);
  const EquilibriumCandidate candidate = equilibrium_along_delta(
      forces_, configuration,
      {ceiling_mm(trial_, configuration, options), options.reach_mm, options.force_tolerance_n});
  drop_mm_ = configuration.pivot_mm.y() - candidate.configuration.pivot_mm.y();
  return candidate;
}

// Second-order correction for curved constraints; without it a free rotation about a contact loses height.
EquilibriumCandidate StepPlanner::corrected(const EquilibriumCandidate& at, const Vector5d& travelled,
                                            QpVector d, const std::vector<ContactConstraint>& constraints,
                                            const PlanOptions& options)
{
  EquilibriumCandidate candidate = at;
  const Vector5d s = scaling(forces_.scale);
  for (int k = 0; k < max_corrections; ++k) {
    for (std::size_t i = 0; i < constraints.size(); ++i)
      linear_[i] = {trial_[i].travel_mm - clearances_[i].gradient.dot(s.cwiseProduct(d)),
                    clearances_[i].gradient};
    const QpSolution qp = solve_linearised(at, travelled, constraints, options, options.radius_mm);
    if (!qp.is_solved) break;
    d = qp.d;
    candidate = candidate_after(at, d, constraints, options);
    if (candidate.is_bounded && merit_nmm(candidate) < merit_nmm(at)) break;
  }
  return candidate;
}

StepPlan StepPlanner::plan(const EquilibriumCandidate& from,
                           const std::vector<ContactConstraint>& constraints, const PlanOptions& options)
{
  StepPlan plan{from};
  base_.reset();
  forces_.expansion_point = forces_.is_linear() ? nullptr : &from;
  multipliers_.assign(constraints.size(), 0.0);
  sample_constraints(constraints, from.configuration);
  clearances_.swap(trial_);
  const double merit_from = merit_nmm(from);
  double merit = merit_from, radius_mm = options.radius_mm;
  bool has_multipliers = false;
  for (int k = 0; k < max_plan_iterations && radius_mm > 0.01 * options.tolerance_mm; ++k) {
    const Vector5d travelled = step_between(from.configuration, plan.end.configuration, forces_.scale);
    linear_ = clearances_;
    // Removes rounding, so that the zero step is feasible.
    for (Clearance& c : linear_) c.travel_mm = std::max(c.travel_mm, options.standoff_mm);
    const QpSolution qp = solve_linearised(plan.end, travelled, constraints, options, radius_mm);
    if (!qp.is_solved) {
      radius_mm *= shrink_factor;
      continue;
    }
    update_active_set(qp, plan, constraints.size());
    if (largest_but_height(qp.d) <= 0.1 * options.tolerance_mm) break;
    EquilibriumCandidate candidate = candidate_after(plan.end, qp.d, constraints, options);
    if (!(candidate.is_bounded && merit_nmm(candidate) < merit) && has_multipliers)
      candidate = corrected(plan.end, travelled, qp.d, constraints, options);
    if (candidate.is_bounded && merit_nmm(candidate) < merit) {
      for (Clearance& c : trial_) c.travel_mm += drop_mm_;
      clearances_.swap(trial_);
      plan.end = candidate;
      merit = merit_nmm(candidate);
      has_multipliers = true;
    } else if (!has_multipliers) {
      has_multipliers = true;  // repeats the iteration with the Hessians of the active constraints
    } else {
      radius_mm = shrink_factor * std::min(radius_mm, largest_but_height(qp.d));
    }
  }
  plan.length_mm =
      largest_but_height(step_between(from.configuration, plan.end.configuration, forces_.scale));
  plan.gain_nmm = merit_from - merit;
  forces_.expansion_point = nullptr;
  return plan;
}

void StepPlanner::update_active_set(const QpSolution& qp, StepPlan& plan, std::size_t n_constraints)
{
  std::fill(multipliers_.begin(), multipliers_.end(), 0.0);
  plan.n_active = 0;
  for (std::size_t i = 0; i < qp.n_active; ++i) {
    const QpSolution::ActiveConstraint& active = qp.active[i];
    if (active.row >= n_constraints) continue;
    multipliers_[active.row] = active.multiplier / row_length_[active.row];
    plan.active[plan.n_active++] = active.row;
  }
}

}  // namespace vrda::solve
