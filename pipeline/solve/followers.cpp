#include "solve/followers.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "core/parallel.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "solve/case_solver.hpp"
#include "solve/coordinate_equilibrium.hpp"
#include "solve/potential.hpp"

namespace vrda::solve {
namespace {

std::vector<TouchedBody> touched_bodies(const job::Case& job_case, const job::Follower& follower)
{
  std::vector<TouchedBody> touched;
  for (const BodyIndex body : follower.touches) {
    const Body& of_case = body == BodyIndex::reference ? job_case.reference
                          : body == BodyIndex::moving  ? job_case.moving
                                                      : job_case.followers.at(model::follower_row(body)).body;
    touched.push_back({&of_case, body, follower.touches_visual});
  }
  return touched;
}

std::shared_ptr<const Joint> touching_joint(const job::Case& job_case, const job::Follower& follower,
                                            const BodyPoses& placed)
{
  const SolverFrame frame = follower_frame(job_case, follower);
  return std::make_shared<const Joint>(make_joint(
      {solver_mesh(touched_mesh(touched_bodies(job_case, follower), follower.of, placed), frame), {}},
      {solver_mesh(follower.body.contact.mesh, frame), follower.body.contact.component}, {}));
}

Eigen::Vector3d mean_end_mm(const model::Ligaments& ligaments, const std::string& bundle,
                            Eigen::Vector3d model::Fibre::*end)
{
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double n = 0.0;
  for (const model::Fibre& fibre : ligaments.fibres) {
    if (fibre.bundle != bundle) continue;
    sum += fibre.*end;
    n += 1.0;
  }
  check(n > 0.0, "a direction is that of a bundle of the follower");
  return sum / n;
}

// The bodies where the scan found them; the follower last.
BodyPoses scan_poses(const job::Follower& follower, const BodyPoses& placed)
{
  BodyPoses scan = placed;
  scan.at(row_of(BodyIndex::moving)) = follower.X_reference_moving_scan;
  return scan;
}

}  // namespace

bool touches_one_body(const std::vector<TouchedBody>& touched, BodyIndex of)
{
  return touched.size() == 1 && touched.front().index == of;
}

Mesh touched_mesh(const std::vector<TouchedBody>& touched, BodyIndex of, const BodyPoses& placed)
{
  Mesh all;
  const auto add = [&](const Mesh& mesh, BodyIndex body) {
    if (body == of) {
      append(all, mesh);
    } else {
      append(all, transformed(mesh, placed.at(row_of(of)).inverse() * placed.at(row_of(body))));
    }
  };
  for (const TouchedBody& one : touched) {
    add(one.body->contact.mesh, one.index);
    if (one.has_drawn) add(one.body->visual.mesh, one.index);
  }
  return all;
}

SolverFrame follower_frame(const job::Case& job_case, const job::Follower& follower)
{
  return {job_case.frame.side, follower.centre_mm, follower.delta};
}

Pose follower_pose_of(const SolverFrame& frame, const StepRecord& record)
{
  return X_reference_moving(frame, {record.coordinates->flexion_rad, record.varus_rad}, record.pose);
}

Pose joint_pose_of(const job::Case& job_case, const StepRecord& cell)
{
  const auto i = static_cast<std::size_t>(cell.key.flexion);
  const double flexion_rad =
      cell.coordinates ? cell.coordinates->flexion_rad : rad_from_deg(job_case.grid.flexion_deg[i]);
  return X_reference_moving(frame_of(job_case, job_case.push[i]), {flexion_rad, cell.varus_rad}, cell.pose);
}

struct FollowerSolver::State {
  State(const job::Case& c, std::size_t row, Shared& surfaces)
      : job_case(c),
        follower(c.followers.at(row)),
        own(follower_index(row)),
        frame(follower_frame(c, follower)),
        shared(surfaces)
  {
  }

