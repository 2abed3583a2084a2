#include "analysis/range_of_motion.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>

#include "analysis/audit.hpp"
#include "core/parallel.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "model/ligaments.hpp"
#include "solve/case_solver.hpp"
#include "solve/potential.hpp"
#include "solve/quadratic_program.hpp"

namespace vrda::analysis {
namespace {

constexpr double touching_mm = 1e-6;  // of the seat's contacts
constexpr double border_resolution_mm = 0.01;

using Index = std::array<std::size_t, 3>;

/// The joint with Delta fixed to the chosen body. If that is the reference, the two objects exchange their
/// roles: S belongs to the object that moves along Delta, which then is the reference, against Delta.
class RomScene {
 public:
  RomScene(const job::Case& job_case, BodyIndex delta_body)
      : case_(job_case), frame_(job_case.frame), is_swapped_(delta_body == BodyIndex::reference)
  {
    frame_.delta = job_case.push_at_meshes.delta;
    query_frame_ = frame_;
    if (is_swapped_) query_frame_.delta = -frame_.delta;
    const Body& first = part_of(job_case, is_swapped_ ? BodyIndex::moving : BodyIndex::reference);
    const Body& second = part_of(job_case, is_swapped_ ? BodyIndex::reference : BodyIndex::moving);
    joint_ =
        solve::make_joint({solver_mesh(first.contact.mesh, query_frame_), first.contact.component},
                          {solver_mesh(second.contact.mesh, query_frame_), second.contact.component}, {});
    ligaments_ = model::solver_ligaments(job_case.ligaments, frame_);
    first_border_ = boundary_edges(joint_.reference.tree_mesh.mesh);
    second_border_ = boundary_edges(joint_.moving.tree_mesh.mesh);
  }

  const solve::Joint& joint() const { return joint_; }
  const Eigen::Vector3d& centre_mm() const { return frame_.rotation_centre_mm; }

  /// The pose of the moving object with these rotations and displacement of the rotation centre, canonical.
  Pose pose_at(const Eigen::Vector3d& rotations_rad, const Eigen::Vector3d& displacement_mm) const
  {
    JointCoordinates q = JointCoordinates::Zero();
    q.head<3>() = rotations_rad;
    const solve::SolverPosition at = solve::JointMap(frame_).position_at(q);
    Pose X = X_reference_moving(frame_, at.attitude, at.pose);
    X.translation() = centre_mm() + displacement_mm - X.linear() * centre_mm();
    return X;
  }

  Eigen::Vector3d displacement_mm(const Pose& X) const { return X * centre_mm() - centre_mm(); }

  /// Numbers of the query for a pose, and back.
  solve::SolverPosition query_position(const Pose& X) const
  {
    return solve::solver_position(query_frame_, is_swapped_ ? X.inverse() : X);
  }
  Pose pose_of_query(const solve::SolverPosition& at) const
  {
    const Pose X = X_reference_moving(query_frame_, at.attitude, at.pose);
    return is_swapped_ ? X.inverse() : X;
  }

  void set_largest_strain(const Pose& X, RomCell& cell) const
  {
    if (ligaments_.fibres.empty()) return;
    const solve::SolverPosition at = solve::solver_position(frame_, X);
    const std::vector<model::FibreState> states = model::fibre_states(ligaments_, at.attitude, at.pose);
    const auto largest = std::max_element(
        states.begin(), states.end(),
        [](const model::FibreState& a, const model::FibreState& b) { return a.strain < b.strain; });
    cell.largest_strain = largest->strain;
    cell.fibre = static_cast<std::int32_t>(largest - states.begin());
  }

  bool is_at_border(const solve::SolverPosition& at, const geometry::GapFeature& contact) const
  {
    const Eigen::Vector3d of_first = reference_rotation(at.attitude).transpose() * contact.point_mm;
    const Eigen::Vector3d of_second = pose_of(at.pose).inverse() * contact.point_mm;
    return analysis::is_at_border(joint_.reference.tree_mesh.mesh, first_border_, contact.triangles.reference,
                                  of_first, border_resolution_mm) ||
           analysis::is_at_border(joint_.moving.tree_mesh.mesh, second_border_, contact.triangles.moving,
                                  of_second, border_resolution_mm);
  }

