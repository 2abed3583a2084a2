#include "solve/sweep.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <condition_variable>
#include <exception>
#include <limits>
#include <mutex>
#include <numeric>
#include <thread>
#include <utility>

#include "core/text.hpp"
#include "core/units.hpp"
#include "solve/compliant_contact.hpp"
#include "solve/prior.hpp"
#include "solve/stability_search.hpp"

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

namespace {

// Poses closer than the search's resolutions are the same equilibrium.
constexpr double same_position_mm = 0.1;
constexpr double same_angle_rad = rad_from_deg(0.1);
// Negligible: 1e-6 N mm is 20 N along 5e-8 mm.
constexpr double same_energy_nmm = 1e-6;

bool is_same_equilibrium(const StepRecord& a, const StepRecord& b)
{
  return (a.pose.translation_mm - b.pose.translation_mm).norm() <= same_position_mm &&
         std::abs(a.pose.theta_rad - b.pose.theta_rad) <= same_angle_rad &&
         std::abs(a.varus_rad - b.varus_rad) <= same_angle_rad;
}

}  // namespace

std::vector<SpineOffset> spine_offsets(int n)
{
  constexpr double turn = rad_from_deg(6.0);
  constexpr double shift_mm = 3.0;
  const std::vector<SpineOffset> all{{turn, 0, 0},      {-turn, 0, 0},      {0, shift_mm, 0},
                                     {0, -shift_mm, 0}, {2.0 * turn, 0, 0}, {-2.0 * turn, 0, 0},
                                     {0, 0, shift_mm},  {0, 0, -shift_mm}};
  check(n >= 0 && n <= static_cast<int>(all.size()), "spine_offsets: at most 8");
  return {all.begin(), all.begin() + n};
}

std::vector<SpineOffset> polish_offsets(const SweepPlan& plan)
{
  if (plan.n_restarts == 0 || !plan.has_facets) return {};
  // The smaller ones reach equilibria on neighbouring facets, which the larger ones pass over.
  constexpr double rotation_rad = rad_from_deg(0.5), shift_mm = 0.3;
  std::vector<SpineOffset> offsets;
  for (const double size : {1.0, 0.25}) {
    for (const double signed_size : {size, -size}) {
      offsets.push_back({signed_size * rotation_rad, 0, 0});
      offsets.push_back({0, signed_size * shift_mm, 0});
      offsets.push_back({0, 0, signed_size * shift_mm});
    }
  }
  return offsets;
}

FreeSpineStep select_lowest(const std::vector<StepRecord>& ends)
{
  check(!ends.empty(), "lowest_of: no result");
  FreeSpineStep step;
  // Of each equilibrium the first result, by which others are distinguished, and the lowest.
  std::vector<std::pair<const StepRecord*, const StepRecord*>> optima;
  const StepRecord* lowest = nullptr;
  double least_nmm = 0.0, most_nmm = 0.0, least_rad = 0.0, most_rad = 0.0;
  for (const StepRecord& end : ends) {
    if (end.status != StepStatus::stable) continue;
    const double energy_nmm = end.balance.energy_nmm, theta_rad = end.pose.theta_rad;
    const bool is_first = lowest == nullptr;
    if (is_first || energy_nmm < lowest->balance.energy_nmm - same_energy_nmm) lowest = &end;
    least_nmm = is_first ? energy_nmm : std::min(least_nmm, energy_nmm);
    most_nmm = is_first ? energy_nmm : std::max(most_nmm, energy_nmm);
    least_rad = is_first ? theta_rad : std::min(least_rad, theta_rad);
    most_rad = is_first ? theta_rad : std::max(most_rad, theta_rad);
    const auto known = std::find_if(optima.begin(), optima.end(), [&](const auto& other) {
      return is_same_equilibrium(*other.first, end);
    });
    if (known == optima.end()) {
      optima.emplace_back(&end, &end);
    } else if (lowest == &end || energy_nmm < known->second->balance.energy_nmm - same_energy_nmm) {
      known->second = &end;
    }
  }
  step.chosen = lowest == nullptr ? ends.front() : *lowest;
  step.n_optima = static_cast<std::int32_t>(optima.size());
  for (const auto& [first, found] : optima)
    step.equilibria.push_back({found->pose, found->varus_rad, found->balance.energy_nmm, found == lowest,
                               static_cast<std::size_t>(found - ends.data())});
  step.theta_spread_rad = most_rad - least_rad;
  step.energy_spread_nmm = most_nmm - least_nmm;
  return step;
}

