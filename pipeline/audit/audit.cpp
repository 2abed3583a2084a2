#include "audit/audit.hpp"

#include <algorithm>
#include <cmath>

#include "audit/pose_meter.hpp"
#include "core/error.hpp"
#include "core/units.hpp"
#include "solve/potential.hpp"

namespace vrda::audit {
namespace {

/// A pose to measure, if the motion has one at the attitude.
struct AuditPose {
  Attitude attitude;
  Pose X_reference_moving = Pose::Identity();
  bool has_pose = false;
};

bool is_node(const store::AuditSet& out, Eigen::Index i, Eigen::Index j)
{
  return i % out.refine == 0 && j % out.refine == 0;
}

AuditPose pose_of(const motion::Motion& motion, const Attitude& attitude)
{
  const motion::JointPose pose = motion.at(attitude);
  return {pose.attitude, pose.X_reference_moving, pose.status == motion::PoseStatus::solved};
}

AuditPose stored_pose(const store::MotionModel& model, Eigen::Index flexion, Eigen::Index varus)
{
  AuditPose pose;
  pose.has_pose = model.status(flexion, varus) == status_stable;
  if (!pose.has_pose) return pose;
  pose.attitude = {rad_from_deg(model.flexion_deg[static_cast<std::size_t>(flexion)]),
                   rad_from_deg(model.varus_solved_deg(flexion, varus))};
  const auto cell = static_cast<std::size_t>(flexion * model.status.cols() + varus);
  pose.X_reference_moving = store::pose_in(model.X_reference_moving, cell);
  return pose;
}

AuditPose pose_at(const store::MotionModel& model, const motion::Motion& motion, const store::AuditSet& out,
                  Eigen::Index i, Eigen::Index j)
{
  if (out.name == "raw" && is_node(out, i, j)) return stored_pose(model, i / out.refine, j / out.refine);
  return pose_of(motion, {rad_from_deg(out.flexion_deg[static_cast<std::size_t>(i)]),
                          rad_from_deg(out.varus_deg[static_cast<std::size_t>(j)])});
}

void set_state(store::AuditSet& out, Eigen::Index i, Eigen::Index j, const PoseAudit& found)
{
  out.penetration_mm(i, j) = found.penetration_mm;
  store::AuditState state = store::AuditState::free;
  if (found.is_overlapping) {
    state = store::AuditState::overlapping;
  } else if (std::isinf(found.gap_mm)) {
    state = store::AuditState::nothing_ahead;
  } else {
    out.gap_mm(i, j) = found.gap_mm;
  }
  out.state(i, j) = static_cast<std::int8_t>(state);
}

store::AuditSet unmeasured(const store::MotionModel& model, const std::string& set, int refine)
{
  store::AuditSet out;
  out.name = set;
  out.refine = refine;
  const bool is_two_sided = set == "two_sided";
  out.flexion_deg = refined(is_two_sided ? model.two_sided->flexion_deg : model.flexion_deg, refine);
  out.varus_deg =
      is_two_sided || set == "zero_varus" ? std::vector<double>{0.0} : refined(model.varus_deg, refine);
  const auto rows = static_cast<Eigen::Index>(out.flexion_deg.size());
  const auto columns = static_cast<Eigen::Index>(out.varus_deg.size());
  out.state = store::GridB::Constant(rows, columns, static_cast<std::int8_t>(store::AuditState::no_pose));
  out.gap_mm = store::GridD::Constant(rows, columns, nan);
  out.penetration_mm = store::GridD::Constant(rows, columns, nan);
  if (model.has_compartments) out.gap_medial_mm = out.gap_lateral_mm = out.penetration_mm;
  return out;
}

void take_larger(AuditExtreme& extreme, const AuditExtreme& found)
{
  if (found.value_mm > extreme.value_mm) extreme = found;
}

}  // namespace

store::AuditSet audit(const store::MotionModel& model, const std::string& set, int refine, int n_threads)
{
  check(refine >= 1, "an audit divides a cell into at least one part");
  const motion::Motion motion(model, set);
  store::AuditSet out = unmeasured(model, set, refine);
  for_each_row(model, motion, out.flexion_deg, n_threads, [&](std::size_t row, PoseMeter& meter) {
    const auto i = static_cast<Eigen::Index>(row);
    for (Eigen::Index j = 0; j < out.state.cols(); ++j) {
      const AuditPose pose = pose_at(model, motion, out, i, j);
      const OverlapTest judge = is_node(out, i, j) ? OverlapTest::narrow_phase : OverlapTest::sweep;
      if (!pose.has_pose) continue;
      set_state(out, i, j, meter.measure(pose.attitude, pose.X_reference_moving, judge));
      if (!model.has_compartments) continue;
      const CompartmentGaps gaps = meter.compartment_gaps(pose.attitude, pose.X_reference_moving);
      out.gap_medial_mm(i, j) = gaps.medial_mm;
      out.gap_lateral_mm(i, j) = gaps.lateral_mm;
    }
  });
  return out;
}

AuditFigures figures_of(const store::AuditSet& audit)
{
  AuditFigures figures;
  figures.two_sided = store::two_sided_figures(audit);
  int n_free = 0;
  for (Eigen::Index i = 0; i < audit.state.rows(); ++i) {
    for (Eigen::Index j = 0; j < audit.state.cols(); ++j) {
      const auto state = static_cast<store::AuditState>(audit.state(i, j));
      if (state == store::AuditState::no_pose) continue;
      ++figures.n_poses;
      const double flexion_deg = audit.flexion_deg[static_cast<std::size_t>(i)];
      const double varus_deg = audit.varus_deg[static_cast<std::size_t>(j)];
      if (state == store::AuditState::overlapping) {
        ++figures.n_overlapping;
        figures.mean_penetration_mm += audit.penetration_mm(i, j);
        take_larger(figures.largest_penetration, {audit.penetration_mm(i, j), flexion_deg, varus_deg});
      } else if (state == store::AuditState::nothing_ahead) {
        ++figures.n_nothing_ahead;
      } else {
        ++n_free;
        figures.mean_gap_mm += audit.gap_mm(i, j);
        take_larger(figures.largest_gap, {audit.gap_mm(i, j), flexion_deg, varus_deg});
      }
    }
  }
  if (n_free > 0) figures.mean_gap_mm /= n_free;
  if (figures.n_overlapping > 0) figures.mean_penetration_mm /= figures.n_overlapping;
  return figures;
}

namespace {

// Search range for the contact of a neighbouring pose, in resolutions: sufficient next to a wall of slope 4
// (76 degrees). Steeper ones are left to the narrow phase.
constexpr double range_resolutions = 4.0;
// Far above the rounding of heights (about 1e-12 mm) and below the slope that the solvers treat as level:
// 1e-3 in the search (solve/stability_search.cpp).
constexpr double level_slope = 1e-3;

Loads loads_of(const store::MotionModel& model, Eigen::Index flexion, const SolverFrame& frame)
{
  Loads loads;
  loads.force_n = Eigen::Vector3d::UnitY();  // the only load of the stability search
  if (!model.equilibrium) return loads;
  const auto row = static_cast<std::size_t>(flexion);
  loads.force_n = solver_translation_mm(frame, model.push.force_n.row(flexion).transpose());
  loads.point_mm = solver_translation_mm(frame, model.push.point_mm);
  loads.moment_nmm = model.push.moment_nmm[row];
  loads.varus_moment_nmm = model.push.varus_moment_nmm[row];
  return loads;
}

// Unit steps along what the solver leaves free; a step back is the other side.
std::vector<Vector5d> free_directions(bool is_varus_free)
{
  const double half = std::sqrt(0.5);
  std::vector<Vector5d> directions(4, Vector5d::Zero());
  directions[0](along_x) = 1.0;
  directions[1](along_z) = 1.0;
  directions[2](along_x) = directions[2](along_z) = half;
  directions[3](along_x) = half;
  directions[3](along_z) = -half;
  directions.push_back(Vector5d::Unit(about_y));
  if (is_varus_free) directions.push_back(Vector5d::Unit(about_varus));
  return directions;
}

/// A configuration and its travel along Delta into contact.
struct ContactTravel {
  solve::Configuration configuration;
  double travel_mm = 0.0;
};

/// Assesses the stable poses of one row of the grid.
class RowAssessor {
 public:
  RowAssessor(const store::MotionModel& model, Eigen::Index flexion, const ligament::Ligaments& canonical,
              PoseMeter& meter)
      : model_(model),
        flexion_(flexion),
        meter_(meter),
        resolution_mm_(model.contact_resolution_mm),
        rotation_scale_(solve::rotation_scale_of(meter.scene().moving.mesh)),
        ligaments_(ligament::solver_ligaments(canonical, meter.scene().frame)),
        loads_(loads_of(model, flexion, meter.scene().frame)),
        forces_{ligaments_, loads_, rotation_scale_,
                rad_from_deg(model.flexion_deg[static_cast<std::size_t>(flexion)])}
  {
  }