  /// Components of the triangles of a contact, of the joint's own reference and moving object.
  void set_components(const geometry::TrianglePair& pair, RomCell& cell) const
  {
    const auto [reference, moving] =
        is_swapped_ ? std::pair(pair.moving, pair.reference) : std::pair(pair.reference, pair.moving);
    cell.component_reference = case_.reference.contact.component.at(static_cast<std::size_t>(reference));
    cell.component_moving = case_.moving.contact.component.at(static_cast<std::size_t>(moving));
  }

 private:
  const job::Case& case_;
  SolverFrame frame_;
  bool is_swapped_;
  SolverFrame query_frame_;
  solve::Joint joint_;
  model::Ligaments ligaments_;
  std::vector<std::int8_t> first_border_, second_border_;
};

bool is_seed(const SolvedCell* cell)
{
  return cell != nullptr && cell->cell.status == RomStatus::in_range;
}

class CellSolver {
 public:
  CellSolver(const RomScene& scene, const RomLimits& limits)
      : scene_(scene), limits_(limits), query_(scene.joint().reference_gap, scene.joint().moving_gap)
  {
  }

  /// The displacement of the rotation centre in the seat at these rotations, from the start's.
  std::optional<Eigen::Vector3d> free_seat(const Eigen::Vector3d& rotations_rad,
                                           const Eigen::Vector3d& start_mm)
  {
    solve::SolverPosition at = scene_.query_position(scene_.pose_at(rotations_rad, start_mm));
    query_.set_attitude(at.attitude);
    const Seat seat =
        highest_seat(query_, {at.pose, std::numeric_limits<double>::infinity(), Eigen::Vector2d::Zero()});
    if (!seat.is_found || !seat.is_converged) return std::nullopt;
    at.pose = seat.pose;
    return scene_.displacement_mm(scene_.pose_of_query(at));
  }

  SolvedCell solve(const Eigen::Vector3d& rotations_rad, const Eigen::Vector3d& neutral_mm,
                   const SolvedCell* inward)
  {
    const solve::SolverPosition neutral = scene_.query_position(scene_.pose_at(rotations_rad, neutral_mm));
    query_.set_attitude(neutral.attitude);
    SolvedCell best;
    best.cell.status = RomStatus::nothing_ahead;
    for (const Eigen::Vector2d& from_mm : starts(inward)) {
      const SolvedCell found = solve_from(neutral, neutral_mm, from_mm);
      if (is_better(found, best)) best = found;
      if (best.cell.status == RomStatus::in_range) break;
    }
    return best;
  }

 private:
  std::vector<Eigen::Vector2d> starts(const SolvedCell* inward) const
  {
    std::vector<Eigen::Vector2d> list;
    if (is_seed(inward)) list.push_back(inward->across_mm);
    list.emplace_back(Eigen::Vector2d::Zero());
    if (!is_seed(inward) || !std::isfinite(limits_.translation_mm)) return list;
    const double half = 0.5 * limits_.translation_mm;
    for (const Eigen::Vector2d& place : {Eigen::Vector2d(half, 0), Eigen::Vector2d(-half, 0),
                                         Eigen::Vector2d(0, half), Eigen::Vector2d(0, -half)})
      list.push_back(place);
    return list;
  }

  static bool is_better(const SolvedCell& a, const SolvedCell& b)
  {
    if ((a.cell.status == RomStatus::in_range) != (b.cell.status == RomStatus::in_range))
      return a.cell.status == RomStatus::in_range;
    if (std::isnan(b.cell.opening_mm)) return true;
    return a.cell.opening_mm < b.cell.opening_mm;
  }