namespace {

// Least sum up to an equilibrium, and the equilibrium before it on that path.
struct PathSum {
  double sum_nmm = 0.0;
  std::size_t before = 0;
};

PathPoint point_of(const SpineEquilibrium& equilibrium, std::int32_t path_row)
{
  return {equilibrium.pose, equilibrium.varus_rad, path_row};
}

void choose(FreeSpineStep& step, std::size_t k, const std::vector<StepRecord>& ends)
{
  for (SpineEquilibrium& equilibrium : step.equilibria) equilibrium.is_chosen = false;
  step.equilibria[k].is_chosen = true;
  step.chosen = ends[step.equilibria[k].end];
}

std::size_t least_of(const std::vector<PathSum>& sums)
{
  const auto is_less = [](const PathSum& a, const PathSum& b) { return a.sum_nmm < b.sum_nmm; };
  return static_cast<std::size_t>(std::min_element(sums.begin(), sums.end(), is_less) - sums.begin());
}

}  // namespace

std::vector<std::size_t> least_path(const std::vector<std::vector<double>>& energy_nmm,
                                    const PairPenalty& penalty_nmm)
{
  std::vector<std::size_t> rows;  // those with an entry
  std::vector<std::vector<PathSum>> sums;
  for (std::size_t i = 0; i < energy_nmm.size(); ++i) {
    if (energy_nmm[i].empty()) continue;
    std::vector<PathSum> here;
    for (std::size_t to = 0; to < energy_nmm[i].size(); ++to) {
      std::vector<PathSum> ways;
      for (std::size_t k = 0; !rows.empty() && k < sums.back().size(); ++k)
        ways.push_back({sums.back()[k].sum_nmm + penalty_nmm({rows.back(), k}, {i, to}), k});
      here.push_back(ways.empty() ? PathSum{} : ways[least_of(ways)]);
      here.back().sum_nmm += energy_nmm[i][to];
    }
    rows.push_back(i);
    sums.push_back(std::move(here));
  }
  std::vector<std::size_t> path(energy_nmm.size(), 0);
  std::size_t k = rows.empty() ? 0 : least_of(sums.back());
  for (std::size_t r = rows.size(); r-- > 0;) {
    path[rows[r]] = k;
    k = sums[r][k].before;
  }
  return path;
}

std::vector<FreeSpineStep> select_continuous(const std::vector<std::vector<StepRecord>>& ends,
                                             const std::vector<std::int32_t>& path_row,
                                             const ChangePenalty& penalty_nmm)
{
  std::vector<FreeSpineStep> path;
  std::vector<std::vector<double>> above_nmm(ends.size());  // the lowest of each flexion
  for (std::size_t i = 0; i < ends.size(); ++i) {
    path.push_back(ends[i].empty() ? FreeSpineStep{} : select_lowest(ends[i]));
    for (const SpineEquilibrium& one : path[i].equilibria)
      above_nmm[i].push_back(one.energy_nmm - path[i].chosen.balance.energy_nmm);
  }
  const auto point = [&](const PathEntry& at) {
    return point_of(path[at.row].equilibria[at.entry], path_row[at.row]);
  };
  const std::vector<std::size_t> chosen = least_path(
      above_nmm,
      [&](const PathEntry& from, const PathEntry& to) { return penalty_nmm(point(from), point(to)); });
  for (std::size_t i = 0; i < path.size(); ++i) {
    if (!path[i].equilibria.empty()) choose(path[i], chosen[i], ends[i]);
  }
  return path;
}