  void assess(Eigen::Index varus, bool is_varus_free, PoseAssessment& verdicts)
  {
    const Attitude attitude{forces_.flexion_rad, rad_from_deg(model_.varus_solved_deg(flexion_, varus))};
    const std::size_t cell = static_cast<std::size_t>(flexion_ * model_.status.cols() + varus);
    const PoseAudit found =
        meter_.measure(attitude, store::pose_in(model_.X_reference_moving, cell), OverlapTest::sweep);
    verdicts.is_overlapping(flexion_, varus) = found.is_overlapping ? 1 : 0;
    if (found.is_overlapping) return;
    Plausibility plausibility = Plausibility::nothing_found;
    if (is_held_by_contact(cell)) {
      plausibility = found.gap_mm > resolution_mm_
                         ? Plausibility::nothing_ahead
                         : neighbour_plausibility(attitude, found.gap_mm, is_varus_free);
    }
    verdicts.plausibility(flexion_, varus) = static_cast<std::int8_t>(plausibility);
  }

 private:
  bool is_held_by_contact(std::size_t cell) const
  {
    if (!model_.equilibrium) return true;
    const std::vector<std::int64_t>& row_start = model_.equilibrium->forces.row_start;
    return row_start[cell + 1] > row_start[cell];
  }

  Plausibility neighbour_plausibility(const Attitude& attitude, double gap_mm, bool is_varus_free)
  {
    const std::optional<MovingPose> pose = meter_.solver_pose();
    if (!pose) return Plausibility::nothing_found;
    const solve::Configuration here = solve::configuration_at(*pose, attitude.varus_rad, rotation_scale_);
    const ContactTravel start{here, gap_mm};
    for (const Vector5d& direction : free_directions(is_varus_free)) {
      const ContactTravel one =
          contact_travel(solve::moved(here, resolution_mm_ * direction, rotation_scale_));
      const ContactTravel other =
          contact_travel(solve::moved(here, -resolution_mm_ * direction, rotation_scale_));
      const double furthest_mm = std::max(one.travel_mm, other.travel_mm);
      if (std::isfinite(furthest_mm) && is_lower_both_ways(start, one, other))
        return Plausibility::unstable_balance;
      if (furthest_mm > resolution_mm_) return Plausibility::nothing_ahead;
    }
    return Plausibility::nothing_found;
  }