  const job::Case& job_case;
  const job::Follower& follower;
  BodyIndex own;
  SolverFrame frame;
  Shared& shared;
  std::shared_ptr<const Joint> joint;
  model::Ligaments ligaments;  // of the current step, in the solver frame
  std::unique_ptr<CoordinateEquilibrium> solver;
};

namespace {

std::vector<DirectionSpring> direction_springs(const job::Follower& follower, BodyIndex own,
                                               const SolverFrame& frame, const BodyPoses& placed,
                                               const model::Ligaments& ligaments)
{
  std::vector<DirectionSpring> springs;
  for (const job::TendonDirection& direction : follower.directions) {
    const model::Ligaments scan =
        ligaments_between(follower.ligaments, follower.of, own, scan_poses(follower, placed));
    const auto line = [&](Eigen::Vector3d model::Fibre::*end) {
      return mean_end_mm(scan, direction.bundle, end);
    };
    const Eigen::Vector3d rest =
        follower.X_of_scan.linear().transpose() *
        (line(&model::Fibre::reference_mm) - follower.X_of_scan * line(&model::Fibre::moving_mm));
    DirectionSpring spring;
    spring.stiffness_nmm = direction.stiffness_nmm;
    spring.reference_mm = mean_end_mm(ligaments, direction.bundle, &model::Fibre::reference_mm);
    spring.moving_mm = mean_end_mm(ligaments, direction.bundle, &model::Fibre::moving_mm);
    spring.axis = solver_translation_mm(frame, direction.axis).normalized();
    const Eigen::Vector3d rest_solver = solver_translation_mm(frame, rest);
    spring.rest = (rest_solver - spring.axis.dot(rest_solver) * spring.axis).normalized();
    const auto [sin, cos] = sin_cos(direction.rest_rad);
    if (sin != 0.0) spring.rest = cos * spring.rest + sin * spring.axis.cross(spring.rest).eval();
    springs.push_back(spring);
  }
  return springs;
}

double energy_of(const StepRecord& record)
{
  return record.status == StepStatus::stable ? record.balance.energy_nmm
                                             : std::numeric_limits<double>::infinity();
}

constexpr double equal_energy_nmm = 1e-6;

}  // namespace

FollowerSolver::FollowerSolver(const job::Case& job_case, std::size_t follower, Shared& shared)
    : state_(std::make_unique<State>(job_case, follower, shared))
{
}
FollowerSolver::~FollowerSolver() = default;
FollowerSolver::FollowerSolver(FollowerSolver&&) noexcept = default;

StepRecord FollowerSolver::solve(const BodyPoses& placed, const std::vector<Pose>& seeds)
{
  State& s = *state_;
  s.ligaments =
      model::solver_ligaments(ligaments_between(s.follower.ligaments, s.follower.of, s.own, placed), s.frame);
  const bool is_shared = touches_one_body(touched_bodies(s.job_case, s.follower), s.follower.of);
  if (!s.solver || !is_shared) {
    s.solver.reset();
    if (is_shared) {
      std::call_once(s.shared.flag, [&] { s.shared.joint = touching_joint(s.job_case, s.follower, placed); });
      s.joint = s.shared.joint;
    } else {
      s.joint = touching_joint(s.job_case, s.follower, placed);
    }
    s.solver =
        std::make_unique<CoordinateEquilibrium>(*s.joint, s.ligaments, s.frame, s.job_case.equilibrium);
  }
  CoordinateEquilibrium::Task task;
  task.is_free.fill(true);
  task.tests_freedom = false;
  task.loads.force_n = s.follower.push_n * Eigen::Vector3d::UnitY();
  task.loads.directions = direction_springs(s.follower, s.own, s.frame, placed, s.ligaments);
  const JointMap map(s.frame);
  StepRecord best;
  for (const Pose& seed : seeds) {
    task.seed = map.coordinates_at(solver_position(s.frame, seed));
    StepRecord record = s.solver->solve(task);
    const bool is_first = best.status == StepStatus::pending;
    if (is_first || energy_of(record) < energy_of(best) - equal_energy_nmm) best = std::move(record);
  }
  return best;
}

namespace {

// Keys: the follower's number is in `varus`, below the start or the column; the joint's is the last.
constexpr std::int32_t joint_number = most_in_step - 1;
constexpr int most_passes = 3;  // of starts from the neighbours on the spine

constexpr int most_rounds = 5;  // of a reaction
constexpr double settled_mm = 0.01;

// Offsets of further starts: about the follower's flexion and tilt, and along its proximal axis.
constexpr std::array<std::array<double, 3>, 4> offsets{
    {{4.0, 0.0, 2.0}, {-4.0, 0.0, -2.0}, {0.0, 4.0, 0.0}, {0.0, -4.0, 0.0}}};

struct FollowInput {
  const job::Case& job_case;
  const SweepPlan& plan;
  const SolveStep& solve;
  const SweepHooks& hooks;
  int n_threads;
  const std::vector<Pose>& starts;
};

class Follow {
 public:
  Follow(const FollowInput& in, SweepResult& result)
      : case_(in.job_case),
        plan_(in.plan),
        solve_(in.solve),
        hooks_(in.hooks),
        starts_(in.starts),
        n_threads_(in.n_threads),
        joint_(result),
        n_varus_(static_cast<std::int32_t>(plan_.varus_rad.size())),
        shared_(case_.followers.size()),
        cells_(result.cells.size())
  {
    for (const job::Follower& follower : case_.followers) {
      has_reaction_ = has_reaction_ || follower.has_reaction;
      boxes_.push_back(bounding_box(follower.body.contact.mesh));
    }
  }