namespace {

std::int32_t column_nearest(const std::vector<double>& varus_rad, double target_rad)
{
  std::size_t nearest = 0;
  for (std::size_t j = 1; j < varus_rad.size(); ++j) {
    if (std::abs(varus_rad[j] - target_rad) < std::abs(varus_rad[nearest] - target_rad)) nearest = j;
  }
  return static_cast<std::int32_t>(nearest);
}

double varus_of(const Seed& seed)
{
  return seed.attitude ? seed.attitude->varus_rad : 0.0;
}

Seed moved(Seed seed, const SpineOffset& offset)
{
  seed.pose.theta_rad += offset.theta_rad;
  seed.pose.translation_mm.x() += offset.shift_x_mm;
  seed.pose.translation_mm.z() += offset.shift_z_mm;
  return seed;
}

// Bound on the propagations of equilibria; each pass that changes something lowers an energy.
constexpr std::int32_t max_passes = 20;
constexpr std::int32_t max_polish_rounds = 5;
// Number of the first step of a polish, above those of chains, restarts and propagations.
constexpr std::int32_t first_polish_number = 1000;
// Of the start that the plan has, below the first step of a polish.
constexpr std::int32_t plan_start_number = first_polish_number - 1;
struct Stopped {};  // thrown and caught inside a worker to end it

class Sweep {
 public:
  Sweep(const SweepPlan& plan, const SolveStep& solve, const SweepHooks& hooks)
      : plan_(plan),
        solve_(solve),
        hooks_(hooks),
        n_flexion_(static_cast<std::int32_t>(plan.flexion_rad.size())),
        n_varus_(static_cast<std::int32_t>(plan.varus_rad.size())),
        path_rad_(path_of(plan)),
        n_path_(static_cast<std::int32_t>(path_rad_.size())),
        offsets_(spine_offsets(plan.n_restarts))
  {
    check(n_flexion_ > 0 && n_varus_ > 0, "sweep: an empty grid");
    check(!plan.is_varus_free || (plan.spine == SpineRule::free_varus && n_varus_ == 1),
          "sweep: free varus needs one column and a free spine");
    result_.cells.resize(plan.flexion_rad.size() * plan.varus_rad.size());
    result_.spine_column.assign(plan.flexion_rad.size(), -1);
    for (std::int32_t i = 0; i < n_flexion_; ++i) {
      for (std::int32_t j = 0; j < n_varus_; ++j) cell(i, j).key = {StepKind::row, i, j};
    }
    row_seeds_.resize(plan.flexion_rad.size());
    for (const double flexion_rad : plan.flexion_rad) {
      const auto at = std::lower_bound(path_rad_.begin(), path_rad_.end(), flexion_rad);
      check(at != path_rad_.end() && *at == flexion_rad, "sweep: the path contains the grid's flexions");
      path_row_.push_back(static_cast<std::int32_t>(at - path_rad_.begin()));
    }
    choose_rows();
    if (plan.spine != SpineRule::free_varus) return;
    result_.free_spine.resize(plan.flexion_rad.size());
    path_.resize(path_rad_.size());
    path_seeds_.resize(path_rad_.size());
    ends_.resize(path_rad_.size());
  }

  SweepResult run(int n_threads)
  {
    {
      std::vector<std::jthread> workers;
      for (int k = 0; k < std::max(1, n_threads); ++k) {
        workers.emplace_back([this, k] { work(k); });
      }
    }
    if (failure_) std::rethrow_exception(failure_);
    result_.is_complete = !is_stopped_;
    return std::move(result_);
  }

 private:
  void choose_rows()
  {
    flexions_.n_expected = path_rad_.size();
    is_chosen_.assign(plan_.flexion_rad.size(), plan_.rows ? 0 : 1);
    if (plan_.rows) {
      for (const std::int32_t i : *plan_.rows) {
        check(i >= 0 && i < n_flexion_ && is_chosen_[static_cast<std::size_t>(i)] == 0,
              "sweep: rows of the grid, each once");
        is_chosen_[static_cast<std::size_t>(i)] = 1;
      }
    }
    rows_.n_expected = plan_.rows ? plan_.rows->size() : plan_.flexion_rad.size();
  }

  StepRecord& cell(std::int32_t i, std::int32_t j)
  {
    return result_.cells[static_cast<std::size_t>(i) * plan_.varus_rad.size() + static_cast<std::size_t>(j)];
  }

  // The first worker solves the spine and releases each row; all solve released rows. With a free spine all
  // first run the restarts of each flexion, then the first propagates the lowest equilibria.
  void work(int worker)
  {
    try {
      if (worker == 0) solve_spine();
      if (plan_.spine == SpineRule::free_varus) {
        while (const std::optional<std::int32_t> flexion = next_of(flexions_)) {
          restart(*flexion, worker);
          count_restarted();
        }
        if (worker == 0 && wait_for_restarts()) propagate_lower_equilibria();
      }
      while (const std::optional<std::int32_t> row = next_of(rows_)) {
        if (plan_.spine == SpineRule::free_varus) start_row(*row, worker);
        solve_row(*row, worker);
      }
    } catch (const Stopped&) {
      is_stopped_ = true;
      end_early(nullptr);
    } catch (...) {
      end_early(std::current_exception());
    }
  }

  void end_early(const std::exception_ptr& failure)
  {
    const std::lock_guard lock(mutex_);
    if (failure && !failure_) failure_ = failure;
    is_ended_ = true;
    changed_.notify_all();
  }

  // Whether another worker was stopped or failed, for example on a full disk.
  bool is_ended()
  {
    const std::lock_guard lock(mutex_);
    return is_ended_;
  }

  // Rows in the order of their release.
  struct Queue {
    std::vector<std::int32_t> ready;
    std::size_t n_taken = 0;
    std::size_t n_expected = 0;
  };

  void release(Queue& queue, std::int32_t row)
  {
    const std::lock_guard lock(mutex_);
    queue.ready.push_back(row);
    changed_.notify_all();
  }

  void release_row(std::int32_t row)
  {
    if (is_chosen_[static_cast<std::size_t>(row)] != 0) release(rows_, row);
  }