  ContactTravel contact_travel(const solve::Configuration& configuration)
  {
    return {configuration, meter_.travel_near_mm({forces_.flexion_rad, configuration.varus_rad},
                                                 solve::pose_at(configuration, rotation_scale_),
                                                 range_resolutions * resolution_mm_)};
  }

  bool is_lower_both_ways(const ContactTravel& start, const ContactTravel& one,
                          const ContactTravel& other) const
  {
    const double level_mm = level_slope * resolution_mm_;
    // In equilibrium the slope along the path is 0, so only its curvature can lower the energy on both sides.
    // This check avoids most computations of fibre paths.
    if (one.travel_mm + other.travel_mm - 2.0 * start.travel_mm <= 2.0 * level_mm) return false;
    const double least_nmm = energy_nmm(start) - level_mm * loads_.force_n.norm();
    return energy_nmm(one) < least_nmm && energy_nmm(other) < least_nmm;
  }

  double energy_nmm(const ContactTravel& travel) const
  {
    solve::Configuration configuration = travel.configuration;
    configuration.pivot_mm.y() += travel.travel_mm;
    return solve::potential_at(forces_, configuration).energy_nmm;
  }

  const store::MotionModel& model_;
  Eigen::Index flexion_;
  PoseMeter& meter_;
  double resolution_mm_;
  solve::RotationScale rotation_scale_;
  ligament::Ligaments ligaments_;
  Loads loads_;
  solve::NonContactForces forces_;
};

}  // namespace

PoseAssessment assess_poses(const store::MotionModel& model, const ligament::Ligaments& ligaments,
                            int n_threads)
{
  const motion::Motion motion(model, "raw");
  PoseAssessment verdicts;
  verdicts.is_overlapping = store::GridB::Zero(model.status.rows(), model.status.cols());
  verdicts.plausibility =
      store::GridB::Constant(model.status.rows(), model.status.cols(), plausibility_not_judged);
  for_each_row(model, motion, model.flexion_deg, n_threads, [&](std::size_t row, PoseMeter& meter) {
    const auto i = static_cast<Eigen::Index>(row);
    RowAssessor assessor(model, i, ligaments, meter);
    for (Eigen::Index j = 0; j < model.status.cols(); ++j) {
      if (model.status(i, j) == status_stable) assessor.assess(j, motion.is_varus_free(), verdicts);
    }
  });
  return verdicts;
}

store::GridD recontact(const store::MotionModel& model, const store::SmoothedSet& set, int n_threads)
{
  const motion::Motion motion(model, set);
  store::GridD travel_mm(static_cast<Eigen::Index>(model.flexion_deg.size()),
                         static_cast<Eigen::Index>(model.varus_deg.size()));
  for_each_row(model, motion, model.flexion_deg, n_threads, [&](std::size_t row, PoseMeter& meter) {
    for (Eigen::Index j = 0; j < travel_mm.cols(); ++j) {
      const motion::JointPose pose = motion.at(
          {rad_from_deg(model.flexion_deg[row]), rad_from_deg(model.varus_deg[static_cast<std::size_t>(j)])});
      travel_mm(static_cast<Eigen::Index>(row), j) =
          meter.travel_into_contact_mm(pose.attitude, pose.X_reference_moving);
    }
  });
  return travel_mm;
}

}  // namespace vrda::audit
