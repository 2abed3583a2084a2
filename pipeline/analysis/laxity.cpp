#include "analysis/laxity.hpp"

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "core/parallel.hpp"
#include "solve/case_solver.hpp"
#include "solve/joint_map.hpp"

namespace vrda::analysis {
namespace {

constexpr TestKind kinds[] = {
    {"anterior", "anterior-posterior", JointCoordinate::anterior, 1.0},
    {"posterior", "anterior-posterior", JointCoordinate::anterior, -1.0},
    {"internal", "internal-external", JointCoordinate::internal, 1.0},
    {"external", "internal-external", JointCoordinate::internal, -1.0},
    {"varus", "varus-valgus", JointCoordinate::varus, 1.0},
    {"valgus", "varus-valgus", JointCoordinate::varus, -1.0},
};

// A step of the load is halved at most this many times: a thirty-second of it is below the noise of any test.
constexpr int most_halvings = 5;

double load_of(const job::LaxityJob& loads, LaxityTest test)
{
  switch (kind_of(test).coordinate) {
    case JointCoordinate::anterior:
      return loads.anterior_force_n;
    case JointCoordinate::internal:
      return loads.internal_moment_nmm;
    default:
      return loads.varus_moment_nmm;
  }
}

std::vector<LaxityTest> tests_of(const job::LaxityJob& loads)
{
  std::vector<LaxityTest> tests;
  for (std::size_t k = 0; k < n_laxity_tests; ++k) {
    const auto test = static_cast<LaxityTest>(k);
    if (load_of(loads, test) > 0.0) tests.push_back(test);
  }
  return tests;
}

// Of the five coordinates of an equilibrium. Delta is +Y, so anterior is X of S on both sides.
Coordinate solver_coordinate(JointCoordinate coordinate)
{
  switch (coordinate) {
    case JointCoordinate::anterior:
      return along_x;
    case JointCoordinate::internal:
      return about_y;
    default:
      return about_varus;
  }
}

Loads with_load(Loads loads, LaxityTest test, double load)
{
  const double signed_load = kind_of(test).sign * load;
  switch (kind_of(test).coordinate) {
    case JointCoordinate::anterior: {
      // At the rotation centre's point, wherever the push acts: the moment of the offset is subtracted.
      const Eigen::Vector3d force_n(signed_load, 0.0, 0.0);
      const Eigen::Vector3d turning_nmm = loads.point_mm.cross(force_n);
      loads.force_n += force_n;
      loads.moment_nmm -= turning_nmm.y();
      loads.varus_moment_nmm -= turning_nmm.x();
      break;
    }
    case JointCoordinate::internal:
      loads.moment_nmm += signed_load;
      break;
    default:
      loads.varus_moment_nmm += signed_load;
  }
  return loads;
}

// Each fibre's tension as a line that pulls along its free segment.
std::vector<TensionLine> tensions_of(const model::Ligaments& ligaments, const SolverPosition& at)
{
  const std::vector<model::FibreState> states = model::fibre_states(ligaments, at.attitude, at.pose);
  const model::JointPlacement placement = model::joint_placement(at.attitude, at.pose);
  std::vector<TensionLine> lines;
  for (std::size_t k = 0; k < states.size(); ++k) {
    if (!(states[k].force_n > 0.0)) continue;
    const model::FibrePath path = model::fibre_path(ligaments.fibres[k], ligaments.wraps, placement);
    const bool is_moving_end = path.end_body == model::WrapBody::moving;
    const Eigen::Vector3d along_mm = path.length_mm * path.direction;
    const Eigen::Vector3d reference_mm = is_moving_end ? path.end_mm - along_mm : path.end_mm;
    const Eigen::Vector3d moving_mm = is_moving_end ? path.end_mm : path.end_mm + along_mm;
    lines.push_back({states[k].force_n, placement.R_S_reference.transpose() * reference_mm,
                     placement.R_S_moving.transpose() * (moving_mm - placement.t_S_moving_mm)});
  }
  return lines;
}

// Generalised force of the contacts along a coordinate.
double contact_force(const StepRecord& record, Coordinate coordinate)
{
  double force = 0.0;
  for (const ContactForce& contact : record.balance.forces) {
    const Eigen::Vector3d force_n =
        contact.along_delta_n / -contact.normal_solver.y() * contact.normal_solver;
    force += point_jacobian(contact.point_solver_mm, record.pose).col(coordinate).dot(force_n);
  }
  return force;
}

bool is_of(const job::LaxityJob::Cut& cut, const model::Fibre& fibre)
{
  return std::find(cut.bundles.begin(), cut.bundles.end(), fibre.bundle) != cut.bundles.end();
}

/// The fibres for which `is_kept` holds.
template <typename Keep>
model::Ligaments part_of(const model::Ligaments& all, const Keep& is_kept)
{
  model::Ligaments part = all;
  std::erase_if(part.fibres, [&](const model::Fibre& fibre) { return !is_kept(fibre); });
  return part;
}

std::vector<std::string> bundles_of(const model::Ligaments& ligaments)
{
  std::vector<std::string> names;
  for (const model::Fibre& fibre : ligaments.fibres) {
    if (std::find(names.begin(), names.end(), fibre.bundle) == names.end()) names.push_back(fibre.bundle);
  }
  return names;
}

void require_cuts(const job::Case& job_case, const job::LaxityJob& loads)
{
  const std::vector<std::string> known = bundles_of(job_case.ligaments);
  if (known.empty())
    throw InputError({job_case.title, "ligaments", "no fibre", "fibres, which resist loads"});
  for (std::size_t k = 0; k < loads.cuts.size(); ++k) {
    for (const std::string& bundle : loads.cuts[k].bundles) {
      if (std::find(known.begin(), known.end(), bundle) != known.end()) continue;
      std::string names;
      for (const std::string& name : known) names += (names.empty() ? "" : ", ") + name;
      throw InputError({job_case.title, "laxity.cut." + std::to_string(k) + ".bundles", '"' + bundle + '"',
                        "a bundle of the fibres: " + names});
    }
  }
}

/// Joint, fibres and unloaded equilibria of one state.
struct State {
  model::Ligaments ligaments;             ///< in S
  model::Ligaments cut;                   ///< the fibres that it lacks
  std::vector<model::Ligaments> bundles;  ///< its fibres by bundle, in the order of `bundles_of`
  std::vector<StepRecord> unloaded;          ///< [n_flexion]
};

class LaxityRun {
 public:
  LaxityRun(const job::Case& job_case, const LaxityPlan& plan)
      : case_(job_case),
        plan_(plan),
        tests_(tests_of(plan.loads)),
        joint_(solve::joint_of(job_case, job_case.frame)),
        map_(job_case.frame),
        bundles_(bundles_of(job_case.ligaments))
  {
    result_.loads = plan.loads;
    result_.states.emplace_back(whole_state);
    for (const job::LaxityJob::Cut& cut : plan.loads.cuts) result_.states.push_back(cut.name);
  }

