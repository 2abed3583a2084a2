#include "analysis/model_evaluation.hpp"

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "core/units.hpp"
#include "solve/case_solver.hpp"

namespace vrda::analysis {
namespace {

// Kinds of evaluations. The values are those of the journal.
enum EvaluationKind : std::int8_t { whole_spine, near_spine, whole_laxity, near_laxity };

// A pose that moves farther by a difference is another equilibrium.
constexpr double same_branch_mm = 5.0, same_branch_rad = rad_from_deg(15.0);
constexpr double rounding_rad = 1e-9;
constexpr std::size_t n_pose_values = 6;  // status, translation, theta, varus

std::vector<double> numbers_of(const Eigen::VectorXd& x)
{
  return {x.data(), x.data() + x.size()};
}

std::vector<double> joined(const Eigen::VectorXd& a, const Eigen::VectorXd& b)
{
  std::vector<double> all = numbers_of(a);
  all.insert(all.end(), b.data(), b.data() + b.size());
  return all;
}

void append_pose(std::vector<double>& values, const StepRecord& record)
{
  values.push_back(static_cast<double>(record.status));
  for (Eigen::Index k = 0; k < 3; ++k) values.push_back(record.pose.translation_mm(k));
  values.push_back(record.pose.theta_rad);
  values.push_back(record.varus_rad);
}

StepRecord record_at(const std::vector<double>& values, std::size_t row)
{
  const double* v = values.data() + n_pose_values * row;
  StepRecord record;
  record.status = static_cast<StepStatus>(static_cast<std::int8_t>(v[0]));
  record.pose = {{v[1], v[2], v[3]}, v[4]};
  record.varus_rad = v[5];
  return record;
}

bool is_same_branch(const StepRecord& a, const StepRecord& b)
{
  return (a.pose.translation_mm - b.pose.translation_mm).norm() <= same_branch_mm &&
         std::abs(a.pose.theta_rad - b.pose.theta_rad) <= same_branch_rad &&
         std::abs(a.varus_rad - b.varus_rad) <= same_branch_rad;
}

}  // namespace

ModelEvaluation::ModelEvaluation(const FitData& data, const IdentifyPlan& plan) : data_(data), plan_(plan)
{
  if (data.motion != nullptr) joint_ = solve::joint_of(*data.motion, data.motion->frame);
  for (const Evaluation& known : plan.known) known_.emplace(Key{known.kind, known.at}, known.values);
  add_rows();
  if (data.motion == nullptr) return;
  std::vector<double> flexions_rad;
  for (const double flexion_deg : data.motion->grid.flexion_deg)
    flexions_rad.push_back(rad_from_deg(flexion_deg));
  is_needed_.assign(flexions_rad.size(), false);
  for (const Row& row : rows_) {
    if (row.trial == data.trials.size()) continue;
    const double at_rad = data.trials[row.trial].rows[row.row].value[analysis::at_flexion];
    // At a flexion of the grid, rounding of the solved poses decides which neighbour is interpolated.
    for (const double near_rad : {at_rad - rounding_rad, at_rad + rounding_rad}) {
      const auto after =
          std::lower_bound(flexions_rad.begin(), flexions_rad.end(), near_rad) - flexions_rad.begin();
      const std::size_t high = std::min(static_cast<std::size_t>(after), flexions_rad.size() - 1);
      is_needed_[high] = is_needed_[high > 0 ? high - 1 : 0] = true;
    }
  }
}

void ModelEvaluation::add_rows()
{
  const double independent_rad = rad_from_deg(plan_.fit.independent_deg);
  for (std::size_t t = 0; t < data_.trials.size(); ++t) {
    const std::vector<analysis::Row>& rows = data_.trials[t].rows;
    for (std::size_t r = 0; r < rows.size(); ++r) {
      if (!rows[r].missing.empty()) continue;
      const auto n_near = std::count_if(rows.begin(), rows.end(), [&](const analysis::Row& other) {
        return other.missing.empty() && std::abs(other.value[analysis::at_flexion] -
                                                 rows[r].value[analysis::at_flexion]) <= 0.5 * independent_rad;
      });
      for (std::size_t c = 1; c < analysis::n_scored; ++c) {
        if (rows[r].is_determined[c] && std::isfinite(plan_.fit.noise[c]))
          rows_.push_back({t, r, c, 1.0 / static_cast<double>(n_near), plan_.fit.noise[c]});
      }
    }
  }
  for (std::size_t r = 0; r < data_.laxities.size(); ++r) {
    const analysis::PublishedValue& row = data_.laxities[r];
    double noise = row.sd;
    for (std::size_t k = 0; k < analysis::n_laxity_tests && std::isnan(noise); ++k) {
      const analysis::TestKind& kind = analysis::kind_of(static_cast<analysis::LaxityTest>(k));
      if (row.test == kind.name || row.test == kind.both)
        noise = analysis::in_file_unit(kind, plan_.fit.noise[static_cast<std::size_t>(kind.coordinate)]);
    }
    if (std::isfinite(noise)) rows_.push_back({data_.trials.size(), r, 0, 1.0, noise});
  }
}

Eigen::VectorXd ModelEvaluation::change(const Eigen::VectorXd& x) const
{
  Eigen::VectorXd changes = x;
  for (Eigen::Index k = 0; k < x.size(); ++k) changes(k) *= plan_.unknowns[static_cast<std::size_t>(k)].sd;
  return changes;
}

std::vector<double> ModelEvaluation::recalled(const Key& key,
                                              const std::function<std::vector<double>()>& compute)
{
  {
    const std::scoped_lock lock(mutex_);
    const auto found = known_.find(key);
    if (found != known_.end()) return found->second;
  }
  if (is_stopped()) return {};
  const std::vector<double> values = compute();
  if (is_stopped()) return {};
  const std::scoped_lock lock(mutex_);
  // Another fit may have solved the same meanwhile, with the same result.
  if (known_.emplace(key, values).second && plan_.keep) plan_.keep({key.first, key.second, values});
  if (plan_.on_progress) plan_.on_progress();
  return values;
}

std::vector<double> ModelEvaluation::spine_poses(const Eigen::VectorXd& x)
{
  return recalled({whole_spine, numbers_of(x)}, [&] {
    const job::Case changed = changed_case(*data_.motion, plan_.unknowns, change(x));
    solve::SweepPlan plan = solve::plan_of(changed);
    plan.has_band = false;
    solve::CaseSolver solver(changed, 1);
    solve::SweepHooks hooks;
    hooks.is_stopped = plan_.is_stopped;
    const solve::SweepResult swept = solve::sweep(
        plan, [&](const solve::StepTask& task) { return solver(task); }, hooks, 1);
    std::vector<double> values;
    for (const solve::FreeSpineStep& step : swept.free_spine) append_pose(values, step.chosen);
    return values;
  });
}

std::vector<double> ModelEvaluation::near_poses(const Eigen::VectorXd& base, const Eigen::VectorXd& x)
{
  const std::vector<double> from = spine_poses(base);
  return recalled({near_spine, joined(base, x)}, [&] {
    const job::Case& job_case = *data_.motion;
    const Eigen::VectorXd changes = change(x);
    const model::Ligaments ligaments =
        model::solver_ligaments(changed_ligaments(job_case, plan_.unknowns, changes), job_case.frame);
    solve::EquilibriumSolver solver(joint_, ligaments, job_case.equilibrium);
    std::vector<double> values;
    for (std::size_t k = 0; k < job_case.push.size() && !from.empty(); ++k) {
      const StepRecord seed = record_at(from, k);
      job::Push push = job_case.push[k];
      const double flexion_rad = rad_from_deg(job_case.grid.flexion_deg[k]);
      const LoadChange by = load_change_at(plan_.unknowns, changes, flexion_rad);
      push.force_n += by.force_n;
      push.moment_nmm += by.moment_nmm;
      push.varus_moment_nmm += by.varus_moment_nmm;
      solve::EquilibriumSolver::Task task;
      task.attitude = {flexion_rad, seed.varus_rad};
      task.seed = seed.pose;
      task.loads = solve::loads_of(job_case, push);
      task.is_varus_free = true;
      task.is_measured = false;
      StepRecord record = seed;
      if (!is_needed_[k]) record.status = StepStatus::pending;
      if (record.status == StepStatus::stable) record = solver.solve(task);
      if (record.status == StepStatus::stable && !is_same_branch(seed, record))
        record.status = StepStatus::iteration_limit;
      append_pose(values, record);
    }
    return values;
  });
}

std::vector<double> ModelEvaluation::solved_laxities(const Eigen::VectorXd& x,
                                                     const std::vector<StepRecord>& unloaded)
{
  analysis::LaxityPlan plan;
  plan.loads = data_.loads;
  plan.unloaded = unloaded;
  plan.is_stopped = plan_.is_stopped;
  const job::Case changed = changed_case(*data_.laxity, plan_.unknowns, change(x));
  const analysis::LaxityResult result = analysis::laxity_of(changed, plan);
  std::vector<double> values;
  for (const analysis::Compared& row : analysis::compared(result, data_.laxities)) values.push_back(row.found);
  for (const StepRecord& record : result.unloaded) append_pose(values, record);
  return values;
}

// Of each row, then the unloaded poses.
std::vector<double> ModelEvaluation::laxity_values(const Eigen::VectorXd& x)
{
  return recalled({whole_laxity, numbers_of(x)}, [&] { return solved_laxities(x, {}); });
}

std::vector<double> ModelEvaluation::near_laxity_values(const Eigen::VectorXd& base, const Eigen::VectorXd& x)
{
  const std::vector<double> from = laxity_values(base);
  return recalled({near_laxity, joined(base, x)}, [&] {
    if (from.empty()) return std::vector<double>{};
    const std::vector<double> poses(from.begin() + static_cast<std::ptrdiff_t>(data_.laxities.size()),
                                    from.end());
    std::vector<StepRecord> unloaded;
    for (std::size_t k = 0; k < data_.loads.flexion_deg.size(); ++k) unloaded.push_back(record_at(poses, k));
    return solved_laxities(x, unloaded);
  });
}

Residuals ModelEvaluation::residuals(const std::vector<double>& poses,
                                     const std::vector<double>& laxities) const
{
  Residuals all = Residuals::Constant(static_cast<Eigen::Index>(rows_.size()), nan);
  std::vector<std::vector<analysis::Row>> found;
  if (data_.motion != nullptr && !poses.empty()) {
    const job::Case& job_case = *data_.motion;
    std::vector<Pose> X;
    for (std::size_t k = 0; k < job_case.grid.flexion_deg.size(); ++k) {
      const StepRecord record = record_at(poses, k);
      X.push_back(X_reference_moving(
          job_case.frame, {rad_from_deg(job_case.grid.flexion_deg[k]), record.varus_rad}, record.pose));
    }
    analysis::Sequence model =
        analysis::sequence_of(job_case.title, "flexion_deg", job_case.grid.flexion_deg, X, data_.convention);
    for (std::size_t k = 0; k < model.rows.size(); ++k) {
      const StepStatus status = record_at(poses, k).status;
      if (status != StepStatus::stable) model.rows[k].missing = name_of(status);
    }
    for (const analysis::Sequence& trial : data_.trials)
      found.push_back(analysis::rows_over_flexion(model, trial, true));
  }
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    const Row& row = rows_[k];
    double difference = nan;
    if (row.trial == data_.trials.size()) {
      if (!laxities.empty()) difference = laxities[row.row] - data_.laxities[row.row].value;
    } else if (!found.empty() && found[row.trial][row.row].missing.empty()) {
      difference = found[row.trial][row.row].value[row.coordinate] -
                   data_.trials[row.trial].rows[row.row].value[row.coordinate];
    }
    all(static_cast<Eigen::Index>(k)) = difference / row.noise;
  }
  return all;
}

