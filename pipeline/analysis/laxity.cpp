#include "analysis/laxity.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/document.hpp"
#include "core/fields_json.hpp"
#include "core/parallel.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "job/ligament_files.hpp"
#include "solve/case_solver.hpp"
#include "solve/potential.hpp"

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

std::vector<LaxityTest> tests_of(const job::LaxityJob& loads)
{
  std::vector<LaxityTest> tests;
  for (std::size_t k = 0; k < n_laxity_tests; ++k) {
    const auto test = static_cast<LaxityTest>(k);
    if (whole_load(loads, test) > 0.0) tests.push_back(test);
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
std::vector<TensionLine> tensions_of(const model::Ligaments& ligaments, const solve::SolverPosition& at)
{
  const std::vector<model::FibreState> states = model::fibre_states(ligaments, at.attitude, at.pose);
  const model::JointPlacement placement = model::joint_placement(at.attitude, at.pose);
  std::vector<TensionLine> lines;
  for (std::size_t k = 0; k < states.size(); ++k) {
    if (!(states[k].force_n > 0.0)) continue;
    const model::FibrePath path = model::fibre_path(ligaments.fibres[k], ligaments.wraps, placement);
    const bool is_moving_end = path.end_body == BodyIndex::moving;
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
      throw InputError({job_case.title, "laxity.cut." + std::to_string(k) + ".bundles", '"' + bundle + '"',
                        "a bundle of the fibres: " + joined(known)});
    }
  }
}

/// Joint, fibres and unloaded equilibria of one state.
struct State {
  model::Ligaments ligaments;             ///< in S
  model::Ligaments cut;                   ///< the fibres that it lacks
  std::vector<model::Ligaments> bundles;  ///< its fibres by bundle, in the order of `bundles_of`
  std::vector<StepRecord> unloaded;       ///< [n_flexion]
};

class LaxityRun {
 public:
  LaxityRun(const job::Case& job_case, const LaxityPlan& plan)
      : case_(job_case),
        plan_(plan),
        tests_(tests_of(plan.loads)),
        joint_(plan.joint ? plan.joint
                          : std::make_shared<const solve::Joint>(solve::joint_of(job_case, job_case.frame))),
        map_(job_case.frame),
        bundles_(bundles_of(job_case.ligaments)),
        equilibrium_(job_case.equilibrium)
  {
    // Of exact contact: poses moved out of an overlap are not those that the loads balance.
    equilibrium_.contact_stiffness_n_per_mm3 = 0.0;
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
    plan.follow = nullptr;
    plan.prior.clear();  // the laxity of the bones and fibres alone
    of_state.equilibrium = equilibrium_;
    solve::CaseSolver solver(of_state, plan_.n_threads, joint_);
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
    solve::EquilibriumSolver solver(*joint_, state.ligaments, equilibrium_);
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
    solve::EquilibriumSolver solver(*joint_, state.ligaments, equilibrium_);
    StepRecord unloaded = state.unloaded[curve.flexion];
    StepRecord last = unloaded;
    curve.poses.push_back(loaded_pose(curve, 0.0, unloaded));
    const double whole = whole_load(plan_.loads, curve.test);
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

  solve::SolverPosition position_of(const LaxityCurve& curve, const StepRecord& record) const
  {
    return {{rad_from_deg(plan_.loads.flexion_deg[curve.flexion]), record.varus_rad}, record.pose};
  }

  StepRecord solve(solve::EquilibriumSolver& solver, const LaxityCurve& curve,
                   const solve::SolverPosition& seed, double load,
                   const std::vector<TensionLine>& lines) const
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
    const solve::SolverPosition from = position_of(curve, unloaded), to = position_of(curve, last);
    for (std::size_t k = 0; k < bundles_.size(); ++k) {
      // The energy's gradient is the force that the fibres exert against the coordinate.
      const auto against = [&](const solve::SolverPosition& at) {
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
    const solve::SolverPosition at = map_.position_at(whole.poses.back().coordinates);
    const StepRecord record = solve(solver, curve, at, whole.poses.back().load, tensions_of(state.cut, at));
    if (record.status != StepStatus::stable) return;
    curve.replaced_mm = (record.pose.translation_mm - at.pose.translation_mm).norm();
    curve.replaced_rad = std::max(std::abs(record.pose.theta_rad - at.pose.theta_rad),
                                  std::abs(record.varus_rad - at.attitude.varus_rad));
  }

  const job::Case& case_;
  const LaxityPlan& plan_;
  std::vector<LaxityTest> tests_;
  std::shared_ptr<const solve::Joint> joint_;
  solve::JointMap map_;
  std::vector<std::string> bundles_;
  EquilibriumOptions equilibrium_;
  std::vector<State> states_;
  LaxityResult result_;
};

}  // namespace

const TestKind& kind_of(LaxityTest test)
{
  return kinds[static_cast<std::size_t>(test)];
}

double whole_load(const job::LaxityJob& loads, LaxityTest test)
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

namespace {

constexpr std::size_t most_rows = 100000;

enum Field : std::size_t { f_test, f_flexion, f_value, f_load, f_sd, f_source, f_state, n_fields };
constexpr const char* field_names[] = {"test", "flexion_deg", "value", "load", "sd", "source", "state",
                                       // Further columns of laxity.csv, not read.
                                       "load_unit", "unit", "position", "change_by_cut", "status"};

std::vector<std::string> test_names()
{
  std::vector<std::string> names;
  for (std::size_t k = 0; k < n_laxity_tests; ++k) {
    const TestKind& kind = kind_of(static_cast<LaxityTest>(k));
    names.emplace_back(kind.name);
    if (k % 2 == 1) names.emplace_back(kind.both);
  }
  return names;
}

double number_of(const job::CsvTable& table, const job::TableLine& line, Field field, std::string_view text)
{
  const std::optional<double> number = job::parse_real(text);
  if (!number || !std::isfinite(*number)) table.refuse_number(line, field_names[field], text);
  return *number;
}

// Nothing for a row of a cut, or one without a value.
std::optional<PublishedValue> value_of(const job::CsvTable& table, const job::TableLine& line,
                                       const std::vector<Field>& columns)
{
  PublishedValue row;
  bool is_whole = true;
  const std::vector<std::string_view> texts = table.fields(line);
  for (std::size_t k = 0; k < texts.size(); ++k) {
    const Field field = columns[k];
    const std::string text(texts[k]);
    if (field == f_test) {
      row.test = text;
      if (!is_test_name(text)) table.refuse(line, "test", '"' + text + '"', join_alternatives(test_names()));
    } else if (field == f_source) {
      row.source = text;
    } else if (field == f_state) {
      is_whole = text.empty() || text == whole_state;
    } else if (field >= n_fields) {
      continue;
    } else if (field == f_value && text.empty()) {
      row.value = nan;
    } else if (!text.empty() || field == f_flexion) {
      const double number = number_of(table, line, field, text);
      if (field == f_flexion) row.flexion_deg = number;
      if (field == f_value) row.value = number;
      if (field == f_load) row.load = number;
      if (field == f_sd) row.sd = number;
      if ((field == f_load || field == f_sd) && !(number > 0.0))
        table.refuse(line, field_names[field], text, "a number above 0");
    }
  }
  if (!is_whole || std::isnan(row.value)) return std::nullopt;
  return row;
}

// Of one direction at a flexion row.
double at_row(const LaxityResult& result, LaxityTest test, std::size_t flexion, double load)
{
  for (const LaxityCurve& curve : result.curves) {
    if (curve.state != 0 || curve.test != test || curve.flexion != flexion) continue;
    return in_file_unit(kind_of(test), std::isnan(load) ? curve.laxity() : laxity_at_load(curve, load));
  }
  return nan;
}

// Linear between the flexions of the job.
double at_flexion(const LaxityResult& result, LaxityTest test, const PublishedValue& row)
{
  const std::vector<double>& flexions = result.loads.flexion_deg;
  for (std::size_t k = 0; k < flexions.size(); ++k) {
    if (row.flexion_deg == flexions[k]) return at_row(result, test, k, row.load);
    if (k + 1 == flexions.size() || row.flexion_deg < flexions[k] || row.flexion_deg > flexions[k + 1])
      continue;
    const double share = (row.flexion_deg - flexions[k]) / (flexions[k + 1] - flexions[k]);
    return (1.0 - share) * at_row(result, test, k, row.load) + share * at_row(result, test, k + 1, row.load);
  }
  return nan;
}

}  // namespace

bool is_test_name(const std::string& name)
{
  const std::vector<std::string> names = test_names();
  return std::find(names.begin(), names.end(), name) != names.end();
}

double in_file_unit(const TestKind& kind, double value)
{
  return kind.is_force() ? value : deg_from_rad(value);
}

std::vector<PublishedValue> published_values(const std::string& file, std::string_view text)
{
  const job::CsvTable table(file, text, {"value", "values", "values"});
  const std::vector<std::string> known(std::begin(field_names), std::end(field_names));
  std::vector<Field> columns;
  for (const std::string_view name : table.columns()) {
    const auto at = std::find(known.begin(), known.end(), name);
    if (at == known.end())
      table.refuse_unknown_column(name, known, "test, flexion_deg, value, load, sd, source");
    columns.push_back(static_cast<Field>(at - known.begin()));
    if (std::count(columns.begin(), columns.end(), columns.back()) > 1)
      table.refuse(table.header(), std::string(name), "the column twice", "each column once");
  }
  for (const Field needed : {f_test, f_flexion, f_value}) {
    if (std::find(columns.begin(), columns.end(), needed) == columns.end())
      table.refuse(table.header(), field_names[needed], "no such column", "this column");
  }
  table.require_rows(most_rows);
  std::vector<PublishedValue> rows;
  for (std::size_t k = 0; k < table.n_rows(); ++k) {
    if (const std::optional<PublishedValue> row = value_of(table, table.row(k), columns))
      rows.push_back(*row);
  }
  return rows;
}

std::vector<Compared> compared(const LaxityResult& result, const std::vector<PublishedValue>& published)
{
  std::vector<Compared> all;
  for (const PublishedValue& row : published) {
    Compared one{row, 0.0, {}};
    for (std::size_t k = 0; k < n_laxity_tests; ++k) {
      const auto test = static_cast<LaxityTest>(k);
      if (row.test == kind_of(test).name || row.test == kind_of(test).both)
        one.found += at_flexion(result, test, row);
    }
    if (std::isnan(one.found))
      one.missing = "not among the tests, flexions and loads of the job, or not solved";
    all.push_back(one);
  }
  return all;
}

namespace {

using Json = nlohmann::ordered_json;

Json coordinates_json(const JointCoordinates& coordinates)
{
  Json json = Json::object();
  for (std::size_t k = 0; k < n_joint_coordinates; ++k) {
    json[std::string(joint_coordinate_names[k]) + unit_suffix(k)] =
        core::json_value(coordinates(static_cast<Eigen::Index>(k)), is_rotation(k) ? unit::radian : unit::mm);
  }
  return json;
}

Json resistance_json(const BundleResistance& of)
{
  return {{"name", of.bundle}, {"force", core::json_value(of.force)}, {"share", core::json_value(of.share)}};
}

Json curve_json(const LaxityDocument& document, const LaxityCurve& curve)
{
  const TestKind& kind = kind_of(curve.test);
  Json poses = Json::array(), bundles = Json::array();
  for (const LoadedPose& pose : curve.poses)
    poses.push_back({{"load", pose.load},
                     {"status", name_of(pose.status)},
                     {"coordinates", coordinates_json(pose.coordinates)}});
  for (const BundleResistance& bundle : curve.bundles) bundles.push_back(resistance_json(bundle));
  Json json = {{"state", document.result.states[curve.state]},
               {"flexion_deg", document.result.loads.flexion_deg[curve.flexion]},
               {"test", kind.name},
               {"load_unit", kind.is_force() ? "N" : "N mm"},
               {"unit", kind.is_force() ? "mm" : "degree"},
               {"laxity", core::json_value(in_file_unit(kind, curve.laxity()))},
               {"poses", poses},
               {"bundles", bundles},
               {"contact", resistance_json(curve.contact)}};
  if (curve.state > 0)
    json["replaced"] = {{"distance_mm", core::json_value(curve.replaced_mm)},
                        {"angle_deg", core::json_value(deg_from_rad(curve.replaced_rad))}};
  return json;
}

Json compared_json(const Compared& one)
{
  const PublishedValue& row = one.published;
  return {{"test", row.test},
          {"flexion_deg", row.flexion_deg},
          {"load", core::json_value(row.load)},
          {"value", row.value},
          {"sd", core::json_value(row.sd)},
          {"source", row.source},
          {"found", core::json_value(one.found)},
          {"difference", core::json_value(one.difference())},
          {"missing", one.missing}};
}

}  // namespace

const LaxityCurve* curve_of(const LaxityResult& result, std::size_t state, std::size_t flexion,
                            LaxityTest test)
{
  for (const LaxityCurve& curve : result.curves) {
    if (curve.state == state && curve.flexion == flexion && curve.test == test) return &curve;
  }
  return nullptr;
}

std::string laxity_json(const LaxityDocument& document)
{
  Json inputs = Json::array(), curves = Json::array(), compared = Json::array();
  for (const job::LoadedInput& input : document.inputs)
    inputs.push_back({{"name", input.name}, {"sha256", input.sha256}});
  for (const LaxityCurve& curve : document.result.curves) curves.push_back(curve_json(document, curve));
  for (const Compared& one : document.compared) compared.push_back(compared_json(one));
  const job::LaxityJob& loads = document.result.loads;
  const Json json = {{"format", "vrda laxity"},
                     {"version", 1},
                     {"program", document.program},
                     {"solver", document.solver},
                     {"title", document.title},
                     {"joint", document.joint},
                     {"side", document.side},
                     {"job", document.job},
                     {"inputs", inputs},
                     {"flexion_deg", loads.flexion_deg},
                     {"states", document.result.states},
                     {"curves", curves},
                     {"published", compared}};
  return core::json_text(json, 1) + '\n';
}

std::string laxity_csv(const LaxityDocument& document)
{
  const LaxityResult& result = document.result;
  std::string csv = "state,test,flexion_deg,load,load_unit,value,unit,position,change_by_cut,status\n";
  for (const LaxityCurve& curve : result.curves) {
    const TestKind& kind = kind_of(curve.test);
    const LaxityCurve* whole = curve_of(result, 0, curve.flexion, curve.test);
    const std::string at = csv_field(result.states[curve.state]) + ',';
    const std::string flexion = shortest_decimal(result.loads.flexion_deg[curve.flexion]) + ',';
    const std::string load = shortest_decimal(curve.poses.back().load) + (kind.is_force() ? ",N," : ",N mm,");
    const std::string unit = kind.is_force() ? ",mm," : ",degree,";
    csv += at + kind.name + ',' + flexion + load + csv_number(in_file_unit(kind, curve.laxity())) + unit +
           csv_number(in_file_unit(kind, curve.position())) + ',' +
           (curve.state == 0 ? "" : csv_number(in_file_unit(kind, curve.position() - whole->position()))) +
           ',' + name_of(curve.poses.back().status) + '\n';
    if (static_cast<std::size_t>(curve.test) % 2 == 0) continue;
    // Both directions together, after the second.
    const auto first = static_cast<LaxityTest>(static_cast<std::size_t>(curve.test) - 1);
    const LaxityCurve* other = curve_of(result, curve.state, curve.flexion, first);
    csv += at + kind.both + ',' + flexion + load +
           csv_number(in_file_unit(kind, curve.laxity() + other->laxity())) + unit + ",," +
           (curve.is_complete() ? name_of(other->poses.back().status) : name_of(curve.poses.back().status)) +
           '\n';
  }
  return csv;
}

std::string share_csv(const LaxityDocument& document)
{
  const LaxityResult& result = document.result;
  std::string csv = "state,test,flexion_deg,bundle,force,force_unit,share\n";
  for (const LaxityCurve& curve : result.curves) {
    const TestKind& kind = kind_of(curve.test);
    std::vector<BundleResistance> rows = curve.bundles;
    if (curve.is_complete()) rows.push_back(curve.contact);
    for (const BundleResistance& row : rows)
      csv += csv_field(result.states[curve.state]) + ',' + kind.name + ',' +
             shortest_decimal(result.loads.flexion_deg[curve.flexion]) + ',' + csv_field(row.bundle) + ',' +
             csv_number(row.force) + (kind.is_force() ? ",N," : ",N mm,") + csv_number(row.share) + '\n';
  }
  return csv;
}

}  // namespace vrda::analysis