  std::optional<std::int32_t> next_of(Queue& queue)
  {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] {
      return is_ended_ || queue.n_taken < queue.ready.size() || queue.n_taken == queue.n_expected;
    });
    if (is_ended_ || queue.n_taken == queue.n_expected) return std::nullopt;
    return queue.ready[queue.n_taken++];
  }

  void count_restarted()
  {
    const std::lock_guard lock(mutex_);
    ++n_restarted_;
    changed_.notify_all();
  }

  // False when another worker was stopped or failed.
  bool wait_for_restarts()
  {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return is_ended_ || n_restarted_ == n_path_; });
    return !is_ended_;
  }

  std::optional<StepRecord> recalled(const StepKey& key) const
  {
    return hooks_.recall ? hooks_.recall(key) : std::nullopt;
  }

  StepRecord solved(const StepTask& task)
  {
    if (is_ended() || (hooks_.is_stopped && hooks_.is_stopped())) throw Stopped{};
    StepRecord record = solve_(task);
    record.key = task.key;
    return record;
  }

  StepRecord kept(StepRecord record)
  {
    if (hooks_.keep) hooks_.keep(record);
    return record;
  }

  StepRecord step(const StepTask& task)
  {
    if (std::optional<StepRecord> known = recalled(task.key)) return *known;
    return kept(solved(task));
  }

  // Whether other steps may start from it.
  bool is_usable(const StepRecord& record) const
  {
    return record.status == StepStatus::stable &&
           (!plan_.is_in_joint || plan_.is_in_joint(record.pose, path_row_of(record.key)));
  }

  StepRecord grid_step(const StepKey& key, const std::vector<Seed>& seeds, int worker)
  {
    if (std::optional<StepRecord> known = recalled(key)) return *known;
    StepTask task;
    task.key = key;
    task.attitude = {plan_.flexion_rad[static_cast<std::size_t>(key.flexion)],
                     plan_.varus_rad[static_cast<std::size_t>(key.varus)]};
    task.path_row = path_row_of(key);
    task.springs = springs_of(task.path_row);
    task.worker = worker;
    return kept(solve_from_seeds(
        task, seeds, plan_.max_seed_step_rad, [this](const StepTask& part) { return solved(part); },
        [this](const StepRecord& record) { return is_usable(record); }));
  }

  // Only the steps of the free spine have keys along the path.
  std::int32_t path_row_of(const StepKey& key) const
  {
    return key.kind == StepKind::free_spine ? key.flexion : path_row_[static_cast<std::size_t>(key.flexion)];
  }

  std::vector<CoordinateSpring> springs_of(std::int32_t path_row) const
  {
    return plan_.springs.empty() ? std::vector<CoordinateSpring>{}
                                 : plan_.springs[static_cast<std::size_t>(path_row)];
  }

  Seed seed_of(const StepRecord& record) const
  {
    const std::int32_t row = path_row_of(record.key);
    const double flexion_rad =
        record.coordinates ? record.coordinates->flexion_rad : path_rad_[static_cast<std::size_t>(row)];
    return {record.pose, Attitude{flexion_rad, record.varus_rad}, row};
  }

  StepRecord free_step(const StepKey& key, const Seed& seed, int worker, int band = 0)
  {
    StepTask task;
    task.key = key;
    task.path_row = path_row_of(key);
    task.attitude = {path_rad_[static_cast<std::size_t>(task.path_row)], varus_of(seed)};
    task.seed = seed.pose;
    task.seed_attitude = seed.attitude;
    task.seed_path_row = seed.path_row;
    task.is_varus_free = true;
    task.band = band;
    task.springs = springs_of(task.path_row);
    if (key.kind == StepKind::free_spine) task.known = &ends_[static_cast<std::size_t>(key.flexion)];
    task.is_measured = plan_.is_varus_free && !plan_.measures_chosen && band == 0;  // it may become a cell
    task.worker = worker;
    return step(task);
  }

  void solve_spine()
  {
    if (plan_.spine == SpineRule::free_varus) return solve_free_spine();
    Seed seed{plan_.initial, {}, 0};
    std::int32_t column = column_nearest(plan_.varus_rad, 0.0);
    for (std::int32_t i = 0; i < n_flexion_; ++i) {
      const StepRecord chosen = kept_as_spine(balanced_cell(i, column, seed));
      column = chosen.key.varus;
      if (is_usable(chosen)) seed = seed_of(chosen);
      cell(i, column) = chosen;
      result_.spine_column[static_cast<std::size_t>(i)] = column;
      row_seeds_[static_cast<std::size_t>(i)] = seed;
      release_row(i);
    }
  }

  // Keeps a step that was solved under another key also as the spine's cell.
  StepRecord kept_as_spine(StepRecord chosen)
  {
    chosen.key.kind = StepKind::spine;
    if (hooks_.keep && !recalled(chosen.key)) hooks_.keep(chosen);
    return chosen;
  }

  bool is_better_cell(const StepRecord& a, const StepRecord& b) const
  {
    return is_usable(a) != is_usable(b) ? is_usable(a) : is_better_balanced(a, b);
  }

  // Walks from `column` towards better balance until it worsens; each cell is seeded by the previous one.
  StepRecord balanced_cell(std::int32_t flexion, std::int32_t column, const Seed& seed)
  {
    StepRecord best = grid_step({StepKind::spine_probe, flexion, column}, seeds_from(plan_, seed), 0);
    if (plan_.spine == SpineRule::nearest_zero) return best;
    const StepRecord start = best;
    for (const std::int32_t direction : {+1, -1}) {
      StepRecord here = start;
      while (const std::optional<StepRecord> next = neighbour(here, direction, seed)) {
        if (!is_better_cell(*next, here)) break;
        here = *next;
      }
      if (is_better_cell(here, best)) best = here;
      // The imbalance decreases on this side, so it grows on the other.
      if (best.key.varus != start.key.varus) break;
    }
    return best;
  }

  std::optional<StepRecord> neighbour(const StepRecord& from, std::int32_t direction, const Seed& seed)
  {
    const std::int32_t column = from.key.varus + direction;
    if (column < 0 || column >= n_varus_) return std::nullopt;
    return grid_step({StepKind::spine_probe, from.key.flexion, column},
                     seeds_from(plan_, is_usable(from) ? seed_of(from) : seed), 0);
  }

  // One chain up the flexions and one back down; the second releases the flexions for restarts.
  void solve_free_spine()
  {
    Seed seed{plan_.initial, {}, 0};
    for (std::int32_t i = 0; i < n_path_; ++i) {
      const StepRecord record = free_step({StepKind::free_spine, i, 0}, seed, 0);
      if (record.status == StepStatus::stable) seed = seed_of(record);
      ends_[static_cast<std::size_t>(i)].push_back(record);
    }
    for (std::int32_t i = n_path_; i-- > 0;) {
      path_seeds_[static_cast<std::size_t>(i)] = seed;
      const StepRecord record = free_step({StepKind::free_spine, i, 1}, seed, 0);
      if (record.status == StepStatus::stable) seed = seed_of(record);
      ends_[static_cast<std::size_t>(i)].push_back(record);
      release(flexions_, i);
    }
  }

  // Starts rotated and shifted from the lower result of both chains, and the start that the plan has.
  void restart(std::int32_t i, int worker)
  {
    const auto row = static_cast<std::size_t>(i);
    if (!plan_.starts.empty() && plan_.starts[row])
      ends_[row].push_back(
          free_step({StepKind::free_spine, i, plan_start_number}, seed_of(*plan_.starts[row]), worker));
    const StepRecord lower = select_lowest(ends_[row]).chosen;
    const Seed from = lower.status == StepStatus::stable ? seed_of(lower) : path_seeds_[row];
    for (std::size_t k = 0; k < offsets_.size(); ++k) {
      const StepKey key{StepKind::free_spine, i, static_cast<std::int32_t>(k) + 2};
      ends_[row].push_back(free_step(key, moved(from, offsets_[k]), worker));
    }
    path_[row] = select_lowest(ends_[row]);
    polish(i, worker);
  }

  // Small offsets from the lowest equilibrium, until none leads to a lower one.
  void polish(std::int32_t i, int worker)
  {
    const auto row = static_cast<std::size_t>(i);
    std::int32_t number = first_polish_number;
    const std::vector<SpineOffset> offsets = polish_offsets(plan_);
    bool is_lower = !offsets.empty() && path_[row].chosen.status == StepStatus::stable;
    for (std::int32_t round = 0; is_lower && round < max_polish_rounds; ++round) {
      const StepRecord from = path_[row].chosen;
      for (const SpineOffset& offset : offsets) {
        ends_[row].push_back(
            free_step({StepKind::free_spine, i, number++}, moved(seed_of(from), offset), worker));
      }
      path_[row] = select_lowest(ends_[row]);
      is_lower = path_[row].chosen.key != from.key;
    }
  }

  // An equilibrium found at one flexion may lead to a lower one at its neighbours: up the flexions and down
  // again, each flexion starts from its neighbour's equilibrium, once and then whenever that has changed.
  void propagate_lower_equilibria()
  {
    std::vector<std::int8_t> is_new_upward(path_rad_.size(), 1), is_new_downward = is_new_upward;
    const auto try_neighbour = [&](std::int32_t from, std::int32_t to, std::int32_t number,
                                   std::vector<std::int8_t>& is_new) {
      const bool is_tried = is_new[static_cast<std::size_t>(from)] == 0;
      is_new[static_cast<std::size_t>(from)] = 0;
      if (is_tried || !propagate(from, to, number)) return false;
      is_new_upward[static_cast<std::size_t>(to)] = is_new_downward[static_cast<std::size_t>(to)] = 1;
      return true;
    };
    bool is_changed = true;
    for (std::int32_t pass = 0; is_changed && pass < max_passes; ++pass) {
      is_changed = false;
      for (std::int32_t i = 1; i < n_path_; ++i)
        is_changed |= try_neighbour(i - 1, i, 2 * pass, is_new_upward);
      for (std::int32_t i = n_path_ - 1; i-- > 0;)
        is_changed |= try_neighbour(i + 1, i, 2 * pass + 1, is_new_downward);
    }
    if (plan_.change_penalty_nmm) {
      std::vector<std::int32_t> rows(path_rad_.size());
      std::iota(rows.begin(), rows.end(), 0);
      path_ = select_continuous(ends_, rows, plan_.change_penalty_nmm);
    }
    for (std::int32_t i = 0; i < n_flexion_; ++i) {
      const auto row = static_cast<std::size_t>(i), path_row = static_cast<std::size_t>(path_row_[row]);
      result_.free_spine[row] = path_[path_row];
      row_seeds_[row] = path_seeds_[path_row];
      release_row(i);
    }
  }

  // Whether a lower equilibrium was found.
  bool propagate(std::int32_t from, std::int32_t to, std::int32_t number)
  {
    const StepRecord& source = path_[static_cast<std::size_t>(from)].chosen;
    FreeSpineStep& target = path_[static_cast<std::size_t>(to)];
    if (source.status != StepStatus::stable) return false;
    const StepKey key{StepKind::free_spine, to, static_cast<std::int32_t>(offsets_.size()) + 2 + number};
    std::vector<StepRecord>& ends = ends_[static_cast<std::size_t>(to)];
    ends.push_back(free_step(key, seed_of(source), 0));
    const StepKey before = target.chosen.key;
    target = select_lowest(ends);
    return target.chosen.key != before;
  }

  // Solves the band of the flexion and the grid's cell nearest to its free equilibrium.
  void start_row(std::int32_t i, int worker)
  {
    const auto row = static_cast<std::size_t>(i);
    FreeSpineStep& free = result_.free_spine[row];
    const bool is_stable = free.chosen.status == StepStatus::stable;
    if (plan_.has_band && is_stable) {
      free.band_low = free_step({StepKind::band, i, 0}, seed_of(free.chosen), worker, -1);
      free.band_high = free_step({StepKind::band, i, 1}, seed_of(free.chosen), worker, +1);
    }
    if (is_stable) row_seeds_[row] = seed_of(free.chosen);
    const std::int32_t column = column_nearest(plan_.varus_rad, varus_of(row_seeds_[row]));
    cell(i, column) = plan_.is_varus_free && !plan_.measures_chosen
                          ? spine_cell_of(free.chosen, i)
                          : grid_step({StepKind::spine, i, column}, {row_seeds_[row]}, worker);
    if (cell(i, column).status == StepStatus::stable) row_seeds_[row] = seed_of(cell(i, column));
    result_.spine_column[row] = column;
  }

  StepRecord spine_cell_of(StepRecord chosen, std::int32_t flexion)
  {
    chosen.key.flexion = flexion;
    chosen.key.varus = 0;
    return kept_as_spine(chosen);
  }

  void solve_row(std::int32_t i, int worker)
  {
    const std::int32_t spine = result_.spine_column[static_cast<std::size_t>(i)];
    for (const std::int32_t direction : {+1, -1}) {
      // The nearest usable cell inward; the spine's own seed if even its cell is not usable.
      Seed seed = row_seeds_[static_cast<std::size_t>(i)];
      for (std::int32_t j = spine + direction; j >= 0 && j < n_varus_; j += direction) {
        StepRecord record = grid_step({StepKind::row, i, j}, seeds_from(plan_, seed), worker);
        if (is_usable(record)) seed = seed_of(record);
        cell(i, j) = std::move(record);
      }
    }
  }

  const SweepPlan& plan_;
  const SolveStep& solve_;
  const SweepHooks& hooks_;
  const std::int32_t n_flexion_;
  const std::int32_t n_varus_;
  const std::vector<double> path_rad_;
  const std::int32_t n_path_;
  std::vector<std::int32_t> path_row_;  // [n_flexion] of the grid's flexions
  const std::vector<SpineOffset> offsets_;
  // A row's entries are written by the spine before its row is released, then by the row's worker only.
  SweepResult result_;
  std::vector<Seed> row_seeds_;
  std::vector<std::int8_t> is_chosen_;  // [n_flexion] whether the row is solved
  std::vector<FreeSpineStep> path_;     // [n_path] of a free spine, like the next two
  std::vector<Seed> path_seeds_;
  std::vector<std::vector<StepRecord>> ends_;  // results of all starts

  std::mutex mutex_;  // guards the members below and orders the workers' access to a row's data
  std::condition_variable changed_;
  Queue flexions_;  // released for restarts
  Queue rows_;      // released for their cells
  std::int32_t n_restarted_ = 0;
  bool is_ended_ = false;
  std::atomic<bool> is_stopped_ = false;
  std::exception_ptr failure_;
};

}  // namespace