Residuals ModelEvaluation::at(const Eigen::VectorXd& x)
{
  return residuals(data_.motion == nullptr ? std::vector<double>{} : spine_poses(x),
                   data_.laxity == nullptr ? std::vector<double>{} : laxity_values(x));
}

Residuals ModelEvaluation::near(const Eigen::VectorXd& base, const Eigen::VectorXd& x)
{
  return residuals(data_.motion == nullptr ? std::vector<double>{} : near_poses(base, x),
                   data_.laxity == nullptr ? std::vector<double>{} : near_laxity_values(base, x));
}

std::vector<double> ModelEvaluation::laxities_at(const Eigen::VectorXd& x)
{
  std::vector<double> values;
  if (data_.laxity != nullptr) values = laxity_values(x);
  values.resize(data_.laxities.size(), nan);
  return values;
}

Eigen::MatrixXd ModelEvaluation::derivatives(const Eigen::VectorXd& x, double length)
{
  const Residuals middle = near(x, x);
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(middle.size(), x.size());
  for (Eigen::Index c = 0; c < x.size(); ++c) {
    const Unknown& unknown = plan_.unknowns[static_cast<std::size_t>(c)];
    Eigen::VectorXd low = x, high = x;
    low(c) = std::max(unknown.from / unknown.sd, x(c) - length);
    high(c) = std::min(unknown.to / unknown.sd, x(c) + length);
    const Residuals below = near(x, low), above = near(x, high);
    for (Eigen::Index r = 0; r < middle.size(); ++r) {
      // One side where the other has no pose nearby.
      const bool has_low = std::isfinite(below(r)), has_high = std::isfinite(above(r));
      const double from = has_low ? below(r) : middle(r), to = has_high ? above(r) : middle(r);
      const double step = (has_high ? high(c) : x(c)) - (has_low ? low(c) : x(c));
      if (step > 0.0 && std::isfinite(from) && std::isfinite(to)) J(r, c) = (to - from) / step;
    }
  }
  return J;
}

}  // namespace vrda::analysis