  SolvedCell solve_from(const solve::SolverPosition& neutral, const Eigen::Vector3d& neutral_mm,
                        const Eigen::Vector2d& from_mm)
  {
    SolvedCell solved;
    const Seat seat = highest_seat(query_, {neutral.pose, limits_.translation_mm, from_mm});
    if (!seat.is_found) {
      solved.cell.status = RomStatus::nothing_ahead;
      return solved;
    }
    const solve::SolverPosition at{neutral.attitude, seat.pose};
    const Eigen::Vector3d moved_mm = seat.pose.translation_mm - neutral.pose.translation_mm;
    const Pose X = scene_.pose_of_query(at);
    solved.across_mm = {moved_mm.x(), moved_mm.z()};
    solved.cell.opening_mm = -moved_mm.y();
    solved.cell.translation_mm = scene_.displacement_mm(X) - neutral_mm;
    scene_.set_largest_strain(X, solved.cell);
    scene_.set_components(seat.contacts.front().triangles, solved.cell);
    solved.cell.status = status_of(at, seat, solved.cell);
    return solved;
  }

  RomStatus status_of(const solve::SolverPosition& at, const Seat& seat, const RomCell& cell) const
  {
    if (cell.opening_mm > limits_.opening_mm)
      return seat.is_converged ? RomStatus::contact : RomStatus::not_converged;
    for (const geometry::GapFeature& contact : seat.contacts) {
      if (contact.travel_mm <= touching_mm && scene_.is_at_border(at, contact)) return RomStatus::border;
    }
    if (cell.largest_strain > limits_.strain) return RomStatus::fibre;
    return RomStatus::in_range;
  }

  const RomScene& scene_;
  RomLimits limits_;
  geometry::GapQuery query_;
};

std::size_t nearest_to_zero(const std::vector<double>& values)
{
  const auto nearest = std::min_element(values.begin(), values.end(),
                                        [](double a, double b) { return std::abs(a) < std::abs(b); });
  return static_cast<std::size_t>(nearest - values.begin());
}

/// Solves the cells in rounds: along flexion, along varus from there, along internal rotation from there.
class RomSweep {
 public:
  RomSweep(const job::Case& job_case, const RomPlan& plan)
      : plan_(plan), scene_(job_case, plan.delta_body), solved_(plan.axes.n_cells())
  {
    for (std::size_t a = 0; a < 3; ++a) neutral_[a] = nearest_to_zero(plan.axes.rad[a]);
    for (int k = 0; k < std::max(1, plan.n_threads); ++k)
      solvers_.push_back(std::make_unique<CellSolver>(scene_, plan.limits));
    const Eigen::Vector3d start_mm = job_case.initial.translation_mm;
    const auto seat = solvers_.front()->free_seat(rotations_rad(neutral_), start_mm);
    if (!seat) {
      throw InputError({job_case.title, "rom", "no seat of the moving object at the neutral rotations",
                        "a push that presses the moving object into the reference"});
    }
    neutral_mm_ = *seat;
  }

  RangeOfMotion run()
  {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      // Lines along this axis, through every cell of the axes before it and the neutral ones after it.
      std::vector<Index> lines{neutral_};
      for (std::size_t before = 0; before < axis; ++before) {
        std::vector<Index> more;
        for (const Index& line : lines) {
          for (std::size_t k = 0; k < plan_.axes.rad[before].size(); ++k) {
            more.push_back(line);
            more.back()[before] = k;
          }
        }
        lines = std::move(more);
      }
      if (axis > 0 && plan_.shard) {
        const auto is_other = [&](const Index& line) {
          return static_cast<std::int32_t>(line[0]) % plan_.shard->count != plan_.shard->number - 1;
        };
        lines.erase(std::remove_if(lines.begin(), lines.end(), is_other), lines.end());
      }
      solve_lines(lines, axis);
      if (is_stopped()) return {};
    }
    return plan_.shard ? RangeOfMotion{} : result();
  }

 private:
  Eigen::Vector3d rotations_rad(const Index& at) const
  {
    return {plan_.axes.rad[0][at[0]], plan_.axes.rad[1][at[1]], plan_.axes.rad[2][at[2]]};
  }