  bool run()
  {
    if (!solve_chain() || !improve_spine() || !choose_continuous()) return false;
    for (std::size_t i = 0; has_spine_cells() && i < spine_.size(); ++i)
      cells_[cell_of(static_cast<std::int32_t>(i), has_free_spine() ? 0 : joint_.spine_column[i])] =
          spine_[i].cell;
    if (!solve_rows()) return false;
    joint_.followers.assign(cells_.size(), {});
    for (std::size_t c = 0; c < cells_.size(); ++c) {
      if (!cells_[c]) continue;  // in a row of another shard
      if (has_reaction_) joint_.cells[c] = std::move(cells_[c]->joint);
      joint_.followers[c] = std::move(cells_[c]->followers);
    }
    return true;
  }

 private:
  struct FollowedCell {
    StepRecord joint;                   // with a reaction: solved again with the followers' fibres
    std::vector<StepRecord> followers;  // [n_followers]
  };

  // One cell with the poses of its bodies.
  struct Solved {
    FollowedCell cell;
    BodyPoses placed;
    double energy_nmm = std::numeric_limits<double>::infinity();
    bool is_solved = false;  // false: stopped
  };
  using Seeds = std::vector<std::vector<Pose>>;  // [n_followers]

  // Owned by one thread.
  struct Worker {
    std::vector<FollowerSolver> solvers;
    int number = 0;
  };

  Worker worker(int number)
  {
    Worker out;
    out.number = number;
    for (std::size_t k = 0; k < case_.followers.size(); ++k) out.solvers.emplace_back(case_, k, shared_[k]);
    return out;
  }

  std::size_t n_followers() const { return case_.followers.size(); }
  std::size_t cell_of(std::int32_t flexion, std::int32_t varus) const
  {
    return static_cast<std::size_t>(flexion) * static_cast<std::size_t>(n_varus_) +
           static_cast<std::size_t>(varus);
  }
  // The spine of the joint, which every shard has: with a free varus its own poses, else its cells.
  StepRecord spine_record(std::size_t i) const
  {
    const auto flexion = static_cast<std::int32_t>(i);
    if (!has_free_spine()) return joint_.cells[cell_of(flexion, joint_.spine_column[i])];
    StepRecord record = joint_.free_spine[i].chosen;
    record.key = {StepKind::spine, flexion, 0};
    return record;
  }
  bool has_free_spine() const { return plan_.spine == SpineRule::free_varus; }
  // Whether cells of the grid are those of the spine.
  bool has_spine_cells() const
  {
    return !has_free_spine() || (plan_.is_varus_free && !plan_.measures_chosen);
  }

  Pose joint_pose(const StepRecord& record) const { return joint_pose_of(case_, record); }
  Pose pose_of(std::size_t k, const StepRecord& record) const
  {
    return follower_pose_of(follower_frame(case_, case_.followers[k]), record);
  }

