#include "prepare/slack_lengths.hpp"

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "solve/case_solver.hpp"
#include "geometry/gap_query.hpp"

namespace vrda::prepare {
namespace {

constexpr double eminence_half_width_mm = 6.0;
constexpr double largest_varus_rad = rad_from_deg(12.0);

}  // namespace

geometry::GapTree plateau_tree(const Mesh& tibia, double side)
{
  std::vector<std::int32_t> rows;
  for (Eigen::Index t = 0; t < tibia.triangles.rows(); ++t) {
    const auto [a, b, c] = corners(tibia, t);
    if (side * (a + b + c).z() / 3.0 > eminence_half_width_mm) rows.push_back(static_cast<std::int32_t>(t));
  }
  return {tibia, rows};
}

SettledPose settled_pose(const job::Case& joint)
{
  const solve::Joint bodies = solve::joint_of(joint, joint.frame);
  const Mesh& moving = bodies.moving.tree_mesh.mesh;
  const geometry::GapTree medial_tree = plateau_tree(moving, -1.0), lateral_tree = plateau_tree(moving, 1.0);
  SettledPose settled;
  if (medial_tree.is_empty() || lateral_tree.is_empty()) return settled;
  geometry::GapQuery medial(bodies.reference_gap, medial_tree), lateral(bodies.reference_gap, lateral_tree);
  // Adduction closes the medial side: the difference falls with varus.
  const auto medial_excess_mm = [&](double varus_rad) {
    medial.set_attitude({0.0, varus_rad});
    lateral.set_attitude({0.0, varus_rad});
    return medial.travel_mm({}) - lateral.travel_mm({});
  };
  double low = -largest_varus_rad, high = largest_varus_rad;
  const double at_low = medial_excess_mm(low), at_high = medial_excess_mm(high);
  if (!std::isfinite(at_low) || !std::isfinite(at_high)) return settled;
  const bool falls = at_low > at_high;
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (low + high);
    ((medial_excess_mm(middle) > 0.0) == falls ? low : high) = middle;
  }
  settled.attitude.varus_rad = 0.5 * (low + high);
  medial_excess_mm(settled.attitude.varus_rad);
  settled.pose.translation_mm.y() = std::min(medial.travel_mm({}), lateral.travel_mm({}));
  settled.has_contact = std::isfinite(settled.pose.translation_mm.y());
  return settled;
}

std::vector<double> fibre_lengths_mm(const job::Case& joint, const SettledPose& at)
{
  const model::Ligaments ligaments = model::solver_ligaments(joint.ligaments, joint.frame);
  std::vector<double> lengths;
  for (const model::FibreState& state : model::fibre_states(ligaments, at.attitude, at.pose))
    lengths.push_back(state.length_mm);
  return lengths;
}

FibreLoads solved_loads(const job::Case& joint, int n_threads, const std::function<bool()>& is_stopped)
{
  job::Case coarse = joint;
  coarse.grid = {{}, {0.0}};
  for (int k = 0; k < 10; ++k) coarse.grid.flexion_deg.push_back(10.0 * k);
  coarse.is_varus_free = true;
  coarse.push.assign(10, joint.push.front());
  // Steps of 2 degrees along the spine and few restarts: strains to a hundredth.
  coarse.path_flexion_deg.clear();
  for (int k = 0; k <= 45; ++k) coarse.path_flexion_deg.push_back(2.0 * k);
  coarse.path_push.assign(coarse.path_flexion_deg.size(), joint.push.front());
  coarse.spine = {0, 0.0};
  solve::CaseSolver solver(coarse, n_threads);
  const solve::SweepResult result = solve::sweep(
      solve::plan_of(coarse), [&](const solve::StepTask& task) { return solver(task); },
      {{}, {}, is_stopped}, n_threads);
  const model::Ligaments ligaments = model::solver_ligaments(joint.ligaments, joint.frame);
  FibreLoads loads;
  loads.largest_strain.assign(ligaments.fibres.size(), -1.0);
  loads.largest_tension_n.assign(ligaments.fibres.size(), 0.0);
  loads.n_flexions = static_cast<int>(result.cells.size());
  for (const StepRecord& cell : result.cells) {
    if (cell.status != StepStatus::stable) continue;
    ++loads.n_solved;
    const double flexion_rad =
        rad_from_deg(coarse.grid.flexion_deg[static_cast<std::size_t>(cell.key.flexion)]);
    const std::vector<model::FibreState> states =
        model::fibre_states(ligaments, {flexion_rad, cell.varus_rad}, cell.pose);
    for (std::size_t i = 0; i < states.size(); ++i) {
      loads.largest_strain[i] = std::max(loads.largest_strain[i], states[i].strain);
      loads.largest_tension_n[i] = std::max(loads.largest_tension_n[i], states[i].force_n);
    }
  }
  return loads;
}

SlackResult set_slack_lengths(job::Case& subject, const job::Case& reference, int n_threads,
                              const std::function<bool()>& is_stopped)
{
  constexpr double allowed_excess = 0.05;
  constexpr double tolerance = 0.005;  // of strain
  constexpr int most_solutions = 4;
  std::vector<model::Fibre>& fibres = subject.ligaments.fibres;
  check(fibres.size() == reference.ligaments.fibres.size(), "a transferred fibre for each of the template");
  SlackResult result;
  result.settled = settled_pose(subject);
  const std::vector<double> own_mm = fibre_lengths_mm(subject, result.settled);
  const std::vector<double> template_mm = fibre_lengths_mm(reference, settled_pose(reference));
  for (std::size_t i = 0; i < fibres.size(); ++i)
    fibres[i].slack_length_mm = reference.ligaments.fibres[i].slack_length_mm * own_mm[i] / template_mm[i];
  result.template_strain = solved_loads(reference, n_threads, is_stopped).largest_strain;
  result.loads = solved_loads(subject, n_threads, is_stopped);
  for (int k = 0; k < most_solutions; ++k) {
    std::int32_t n = 0;
    for (std::size_t i = 0; i < fibres.size(); ++i) {
      const double limit = std::max(result.template_strain[i], 0.0) + allowed_excess;
      if (result.loads.largest_strain[i] <= limit + tolerance) continue;
      fibres[i].slack_length_mm *= (1.0 + result.loads.largest_strain[i]) / (1.0 + limit);
      ++n;
    }
    result.lengthenings.push_back(n);
    if (n == 0) break;
    result.loads = solved_loads(subject, n_threads, is_stopped);
  }
  return result;
}

}  // namespace vrda::prepare