  std::size_t row_of(const Index& at) const { return cell_at(plan_.axes, at[0], at[1], at[2]); }
  bool is_stopped() const { return plan_.is_stopped && plan_.is_stopped(); }

  void solve_lines(const std::vector<Index>& lines, std::size_t axis)
  {
    std::atomic<std::size_t> next_solver = 0;
    for_each_index(lines.size(), static_cast<int>(solvers_.size()), [&] {
      return [&, &solver = *solvers_[next_solver++]](std::size_t k) {
        if (!is_stopped()) solve_line(solver, lines[k], axis);
      };
    });
  }

  // Outward from the neutral value, which an earlier round has solved except for the neutral cell itself.
  void solve_line(CellSolver& solver, Index at, std::size_t axis)
  {
    const auto n = static_cast<std::ptrdiff_t>(plan_.axes.rad[axis].size());
    if (recall_line(at, axis)) return;
    if (axis == 0) solve_cell(solver, at, nullptr);
    const auto middle = static_cast<std::ptrdiff_t>(neutral_[axis]);
    for (const std::ptrdiff_t direction : {-1, 1}) {
      at[axis] = neutral_[axis];
      const SolvedCell* inward = &solved_[row_of(at)];
      for (std::ptrdiff_t k = middle + direction; k >= 0 && k < n; k += direction) {
        at[axis] = static_cast<std::size_t>(k);
        solve_cell(solver, at, inward);
        inward = &solved_[row_of(at)];
      }
    }
    keep_line(at, axis);
  }

  static RomLine line_at(const Index& at, std::size_t axis)
  {
    RomLine line;
    line.axis = static_cast<std::int8_t>(axis);
    for (std::size_t a = 0; a < 3; ++a) line.at[a] = a == axis ? 0 : static_cast<std::int32_t>(at[a]);
    return line;
  }

  bool recall_line(Index at, std::size_t axis)
  {
    if (!plan_.recall) return false;
    const RomLine wanted = line_at(at, axis);
    const std::optional<RomLine> line = plan_.recall(wanted.axis, wanted.at);
    if (!line || line->cells.size() != plan_.axes.rad[axis].size()) return false;
    for (at[axis] = 0; at[axis] < line->cells.size(); ++at[axis]) {
      const bool is_new = axis == 0 || at[axis] != neutral_[axis];
      solved_[row_of(at)] = line->cells[at[axis]];
      if (is_new && plan_.on_progress) plan_.on_progress(++n_done_);
    }
    return true;
  }

  void keep_line(Index at, std::size_t axis) const
  {
    if (!plan_.keep) return;
    RomLine line = line_at(at, axis);
    for (at[axis] = 0; at[axis] < plan_.axes.rad[axis].size(); ++at[axis])
      line.cells.push_back(solved_[row_of(at)]);
    plan_.keep(line);
  }

  void solve_cell(CellSolver& solver, const Index& at, const SolvedCell* inward)
  {
    solved_[row_of(at)] = solver.solve(rotations_rad(at), neutral_mm_, inward);
    if (plan_.on_progress) plan_.on_progress(++n_done_);
  }

  RangeOfMotion result()
  {
    RangeOfMotion range{plan_.axes,
                        plan_.limits,
                        plan_.delta_body,
                        neutral_,
                        scene_.pose_at(rotations_rad(neutral_), neutral_mm_),
                        {}};
    for (const SolvedCell& solved : solved_) range.cells.push_back(solved.cell);
    mark_connected(range);
    return range;
  }