SweepResult sweep(const SweepPlan& plan, const SolveStep& solve, const SweepHooks& hooks, int n_threads)
{
  if (!plan.prior.empty()) return sweep_with_prior(plan, solve, hooks, n_threads);
  SweepResult result = Sweep(plan, solve, hooks).run(n_threads);
  if (plan.follow && result.is_complete)
    result.is_complete = plan.follow(plan, solve, hooks, n_threads, result);
  return result;
}

double extent_along_delta_mm(const Mesh& mesh)
{
  const Box box = bounding_box(mesh);
  return box.max_mm.y() - box.min_mm.y();
}

double thinnest_part_mm(const SolverBody& body)
{
  const std::int32_t n_components =
      body.component.empty() ? 1 : 1 + *std::max_element(body.component.begin(), body.component.end());
  double least = std::numeric_limits<double>::infinity();
  for (std::int32_t c = 0; c < n_components; ++c) {
    std::vector<Eigen::Index> rows;
    for (Eigen::Index t = 0; t < body.mesh.triangles.rows(); ++t) {
      if (body.component.empty() || body.component[static_cast<std::size_t>(t)] == c) rows.push_back(t);
    }
    if (rows.empty()) continue;
    const Mesh part = select_triangles(body.mesh, rows);
    const bool is_closed = edge_counts(part).boundary == 0;
    least = std::min(least, is_closed ? 2.0 * std::abs(signed_volume_mm3(part)) / area_mm2(part)
                                      : mean_edge_length_mm(part));
  }
  return least;
}