  // Solves or recalls the steps of one cell under keys from `key`.
  Solved solved_cell(const StepRecord& joint, const Seeds& seeds, StepKey key, Worker& by) const
  {
    Solved out;
    out.cell.joint = joint;
    if (joint.status != StepStatus::stable) {
      StepRecord none;
      none.status = joint.status;
      out.cell.followers.assign(n_followers(), none);
      out.is_solved = true;
      return out;
    }
    const StepKey joint_key{key.kind, key.flexion, key.varus + joint_number};
    if (has_reaction_) {
      if (const std::optional<StepRecord> known = hooks_.recall ? hooks_.recall(joint_key) : std::nullopt) {
        out.cell.joint = *known;
        out.cell.joint.key = joint.key;
      }
    }
    std::vector<bool> is_known(n_followers(), false);
    for (std::size_t k = 0; k < n_followers() && hooks_.recall; ++k) {
      const std::optional<StepRecord> known =
          hooks_.recall({key.kind, key.flexion, key.varus + static_cast<std::int32_t>(k)});
      if (!known) break;
      out.cell.followers.push_back(*known);
    }
    const bool is_recalled = out.cell.followers.size() == n_followers();
    if (!is_recalled) {
      if (hooks_.is_stopped && hooks_.is_stopped()) return out;
      out.cell = solved(joint, seeds, by, key.kind == StepKind::follower_start);
      keep(out.cell, key, joint_key);
    }
    finish(out);
    return out;
  }

  void keep(const FollowedCell& cell, StepKey key, StepKey joint_key) const
  {
    if (!hooks_.keep) return;
    if (has_reaction_) {
      StepRecord joint = cell.joint;
      joint.key = joint_key;
      hooks_.keep(joint);
    }
    for (std::size_t k = 0; k < n_followers(); ++k) {
      StepRecord record = cell.followers[k];
      record.key = {key.kind, key.flexion, key.varus + static_cast<std::int32_t>(k)};
      hooks_.keep(record);
    }
  }

  // Poses and the energy of what is not counted in the joint's.
  void finish(Solved& out) const
  {
    out.is_solved = true;
    out.placed = {Pose::Identity(), joint_pose(out.cell.joint)};
    double energy_nmm = 0.0;
    for (std::size_t k = 0; k < n_followers(); ++k) {
      const StepRecord& record = out.cell.followers[k];
      energy_nmm += energy_of(record);
      if (record.status != StepStatus::stable) break;
      out.placed.push_back(out.placed.at(row_of(case_.followers[k].of)) * pose_of(k, record));
    }
    if (has_reaction_ && has_all_poses(out)) {
      energy_nmm += energy_of(out.cell.joint);
      const FollowerForces reaction = reaction_of(out.cell, out.placed);
      energy_nmm -= fibre_energy_nmm(reaction.fibres, out.cell.joint);
    }
    out.energy_nmm = energy_nmm;
  }

  double fibre_energy_nmm(const model::Ligaments& canonical, const StepRecord& joint) const
  {
    const auto i = static_cast<std::size_t>(joint.key.flexion);
    const double flexion_rad =
        joint.coordinates ? joint.coordinates->flexion_rad : rad_from_deg(case_.grid.flexion_deg[i]);
    double sum = 0.0;
    for (const model::FibreState& state :
         model::fibre_states(model::solver_ligaments(canonical, frame_of(case_, case_.push[i])),
                             {flexion_rad, joint.varus_rad}, joint.pose))
      sum += state.energy_nmm;
    return sum;
  }

  FollowedCell solved(const StepRecord& joint, const Seeds& seeds, Worker& by, bool is_spine) const
  {
    FollowedCell cell;
    cell.joint = joint;
    Seeds from = seeds;
    for (int round = 0;; ++round) {
      BodyPoses placed{Pose::Identity(), joint_pose(cell.joint)};
      cell.followers.clear();
      for (std::size_t k = 0; k < n_followers(); ++k) {
        StepRecord record;
        if (placed.size() == 2 + k) {
          record = by.solvers[k].solve(placed, from[k]);
          if (record.status == StepStatus::stable) {
            const Pose X_of = pose_of(k, record);
            placed.push_back(placed.at(row_of(case_.followers[k].of)) * X_of);
            from[k] = {X_of};
          }
        } else {
          record.status = cell.followers.back().status;  // one before it has no pose
        }
        cell.followers.push_back(std::move(record));
      }
      if (!has_reaction_ || placed.size() != 2 + n_followers()) return cell;
      const FollowerForces reaction = reaction_of(cell, placed);
      StepRecord again = solved_again(cell.joint, reaction, by.number, is_spine);
      if (again.status != StepStatus::stable) {
        for (StepRecord& record : cell.followers) record.status = again.status;
        return cell;
      }
      const double moved_mm = change_mm(cell.joint, again);
      cell.joint = again;
      if (moved_mm <= settled_mm) return cell;
      if (round == most_rounds) {
        for (StepRecord& record : cell.followers) record.status = StepStatus::iteration_limit;
        return cell;
      }
    }
  }