  void mark_connected(RangeOfMotion& range) const
  {
    std::vector<Index> pending;
    const auto visit = [&](const Index& at) {
      RomCell& cell = range.cells[row_of(at)];
      if (cell.status != RomStatus::in_range || cell.is_connected) return;
      cell.is_connected = true;
      pending.push_back(at);
    };
    visit(neutral_);
    while (!pending.empty()) {
      const Index at = pending.back();
      pending.pop_back();
      for (std::size_t axis = 0; axis < 3; ++axis) {
        Index neighbour = at;
        if (at[axis] > 0) {
          neighbour[axis] = at[axis] - 1;
          visit(neighbour);
        }
        if (at[axis] + 1 < plan_.axes.rad[axis].size()) {
          neighbour[axis] = at[axis] + 1;
          visit(neighbour);
        }
      }
    }
  }

  const RomPlan& plan_;
  RomScene scene_;
  Index neutral_{};
  Eigen::Vector3d neutral_mm_ = Eigen::Vector3d::Zero();
  std::vector<SolvedCell> solved_;
  std::vector<std::unique_ptr<CellSolver>> solvers_;
  std::atomic<std::size_t> n_done_ = 0;
};

// Trapezoidal rule; 1 for a rotation that is not driven.
double weight_deg(const std::vector<double>& rad, std::size_t k)
{
  if (rad.size() == 1) return 1.0;
  double width = 0.0;
  if (k > 0) width += 0.5 * (rad[k] - rad[k - 1]);
  if (k + 1 < rad.size()) width += 0.5 * (rad[k + 1] - rad[k]);
  return deg_from_rad(width);
}

}  // namespace

RangeOfMotion range_of_motion(const job::Case& job_case, const RomPlan& plan)
{
  return RomSweep(job_case, plan).run();
}

RomVolume volume_of(const RangeOfMotion& range, const std::function<bool(std::size_t cell)>& counts)
{
  RomVolume volume;
  for (const std::vector<double>& rad : range.axes.rad) volume.n_driven += rad.size() > 1 ? 1 : 0;
  for (std::size_t cell = 0; cell < range.axes.n_cells(); ++cell) {
    const std::array<std::size_t, 3> at = range.axes.rows_at(cell);
    const double weight = weight_deg(range.axes.rad[0], at[0]) * weight_deg(range.axes.rad[1], at[1]) *
                          weight_deg(range.axes.rad[2], at[2]);
    volume.driven_volume += weight;
    if (!counts(cell)) continue;
    ++volume.n_cells;
    volume.volume += weight;
  }
  return volume;
}

RomVolume volume_of(const RangeOfMotion& range)
{
  return volume_of(range, [&](std::size_t cell) { return range.cells[cell].status == RomStatus::in_range; });
}

namespace {

// Features this far above the first contact limit a step. A ball in a cup has thousands within its clearance.
constexpr double band_mm = 0.02;
constexpr double height_tolerance_mm = 1e-5;
constexpr double first_radius_mm = 1.0, largest_radius_mm = 8.0;
constexpr double least_radius_mm = 1e-5;  // the seat is then at a ridge of the height
constexpr double accepted_share = 0.1;    // of the predicted rise
constexpr int max_steps = 200;
// Makes the linear programme strictly convex: a step is shorter where the rise is below 1e-4 of it.
constexpr double convexity_per_mm = 1e-4;

/// Height of the moving object in contact with one feature: height + slope . (x, z).
struct Plane {
  double height_mm = 0.0, slope_x = 0.0, slope_z = 0.0;

  double at(double x, double z) const { return height_mm + slope_x * x + slope_z * z; }
};

Plane plane_of(const geometry::GapFeature& feature, const MovingPose& pose)
{
  const double slope_x = -feature.normal.x() / feature.normal.y();
  const double slope_z = -feature.normal.z() / feature.normal.y();
  const Eigen::Vector3d& t = pose.translation_mm;
  return {t.y() + feature.travel_mm - slope_x * t.x() - slope_z * t.z(), slope_x, slope_z};
}

class SeatSearch {
 public:
  SeatSearch(geometry::GapQuery& query, const SeatTask& task) : query_(query), task_(task) {}