  LaxityResult run()
  {
    result_.curves.resize(n_curves(plan_.loads));
    for (std::size_t k = 0; k < result_.states.size() && !is_stopped(); ++k) states_.push_back(state_at(k));
    if (!states_.empty()) result_.unloaded = states_.front().unloaded;
    const std::size_t n_of_state = plan_.loads.flexion_deg.size() * tests_.size();
    // The cuts need the poses of the intact joint.
    solve_curves(0, n_of_state);
    solve_curves(n_of_state, result_.curves.size());
    if (is_stopped()) result_.curves.clear();
    return std::move(result_);
  }

 private:
  bool is_stopped() const { return plan_.is_stopped && plan_.is_stopped(); }

  State state_at(std::size_t number) const
  {
    job::Case of_state = case_;
    State state;
    if (number > 0) {
      const job::LaxityJob::Cut& cut = plan_.loads.cuts[number - 1];
      of_state.ligaments = part_of(case_.ligaments, [&](const auto& fibre) { return !is_of(cut, fibre); });
      state.cut = model::solver_ligaments(
          part_of(case_.ligaments, [&](const auto& fibre) { return is_of(cut, fibre); }), case_.frame);
    }
    state.ligaments = model::solver_ligaments(of_state.ligaments, case_.frame);
    for (const std::string& bundle : bundles_)
      state.bundles.push_back(
          part_of(state.ligaments, [&](const auto& fibre) { return fibre.bundle == bundle; }));
    if (!plan_.unloaded.empty()) {
      state.unloaded = near_unloaded(state);
      return state;
    }
    solve::SweepPlan plan = solve::plan_of(of_state);
    plan.has_band = false;
    solve::CaseSolver solver(of_state, plan_.n_threads);
    solve::SweepHooks hooks;
    hooks.is_stopped = plan_.is_stopped;
    const solve::SweepResult swept = solve::sweep(
        plan, [&](const solve::StepTask& task) { return solver(task); }, hooks, plan_.n_threads);
    for (const solve::FreeSpineStep& step : swept.free_spine) state.unloaded.push_back(step.chosen);
    return state;
  }