double substep_mm(const SolverBody& reference, const SolverBody& moving)
{
  return 0.5 * std::min(thinnest_part_mm(reference), thinnest_part_mm(moving));
}

Joint make_joint(const SolverBody& reference, const SolverBody& moving,
                 const std::vector<Compartment>& compartment_of_triangle)
{
  check(reference.mesh.triangles.rows() > 0 && moving.mesh.triangles.rows() > 0, "make_joint: an empty mesh");
  check(compartment_of_triangle.empty() ||
            static_cast<Eigen::Index>(compartment_of_triangle.size()) == moving.mesh.triangles.rows(),
        "make_joint: one compartment per moving triangle");
  Joint joint;
  joint.reference = contact::make_collider(reference.mesh);
  joint.moving = contact::make_collider(moving.mesh);
  joint.compartment_of_triangle = compartment_of_triangle;
  joint.reference_gap = geometry::GapTree(reference.mesh);
  joint.moving_gap = geometry::GapTree(moving.mesh);
  for (const Compartment side : all_compartments)
    joint.compartment_gap[side] = geometry::GapTree(moving.mesh, triangles_of(compartment_of_triangle, side));
  joint.reference_protrudes =
      contact::protruding_vertices(joint.reference.tree_mesh.mesh, joint.reference.features);
  joint.moving_protrudes = contact::protruding_vertices(joint.moving.tree_mesh.mesh, joint.moving.features);
  joint.substep_mm = substep_mm(reference, moving);
  joint.compliant = std::make_shared<const LazyCompliantSurfaces>(reference.component);
  return joint;
}