  Seat run()
  {
    MovingPose start = task_.centre;
    start.translation_mm += Eigen::Vector3d(task_.start_mm.x(), 0.0, task_.start_mm.y());
    if (!measure(start)) return {};
    seat_ = trial_;
    planes_ = trial_planes_;
    double radius_mm = first_radius_mm;
    for (int step = 0; step < max_steps && !seat_.is_converged; ++step) {
      const Eigen::Vector3d d = highest_point(radius_mm);
      if (d.z() <= height_tolerance_mm || radius_mm <= least_radius_mm) {
        seat_.is_converged = true;
        break;
      }
      MovingPose next = seat_.pose;
      next.translation_mm += Eigen::Vector3d(d.x(), d.z(), d.y());
      const double height_mm = seat_.pose.translation_mm.y();
      if (!measure(next)) {
        radius_mm *= 0.5;
      } else if (trial_.pose.translation_mm.y() - height_mm > accepted_share * d.z()) {
        seat_ = trial_;
        planes_ = trial_planes_;
        radius_mm = std::min(2.0 * radius_mm, largest_radius_mm);
      } else {
        planes_.insert(planes_.end(), trial_planes_.begin(), trial_planes_.end());
        radius_mm = 0.5 * std::min(radius_mm, std::max(std::abs(d.x()), std::abs(d.y())));
      }
    }
    seat_.is_found = true;
    return seat_;
  }

 private:
  // Moves the pose along Delta into contact. False: nothing ahead.
  bool measure(const MovingPose& pose)
  {
    const geometry::GapResult& found = query_.features(pose, band_mm);
    if (found.pair.reference < 0) return false;
    trial_ = {pose, found.features, true, false};
    trial_.pose.translation_mm.y() += found.travel_mm;
    for (geometry::GapFeature& feature : trial_.contacts) {
      feature.travel_mm -= found.travel_mm;
      feature.point_mm.y() += found.travel_mm;
    }
    trial_planes_.clear();
    for (const geometry::GapFeature& feature : trial_.contacts)
      trial_planes_.push_back(plane_of(feature, trial_.pose));
    return true;
  }

  // Displacement along X and Z, and the rise, to the highest point below all planes within the radius and the
  // limit.
  Eigen::Vector3d highest_point(double radius_mm)
  {
    const Eigen::Vector3d& t = seat_.pose.translation_mm;
    half_spaces_.clear();
    for (const Plane& plane : planes_) {
      solve::QpVector row = solve::QpVector::Zero();
      row.head<3>() = Eigen::Vector3d(plane.slope_x, plane.slope_z, -1.0);
      const double clearance_mm = plane.at(t.x(), t.z()) - t.y(), length = row.norm();
      half_spaces_.push_back({row / length, -clearance_mm / length});
    }
    const Eigen::Vector2d away(t.x() - task_.centre.translation_mm.x(),
                               t.z() - task_.centre.translation_mm.z());
    for (int k = 0; k < 2; ++k) {
      for (const double sign : {1.0, -1.0}) {
        solve::QpVector row = solve::QpVector::Zero();
        row[k] = sign;
        const double room_mm = std::max(0.0, task_.limit_mm + sign * away[k]);
        half_spaces_.push_back({row, -std::min(radius_mm, room_mm)});
      }
    }
    // The programme has room for five coordinates; the last two stay 0.
    solve::QpMatrix H = solve::QpMatrix::Identity();
    H.diagonal().head<3>().setConstant(convexity_per_mm);
    const solve::QpSolution solution =
        solve::solve_quadratic_program<5>(H, -solve::QpVector::Unit(2), half_spaces_);
    return solution.is_solved ? Eigen::Vector3d(solution.d.head<3>()) : Eigen::Vector3d::Zero();
  }

  geometry::GapQuery& query_;
  const SeatTask& task_;
  Seat seat_, trial_;
  std::vector<Plane> planes_, trial_planes_;
  std::vector<solve::HalfSpace> half_spaces_;
};

}  // namespace

Seat highest_seat(geometry::GapQuery& query, const SeatTask& task)
{
  return SeatSearch(query, task).run();
}

}  // namespace vrda::analysis