  // From the equilibria of the plan.
  std::vector<StepRecord> near_unloaded(const State& state) const
  {
    solve::EquilibriumSolver solver(joint_, state.ligaments, case_.equilibrium);
    std::vector<StepRecord> records;
    for (std::size_t k = 0; k < plan_.unloaded.size(); ++k) {
      LaxityCurve curve;
      curve.flexion = k;
      const StepRecord& seed = plan_.unloaded[k];
      records.push_back(
          seed.status == StepStatus::stable ? solve(solver, curve, position_of(curve, seed), 0.0, {}) : seed);
    }
    return records;
  }

  // Workers take the curves one by one; each curve is solved by one worker.
  void solve_curves(std::size_t first, std::size_t last)
  {
    for_each_index(last - first, plan_.n_threads, [&] {
      return [&](std::size_t k) {
        if (is_stopped()) return;
        result_.curves[first + k] = curve_at(first + k);
        if (plan_.on_progress) plan_.on_progress();
      };
    });
  }

  LaxityCurve curve_at(std::size_t number) const
  {
    LaxityCurve curve;
    curve.test = tests_[number % tests_.size()];
    const std::size_t row = number / tests_.size();
    curve.flexion = row % plan_.loads.flexion_deg.size();
    curve.state = row / plan_.loads.flexion_deg.size();
    const State& state = states_[curve.state];
    solve::EquilibriumSolver solver(joint_, state.ligaments, case_.equilibrium);
    StepRecord unloaded = state.unloaded[curve.flexion];
    StepRecord last = unloaded;
    curve.poses.push_back(loaded_pose(curve, 0.0, unloaded));
    const double whole = load_of(plan_.loads, curve.test);
    for (int k = 1; k <= plan_.loads.load_steps && curve.is_complete(); ++k) {
      const double load = whole * k / plan_.loads.load_steps;
      last = grown(solver, curve, last, {curve.poses.back().load, load}, 0);
      curve.poses.push_back(loaded_pose(curve, load, last));
    }
    if (!curve.is_complete()) return curve;
    measure_resistance(curve, state, unloaded, last);
    if (curve.state > 0) replace_cut(curve, state, solver);
    return curve;
  }

  struct LoadStep {
    double from, to;
  };

  /// The equilibrium at the end of a step of the load, from that at its start.
  StepRecord grown(solve::EquilibriumSolver& solver, const LaxityCurve& curve, const StepRecord& from,
                   const LoadStep& step, int n_halvings) const
  {
    StepRecord record = solve(solver, curve, position_of(curve, from), step.to, {});
    if (record.status == StepStatus::stable || n_halvings == most_halvings) return record;
    const double middle = 0.5 * (step.from + step.to);
    record = grown(solver, curve, from, {step.from, middle}, n_halvings + 1);
    if (record.status != StepStatus::stable) return record;
    return grown(solver, curve, record, {middle, step.to}, n_halvings + 1);
  }

  SolverPosition position_of(const LaxityCurve& curve, const StepRecord& record) const
  {
    return {{rad_from_deg(plan_.loads.flexion_deg[curve.flexion]), record.varus_rad}, record.pose};
  }

  StepRecord solve(solve::EquilibriumSolver& solver, const LaxityCurve& curve, const SolverPosition& seed,
                   double load, const std::vector<TensionLine>& lines) const
  {
    solve::EquilibriumSolver::Task task;
    task.attitude = seed.attitude;
    task.seed = seed.pose;
    task.loads = with_load(solve::loads_of(case_, case_.push[curve.flexion]), curve.test, load);
    task.loads.lines.insert(task.loads.lines.end(), lines.begin(), lines.end());
    task.is_varus_free = true;
    task.is_measured = false;
    return solver.solve(task);
  }