OfCompartments<geometry::GapQuery> compartment_queries(const geometry::GapTree& reference,
                                                       const OfCompartments<geometry::GapTree>& moving)
{
  return {geometry::GapQuery(reference, moving[0]), geometry::GapQuery(reference, moving[1])};
}

ContactRecord contact_record(const Joint& joint, const contact::Contact& contact)
{
  ContactRecord record{contact.point_mm,         contact.normal,
                       contact.distance_mm,      contact.triangles.reference,
                       contact.triangles.moving, 0};
  if (joint.compartment_of_triangle.empty()) return record;
  record.compartment = static_cast<std::int8_t>(
      joint.compartment_of_triangle[static_cast<std::size_t>(contact.triangles.moving)]);
  return record;
}

void measure_contacts(const Joint& joint, const std::vector<contact::Contact>& contacts, double resolution_mm,
                      StepRecord& record)
{
  const Eigen::Vector3d middle = mean_point(contacts);
  int n_resisting = 0;
  for (const contact::Contact& c : contacts) {
    record.contacts.push_back(contact_record(joint, c));
    const auto side = static_cast<Compartment>(record.contacts.back().compartment);
    if (side != Compartment::none) record.is_in_contact[side] = true;
    n_resisting += std::abs(moment_about_mm(c, middle)) > resolution_mm ? 1 : 0;
  }
  record.theta_determined = n_resisting >= 2;
}