  double change_mm(const StepRecord& from, const StepRecord& to) const
  {
    const Box box = bounding_box(case_.moving.contact.mesh);
    double largest = 0.0;
    const Pose a = joint_pose(from), b = joint_pose(to);
    for (int corner = 0; corner < 8; ++corner) {
      Eigen::Vector3d p;
      for (int axis = 0; axis < 3; ++axis)
        p(axis) = (corner >> axis & 1) != 0 ? box.max_mm(axis) : box.min_mm(axis);
      largest = std::max(largest, (a * p - b * p).norm());
    }
    return largest;
  }

  StepRecord solved_again(const StepRecord& cell, const FollowerForces& forces, int number,
                          bool is_spine) const
  {
    const std::vector<double>& path = path_of(plan_);
    const double flexion_rad = plan_.flexion_rad[static_cast<std::size_t>(cell.key.flexion)];
    StepTask task;
    task.key = cell.key;
    task.path_row =
        static_cast<std::int32_t>(std::lower_bound(path.begin(), path.end(), flexion_rad) - path.begin());
    task.seed_path_row = task.path_row;
    task.attitude = {flexion_rad, cell.varus_rad};
    task.seed = cell.pose;
    task.seed_attitude =
        Attitude{cell.coordinates ? cell.coordinates->flexion_rad : flexion_rad, cell.varus_rad};
    task.is_varus_free = is_spine ? has_free_spine() : plan_.is_varus_free;
    if (!plan_.springs.empty()) task.springs = plan_.springs[static_cast<std::size_t>(task.path_row)];
    task.worker = number;
    task.followers = &forces;
    StepRecord record = solve_(task);
    record.key = cell.key;
    return record;
  }

  // What the placed followers do to the moving object: their fibres, and the forces of their springs.
  FollowerForces reaction_of(const FollowedCell& cell, const BodyPoses& placed) const
  {
    FollowerForces out;
    for (std::size_t k = 0; k < n_followers(); ++k) {
      const job::Follower& follower = case_.followers[k];
      if (!follower.has_reaction) continue;
      model::Ligaments own = follower.ligaments;
      std::erase_if(own.fibres, [&](const model::Fibre& fibre) {
        return fibre.from != BodyIndex::moving && fibre.to != BodyIndex::moving;
      });
      const model::Ligaments more = ligaments_between(own, BodyIndex::reference, BodyIndex::moving, placed);
      const auto first_wrap = static_cast<int>(out.fibres.wraps.size());
      out.fibres.transition_strain = more.transition_strain;
      out.fibres.wraps.insert(out.fibres.wraps.end(), more.wraps.begin(), more.wraps.end());
      for (model::Fibre fibre : more.fibres) {
        if (fibre.wrap >= 0) fibre.wrap += first_wrap;
        out.fibres.fibres.push_back(std::move(fibre));
      }
      add_spring_loads(k, cell, placed, out.loads);
    }
    return out;
  }

  // In the joint's solver frame at this flexion.
  void add_spring_loads(std::size_t k, const FollowedCell& cell, const BodyPoses& placed,
                        std::vector<AppliedLoad>& loads) const
  {
    const job::Follower& follower = case_.followers[k];
    const StepRecord& record = cell.followers[k];
    const SolverFrame frame = follower_frame(case_, follower);
    BodyPoses before(placed.begin(), placed.begin() + static_cast<std::ptrdiff_t>(2 + k));
    const model::Ligaments ligaments = model::solver_ligaments(
        ligaments_between(follower.ligaments, follower.of, follower_index(k), before), frame);
    const std::vector<DirectionSpring> springs =
        direction_springs(follower, follower_index(k), frame, before, ligaments);
    const SolverPosition at{{record.coordinates->flexion_rad, record.varus_rad}, record.pose};
    const SolverFrame joint_frame =
        frame_of(case_, case_.push[static_cast<std::size_t>(cell.joint.key.flexion)]);
    for (std::size_t d = 0; d < springs.size(); ++d) {
      const Eigen::Vector3d in_of = world_from_solver(
          frame, reference_rotation(at.attitude).transpose() * force_on_reference(springs[d], at));
      const Eigen::Vector3d in_reference = placed.at(row_of(follower.of)).linear() * in_of;
      Eigen::Vector3d end_mm = Eigen::Vector3d::Zero();
      double n = 0.0;
      for (const model::Fibre& fibre : follower.ligaments.fibres) {
        if (fibre.bundle != follower.directions[d].bundle) continue;
        if (fibre.from != BodyIndex::moving && fibre.to != BodyIndex::moving) continue;
        end_mm += fibre.from == BodyIndex::moving ? fibre.reference_mm : fibre.moving_mm;
        n += 1.0;
      }
      if (n == 0.0) continue;
      AppliedLoad load;
      load.frame = BodyIndex::reference;
      load.force_n = solver_translation_mm(joint_frame, in_reference);
      load.point_mm = solver_translation_mm(joint_frame, end_mm / n - joint_frame.rotation_centre_mm);
      loads.push_back(load);
    }
  }

