// The trial step of one iteration: energies of the free coordinates and their minimisation by NLopt.
#include <nlopt.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "solve/coordinate_run.hpp"

namespace vrda::solve {

using namespace coordinate_rules;

std::size_t CoordinateEquilibrium::Run::n_free() const
{
  return static_cast<std::size_t>(std::count(is_free_.begin(), is_free_.end(), true));
}

JointCoordinates CoordinateEquilibrium::Run::moved_from(const JointCoordinates& from,
                                                        const double* step_mm) const
{
  JointCoordinates q = from;
  for (std::size_t k = 0; k < n_joint_coordinates; ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    if (is_free_[k]) q(row) += unit_(row) * *step_mm++;
  }
  return q;
}

void CoordinateEquilibrium::Run::pick_free(const Vector6d& gradient, double* out) const
{
  for (std::size_t k = 0; k < n_joint_coordinates; ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    if (is_free_[k]) *out++ = gradient(row) * unit_(row);
  }
}

double CoordinateEquilibrium::Run::fibre_energy_nmm(const SolverPosition& at, Vector6d& wrench) const
{
  double energy = 0.0;
  wrench.setZero();
  if (state_.ligaments.fibres.empty()) return energy;
  const model::JointPlacement placement = model::joint_placement(at.attitude, at.pose);
  for (const model::Fibre& fibre : state_.ligaments.fibres) {
    const model::FibrePath path = model::fibre_path(fibre, state_.ligaments.wraps, placement);
    const double strain = path.length_mm / fibre.slack_length_mm - 1.0;
    const model::Tension tension =
        model::tension_of(strain, fibre.stiffness_n, state_.ligaments.transition_strain);
    energy += tension.energy_n * fibre.slack_length_mm;
    wrench += wrench_of(tension.force_n * path.direction, path.end_mm, at);
  }
  return energy;
}

double CoordinateEquilibrium::Run::energy_nmm(const SolverPosition& at, Vector6d& wrench) const
{
  const Work work = work_of(task_.loads, applied(), at);
  const double energy = fibre_energy_nmm(at, wrench) - work.work_nmm;
  wrench -= work.wrench;
  return energy;
}

double CoordinateEquilibrium::Run::load_merit_mm(const JointCoordinates& q, double* gradient) const
{
  const SolverPosition at = position(q);
  const Work work = work_of(task_.loads, applied(), at);
  Vector6d away_mm = (q - task_.seed).cwiseQuotient(unit_);
  away_mm(row_of(JointCoordinate::proximal)) = 0.0;
  if (gradient != nullptr) {
    Vector6d slope = state_.map.twists(q, at).transpose() * work.wrench / -push_n_;
    slope += proximal_share_per_mm * away_mm.cwiseQuotient(unit_);
    pick_free(slope, gradient);
  }
  return 0.5 * proximal_share_per_mm * away_mm.squaredNorm() - work.work_nmm / push_n_;
}

double CoordinateEquilibrium::Run::merit_mm(const JointCoordinates& q) const
{
  Vector6d wrench;
  return load_merit_mm(q, nullptr) + fibre_energy_nmm(position(q), wrench) / push_n_;
}

CoordinateEquilibrium::Run::FibreExpansion CoordinateEquilibrium::Run::fibre_expansion(
    const JointCoordinates& q) const
{
  FibreExpansion out;
  if (state_.ligaments.fibres.empty()) return out;
  const auto over_free = [&](const JointCoordinates& c, Vector6d& gradient) {
    const SolverPosition at = position(c);
    Vector6d wrench;
    const double energy_mm = fibre_energy_nmm(at, wrench) / push_n_;
    gradient.setZero();
    pick_free(state_.map.twists(c, at).transpose() * wrench / push_n_, gradient.data());
    return energy_mm;
  };
  out.is_used = true;
  out.energy_mm = over_free(q, out.gradient);
  std::array<double, 6> step{};
  const auto n = static_cast<Eigen::Index>(n_free());
  for (Eigen::Index k = 0; k < n; ++k) {
    step[static_cast<std::size_t>(k)] = difference_mm;
    Vector6d ahead;
    over_free(moved_from(q, step.data()), ahead);
    out.hessian.col(k) = (ahead - out.gradient) / difference_mm;
    step[static_cast<std::size_t>(k)] = 0.0;
  }
  out.hessian = 0.5 * (out.hessian + Matrix6d(out.hessian.transpose()));
  return out;
}

double CoordinateEquilibrium::Run::objective(unsigned n, const double* z, double* gradient, void* data)
{
  const auto& m = *static_cast<Minimisation*>(data);
  if (!m.has_slack) {
    const double loads_mm = m.run->load_merit_mm(m.run->moved_from(*m.from, z), gradient);
    if (!m.fibres.is_used) return loads_mm;
    Vector6d step = Vector6d::Zero();
    std::copy(z, z + n, step.data());
    const Vector6d change = m.fibres.hessian * step;
    for (unsigned k = 0; gradient != nullptr && k < n; ++k) gradient[k] += m.fibres.gradient(k) + change(k);
    return loads_mm + m.fibres.energy_mm + m.fibres.gradient.dot(step) + 0.5 * step.dot(change);
  }
  if (gradient != nullptr) {
    std::fill(gradient, gradient + n, 0.0);
    gradient[n - 1] = 1.0;
  }
  return z[n - 1];
}

void CoordinateEquilibrium::Run::constraints(unsigned m_rows, double* result, unsigned n, const double* z,
                                             double* gradient, void* data)
{
  const auto& m = *static_cast<Minimisation*>(data);
  const JointCoordinates q = m.run->moved_from(*m.from, z);
  const SolverPosition at = m.run->position(q);
  const Matrix6d twists = m.run->state_.map.twists(q, at);
  for (unsigned i = 0; i < m_rows; ++i) {
    const FeatureDistance d = feature_distance((*m.features)[i], at, m.run->state_.scale.pivot_mm);
    result[i] = m.run->standoff_mm_ - std::min(d.distance_mm, 1e3);
    if (m.has_slack) result[i] -= z[n - 1];
    if (gradient == nullptr) continue;
    double* row = gradient + static_cast<std::size_t>(i) * n;
    m.run->pick_free(-(twists.transpose() * d.wrench), row);
    if (m.has_slack) row[n - 1] = -1.0;
  }
}

CoordinateEquilibrium::Run::Plan CoordinateEquilibrium::Run::minimise(
    const JointCoordinates& from, const std::vector<ContactConstraint>& features, double radius_mm,
    bool has_slack)
{
  Minimisation m{this, &from, &features, has_slack, {}};
  if (!has_slack) m.fibres = fibre_expansion(from);
  const std::size_t n = n_free() + (has_slack ? 1 : 0);
  std::vector<double> z(n, 0.0), low(n, -radius_mm), high(n, radius_mm);
  std::vector<double> tolerance(features.size(), 1e-12);
  Plan plan;
  plan.end = from;
  if (has_slack) {
    low.back() = -1e-3;
    high.back() = 1e3;
    z.back() = worst_violation_mm(from, features);
  }
  if (n > 0) {
    const nlopt_opt opt = nlopt_create(NLOPT_LD_SLSQP, static_cast<unsigned>(n));
    check(opt != nullptr, "nlopt_create failed");
    nlopt_set_min_objective(opt, objective, &m);
    if (!features.empty()) {
      nlopt_add_inequality_mconstraint(opt, static_cast<unsigned>(features.size()), constraints, &m,
                                       tolerance.data());
    }
    nlopt_set_lower_bounds(opt, low.data());
    nlopt_set_upper_bounds(opt, high.data());
    nlopt_set_xtol_abs1(opt, 1e-10);
    nlopt_set_maxeval(opt, 200);
    // Its result stays in z where it stops by rounding.
    nlopt_optimize(opt, z.data(), &plan.energy_mm);
    nlopt_destroy(opt);
  }
  plan.end = moved_from(from, z.data());
  for (std::size_t k = 0; k < n_free(); ++k) plan.length_mm = std::max(plan.length_mm, std::abs(z[k]));
  if (!has_slack) plan.energy_mm = objective(static_cast<unsigned>(n), z.data(), nullptr, &m);
  plan.violation_mm = worst_violation_mm(plan.end, features);
  return plan;
}

double CoordinateEquilibrium::Run::worst_violation_mm(const JointCoordinates& q,
                                                      const std::vector<ContactConstraint>& features) const
{
  const SolverPosition at = position(q);
  double worst = 0.0;
  for (const ContactConstraint& feature : features)
    worst = std::max(worst, standoff_mm_ - feature_distance(feature, at, state_.scale.pivot_mm).distance_mm);
  return worst;
}

}  // namespace vrda::solve