void measure_contacts(const Joint& joint, const Attitude& attitude, geometry::GapQuery& gap,
                      contact::NarrowPhase& narrow_phase, double resolution_mm, StepRecord& record)
{
  contact::ContactOptions exact;
  exact.band_mm = resolution_mm;
  const contact::ContactObjects objects{joint.reference.tree_mesh, joint.reference.features, joint.moving,
                                        &gap.close_pairs(record.pose, resolution_mm)};
  measure_contacts(joint, contact::find_contacts(objects, attitude, record.pose, narrow_phase, exact),
                   resolution_mm, record);
}

void measure_gaps(const Joint& joint, const Attitude& attitude, const MovingPose& pose, StepRecord& record)
{
  if (joint.compartment_of_triangle.empty()) return;
  for (const Compartment side : all_compartments) {
    geometry::GapQuery query(joint.reference_gap, joint.compartment_gap[side]);
    query.set_attitude(attitude);
    ++record.queries;
    const double travel_mm = query.next_contact(pose).travel_mm;
    record.gap_mm[side] = std::isfinite(travel_mm) ? travel_mm : nan;
  }
}

namespace {

// Number of parts of equal length from one attitude to another; a part may exceed the limit by rounding.
int n_parts(const Attitude& from, const Attitude& to, double max_step_rad)
{
  constexpr double rounding = 1e-9;
  const double largest_rad =
      std::max(std::abs(to.flexion_rad - from.flexion_rad), std::abs(to.varus_rad - from.varus_rad));
  return static_cast<int>(std::ceil(largest_rad / max_step_rad - rounding));
}

Attitude between(const Attitude& from, const Attitude& to, double share)
{
  return {from.flexion_rad + share * (to.flexion_rad - from.flexion_rad),
          from.varus_rad + share * (to.varus_rad - from.varus_rad)};
}

struct Attempt {
  StepTask task;
  StepRecord record;
};

bool is_stable(const Attempt& attempt)
{
  return attempt.record.status == StepStatus::stable;
}

}  // namespace

std::vector<Seed> seeds_from(const SweepPlan& plan, const Seed& seed)
{
  std::vector<Seed> seeds{seed};
  if (seed.attitude) seeds.push_back({plan.initial, {}, 0});
  for (const double theta_rad : plan.last_resort_thetas_rad) {
    MovingPose rotated = plan.initial;
    rotated.theta_rad += theta_rad;
    seeds.push_back({rotated, {}, 0, true});
  }
  return seeds;
}

StepRecord solve_from_seeds(StepTask task, const std::vector<Seed>& seeds, double max_seed_step_rad,
                            const SolveStep& solve, const std::function<bool(const StepRecord&)>& is_usable)
{
  std::vector<Attempt> attempts;
  const auto is_solved = [&] {
    attempts.push_back({task, solve(task)});
    return is_usable(attempts.back().record);
  };
  for (const Seed& seed : seeds) {
    if (seed.is_last_resort && std::any_of(attempts.begin(), attempts.end(), is_stable)) continue;
    task.seed = seed.pose;
    task.seed_attitude = seed.attitude;
    task.seed_path_row = seed.path_row;
    if (is_solved() || max_seed_step_rad <= 0.0) return attempts.back().record;
    if (!seed.attitude) continue;
    const int n = n_parts(*seed.attitude, task.attitude, max_seed_step_rad);
    StepTask part = task;
    part.is_measured = false;
    bool is_nearer = false;
    for (int k = 1; k < n; ++k) {
      part.attitude = between(*seed.attitude, task.attitude, static_cast<double>(k) / n);
      const StepRecord record = solve(part);
      if (!is_usable(record)) break;
      part.seed = record.pose;
      part.seed_attitude = part.attitude;
      part.seed_path_row = part.path_row;
      is_nearer = true;
    }
    if (!is_nearer) continue;
    task.seed = part.seed;
    task.seed_attitude = part.seed_attitude;
    task.seed_path_row = part.seed_path_row;
    if (is_solved()) return attempts.back().record;
  }
  const auto stable = std::find_if(attempts.rbegin(), attempts.rend(), is_stable);
  if (stable == attempts.rend() || stable == attempts.rbegin()) return attempts.back().record;
  return solve(stable->task);
}

}  // namespace vrda::solve