  std::vector<std::size_t> chain_order(std::size_t first) const
  {
    std::vector<std::size_t> order;
    for (std::size_t i = first; i < spine_.size(); ++i) order.push_back(i);
    for (std::size_t i = first; i-- > 0;) order.push_back(i);
    return order;
  }

  std::size_t first_flexion() const
  {
    if (case_.coordinates && case_.coordinates->is_sequence()) return 0;
    const std::vector<double>& flexion = plan_.flexion_rad;
    return static_cast<std::size_t>(
        std::min_element(flexion.begin(), flexion.end(),
                         [](double a, double b) { return std::abs(a) < std::abs(b); }) -
        flexion.begin());
  }

  JointCoordinates coordinates_of(std::size_t k, const Pose& X_of) const
  {
    return follower_coordinates(X_of, case_.frame.side, case_.followers[k].centre_mm);
  }
  Pose pose_at(std::size_t k, const JointCoordinates& q) const
  {
    return follower_pose(q, case_.frame.side, case_.followers[k].centre_mm);
  }
  Pose X_of(std::size_t k, const BodyPoses& placed) const
  {
    return placed.at(row_of(case_.followers[k].of)).inverse() * placed.at(2 + k);
  }

  // From the last poses, continued, and at offsets of them.
  Seeds chain_seeds(const Solved* last, const Solved* before_last) const
  {
    Seeds seeds(n_followers());
    for (std::size_t k = 0; k < n_followers(); ++k) {
      const auto is_posed = [&](const Solved* s) { return s != nullptr && s->placed.size() > 2 + k; };
      JointCoordinates q = coordinates_of(k, starts_.empty() ? case_.followers[k].X_of_scan : starts_[k]);
      if (is_posed(last)) {
        q = coordinates_of(k, X_of(k, last->placed));
        if (is_posed(before_last)) q += q - coordinates_of(k, X_of(k, before_last->placed));
      }
      seeds[k].push_back(pose_at(k, q));
      for (int r = 0; r < case_.followers[k].n_restarts; ++r) {
        const auto& offset = offsets[static_cast<std::size_t>(r) % offsets.size()];
        const double times = 1.0 + static_cast<double>(r / static_cast<int>(offsets.size()));
        JointCoordinates moved = q;
        moved(0) += rad_from_deg(times * offset[0]);
        moved(2) += rad_from_deg(times * offset[1]);
        moved(4) += times * offset[2];
        seeds[k].push_back(pose_at(k, moved));
      }
    }
    return seeds;
  }

  bool solve_chain()
  {
    spine_.resize(joint_.cells.size() / static_cast<std::size_t>(n_varus_));
    const std::size_t first = first_flexion();
    Worker by = worker(0);
    for (const std::size_t i : chain_order(first)) {
      const auto at = [&](std::size_t row) -> const Solved* {
        return row < spine_.size() && spine_[row].is_solved ? &spine_[row] : nullptr;
      };
      const bool is_down = i < first;
      const Solved* last = is_down ? at(i + 1) : i > first ? at(i - 1) : nullptr;
      const Solved* before_last = is_down ? at(i + 2) : i > first + 1 ? at(i - 2) : nullptr;
      spine_[i] = solved_cell(spine_record(i), chain_seeds(last, before_last),
                              {StepKind::follower_start, static_cast<std::int32_t>(i), 0}, by);
      if (!spine_[i].is_solved) return false;
    }
    return true;
  }