  LoadedPose loaded_pose(const LaxityCurve& curve, double load, const StepRecord& record) const
  {
    return {load, record.status, map_.coordinates_at(position_of(curve, record))};
  }

  void measure_resistance(LaxityCurve& curve, const State& state, const StepRecord& unloaded,
                          const StepRecord& last) const
  {
    const TestKind& kind = kind_of(curve.test);
    const Coordinate coordinate = solver_coordinate(kind.coordinate);
    const double load = curve.poses.back().load;
    const SolverPosition from = position_of(curve, unloaded), to = position_of(curve, last);
    for (std::size_t k = 0; k < bundles_.size(); ++k) {
      // The energy's gradient is the force that the fibres exert against the coordinate.
      const auto against = [&](const SolverPosition& at) {
        return kind.sign *
               model::ligament_energy(state.bundles[k], at.attitude, at.pose).gradient(coordinate);
      };
      const double force = against(to);
      curve.bundles.push_back({bundles_[k], force, (force - against(from)) / load});
    }
    const double force = -kind.sign * contact_force(last, coordinate);
    curve.contact = {"contact", force, (force + kind.sign * contact_force(unloaded, coordinate)) / load};
  }

  void replace_cut(LaxityCurve& curve, const State& state, solve::EquilibriumSolver& solver) const
  {
    const std::size_t n_of_state = plan_.loads.flexion_deg.size() * tests_.size();
    const LaxityCurve& whole =
        result_.curves[(curve.flexion * tests_.size() +
                        static_cast<std::size_t>(std::find(tests_.begin(), tests_.end(), curve.test) -
                                                 tests_.begin())) %
                       n_of_state];
    if (!whole.is_complete()) return;
    const SolverPosition at = map_.position_at(whole.poses.back().coordinates);
    const StepRecord record = solve(solver, curve, at, whole.poses.back().load, tensions_of(state.cut, at));
    if (record.status != StepStatus::stable) return;
    curve.replaced_mm = (record.pose.translation_mm - at.pose.translation_mm).norm();
    curve.replaced_rad = std::max(std::abs(record.pose.theta_rad - at.pose.theta_rad),
                                  std::abs(record.varus_rad - at.attitude.varus_rad));
  }

  const job::Case& case_;
  const LaxityPlan& plan_;
  std::vector<LaxityTest> tests_;
  solve::Joint joint_;
  solve::JointMap map_;
  std::vector<std::string> bundles_;
  std::vector<State> states_;
  LaxityResult result_;
};

}  // namespace

const TestKind& kind_of(LaxityTest test)
{
  return kinds[static_cast<std::size_t>(test)];
}

double LaxityCurve::position() const
{
  const TestKind& kind = kind_of(test);
  return is_complete() ? kind.sign * poses.back().coordinates(row_of(kind.coordinate)) : nan;
}

double LaxityCurve::laxity() const
{
  const TestKind& kind = kind_of(test);
  return is_complete() ? position() - kind.sign * poses.front().coordinates(row_of(kind.coordinate)) : nan;
}

std::size_t n_curves(const job::LaxityJob& loads)
{
  return (1 + loads.cuts.size()) * loads.flexion_deg.size() * tests_of(loads).size();
}

LaxityResult laxity_of(const job::Case& job_case, const LaxityPlan& plan)
{
  require_cuts(job_case, plan.loads);
  check(job_case.push.size() == plan.loads.flexion_deg.size(), "laxity: the case has the plan's flexions");
  return LaxityRun(job_case, plan).run();
}

double laxity_at_load(const LaxityCurve& curve, double load)
{
  const TestKind& kind = kind_of(curve.test);
  const auto moved = [&](std::size_t k) {
    return kind.sign * (curve.poses[k].coordinates(row_of(kind.coordinate)) -
                        curve.poses.front().coordinates(row_of(kind.coordinate)));
  };
  for (std::size_t k = 0; k + 1 < curve.poses.size(); ++k) {
    if (curve.poses[k].status != StepStatus::stable || curve.poses[k + 1].status != StepStatus::stable) break;
    const double from = curve.poses[k].load, to = curve.poses[k + 1].load;
    if (load >= from && load <= to) return moved(k) + (load - from) / (to - from) * (moved(k + 1) - moved(k));
  }
  return nan;
}

}  // namespace vrda::analysis