  // Each flexion starts from those of its neighbours that changed in the pass before, until none changes.
  bool improve_spine()
  {
    std::vector<bool> has_changed(spine_.size(), true);
    for (std::int32_t pass = 1; pass <= most_passes; ++pass) {
      std::vector<std::optional<Solved>> better(spine_.size());
      std::atomic<bool> is_stopped = false;
      for_each_index(spine_.size(), n_threads_, [&] {
        return [&, by = worker(next_worker_++ % n_threads_)](std::size_t i) mutable {
          Seeds seeds(n_followers());
          for (const std::size_t neighbour : {i - 1, i + 1}) {
            if (neighbour >= spine_.size() || !has_changed[neighbour]) continue;
            for (std::size_t k = 0; k < n_followers(); ++k) {
              if (spine_[neighbour].placed.size() > 2 + k)
                seeds[k].push_back(X_of(k, spine_[neighbour].placed));
            }
          }
          if (std::any_of(seeds.begin(), seeds.end(), [](const auto& s) { return s.empty(); })) return;
          better[i] =
              solved_cell(spine_record(i), seeds,
                          {StepKind::follower_start, static_cast<std::int32_t>(i), pass * most_in_step}, by);
          if (!better[i]->is_solved) is_stopped = true;
        };
      });
      if (is_stopped) return false;
      bool any = false;
      for (std::size_t i = 0; i < spine_.size(); ++i) {
        has_changed[i] = better[i] && better[i]->energy_nmm < spine_[i].energy_nmm - changed_nmm;
        if (has_changed[i]) spine_[i] = std::move(*better[i]);
        any = any || has_changed[i];
      }
      if (!any) break;
    }
    return true;
  }

  // Of the lowest equilibria and those in which chains up and down end from the one before alone: distinct
  // ones differ by less than a hundredth of the forces times 1 mm, and the lowest jump between them.
  bool choose_continuous()
  {
    if (case_.spine.branch != BranchRule::continuous) return true;
    std::vector<std::vector<Solved>> found;
    for (const Solved& lowest : spine_) found.push_back({lowest});
    for (const bool is_up : {true, false}) {
      if (!solve_branch(is_up, found)) return false;
    }
    std::vector<std::vector<double>> energy_nmm(found.size());
    for (std::size_t i = 0; i < found.size(); ++i) {
      if (!has_all_poses(spine_[i])) continue;
      for (const Solved& one : found[i]) energy_nmm[i].push_back(one.energy_nmm);
    }
    const auto at = [&](const PathEntry& e) -> const Solved& { return found[e.row][e.entry]; };
    const std::vector<std::size_t> path = least_path(
        energy_nmm, [&](const PathEntry& a, const PathEntry& b) { return change_nmm(at(a), at(b)); });
    for (std::size_t i = 0; i < found.size(); ++i) spine_[i] = std::move(found[i][path[i]]);
    return true;
  }

  // From the lowest of the last flexion whenever that branch has ended or is too high.
  bool solve_branch(bool is_up, std::vector<std::vector<Solved>>& found)
  {
    Worker by = worker(0);
    const std::int32_t number = (most_passes + (is_up ? 1 : 2)) * most_in_step;
    std::optional<Solved> last, before_last;
    for (std::size_t n = 0; n < spine_.size(); ++n) {
      const std::size_t i = is_up ? n : spine_.size() - 1 - n;
      const Solved& lowest = spine_[i];
      if (!has_all_poses(lowest)) continue;
      if (last) {
        Seeds seeds = chain_seeds(&*last, before_last ? &*before_last : nullptr);
        for (std::vector<Pose>& of_follower : seeds) of_follower.resize(1);  // no offsets
        Solved next = solved_cell(spine_record(i), seeds,
                                  {StepKind::follower_start, static_cast<std::int32_t>(i), number}, by);
        if (!next.is_solved) return false;
        if (has_all_poses(next) && next.energy_nmm > lowest.energy_nmm + changed_nmm &&
            next.energy_nmm <= lowest.energy_nmm + total_force_n() * most_path_work_mm) {
          found[i].push_back(next);
          before_last = std::exchange(last, std::move(next));
          continue;
        }
      }
      before_last = std::exchange(last, lowest);
    }
    return true;
  }

  bool has_all_poses(const Solved& one) const { return one.placed.size() == 2 + n_followers(); }

  double force_n(std::size_t k) const
  {
    double sum_n = std::abs(case_.followers[k].push_n);
    for (const model::Fibre& fibre : case_.followers[k].ligaments.fibres) sum_n += fibre.tension_n;
    return sum_n;
  }
  double total_force_n() const
  {
    double sum_n = 0.0;
    for (std::size_t k = 0; k < n_followers(); ++k) sum_n += force_n(k);
    return sum_n;
  }

  // As that of the joint, but unbounded: a follower moves on with flexion, beyond any bound at 5 degrees.
  double change_nmm(const Solved& from, const Solved& to) const
  {
    double sum_nmm = 0.0;
    for (std::size_t k = 0; k < n_followers(); ++k) {
      const Box& box = boxes_[k];
      const Eigen::Vector3d middle_mm = 0.5 * (box.min_mm + box.max_mm);
      const Pose a = X_of(k, from.placed), b = X_of(k, to.placed);
      // For the angle: of two rotations by it about one axis, the difference's norm is 2 sqrt(2) sin(angle /
      // 2).
      const double turned_mm =
          0.5 * (box.max_mm - box.min_mm).maxCoeff() * (b.linear() - a.linear()).norm() / std::sqrt(2.0);
      const double change_sq_mm2 = (b * middle_mm - a * middle_mm).squaredNorm() + turned_mm * turned_mm;
      sum_nmm += force_n(k) * change_sq_mm2 / (2.0 * path_compliance_mm);
    }
    return sum_nmm;
  }

  // Outward from the column of the spine.
  bool solve_row(std::int32_t i, Worker& by)
  {
    const std::int32_t spine = joint_.spine_column[static_cast<std::size_t>(i)];
    Solved first = spine_[static_cast<std::size_t>(i)];
    if (!has_spine_cells() && !solve_next(i, spine, first, by)) return false;
    for (const std::int32_t step : {-1, 1}) {
      Solved last = first;
      for (std::int32_t j = spine + step; j >= 0 && j < n_varus_; j += step) {
        if (!solve_next(i, j, last, by)) return false;
      }
    }
    return true;
  }

  // From the poses of `last`, which becomes the cell's if it has any. False when stopped.
  bool solve_next(std::int32_t i, std::int32_t j, Solved& last, Worker& by)
  {
    Seeds seeds(n_followers());
    for (std::size_t k = 0; k < n_followers(); ++k)
      seeds[k] = {last.placed.size() > 2 + k ? X_of(k, last.placed) : case_.followers[k].X_of_scan};
    Solved next =
        solved_cell(joint_.cells[cell_of(i, j)], seeds, {StepKind::follower, i, j * most_in_step}, by);
    if (!next.is_solved) return false;
    cells_[cell_of(i, j)] = next.cell;
    if (next.placed.size() > 2) last = std::move(next);
    return true;
  }

  bool solve_rows()
  {
    std::vector<std::int32_t> rows;
    for (std::int32_t i = 0; i < static_cast<std::int32_t>(spine_.size()); ++i) {
      if (!plan_.rows || std::find(plan_.rows->begin(), plan_.rows->end(), i) != plan_.rows->end())
        rows.push_back(i);
    }
    std::atomic<bool> is_stopped = false;
    for_each_index(rows.size(), n_threads_, [&] {
      return [&, by = worker(next_worker_++ % n_threads_)](std::size_t r) mutable {
        if (!solve_row(rows[r], by)) is_stopped = true;
      };
    });
    return !is_stopped;
  }

  // Below this two results are one equilibrium: a hundredth of what distinct ones differ by.
  static constexpr double changed_nmm = 1e-4;

  const job::Case& case_;
  const SweepPlan& plan_;
  const SolveStep& solve_;
  const SweepHooks& hooks_;
  const std::vector<Pose>& starts_;
  int n_threads_;
  SweepResult& joint_;
  std::int32_t n_varus_;
  bool has_reaction_ = false;
  std::vector<Box> boxes_;                          // [n_followers] of their meshes
  std::vector<FollowerSolver::Shared> shared_;      // [n_followers]
  std::vector<std::optional<FollowedCell>> cells_;  // of the grid
  std::vector<Solved> spine_;                       // [n_flexion]
  std::atomic<int> next_worker_ = 0;
};

}  // namespace

bool follow(const job::Case& job_case, const SweepPlan& plan, const SolveStep& solve, const SweepHooks& hooks,
            int n_threads, SweepResult& result, const std::vector<Pose>& starts)
{
  return Follow({job_case, plan, solve, hooks, n_threads, starts}, result).run();
}

}  // namespace vrda::solve
