#include "analysis/pose_assessment.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "analysis/pose_meter.hpp"
#include "model/plausibility.hpp"
#include "core/units.hpp"
#include "solve/potential.hpp"

namespace vrda::analysis {
namespace {

// Search range for the contact of a neighbouring pose, in resolutions: sufficient next to a wall of slope 4
// (76 degrees). Steeper ones are left to the narrow phase.
constexpr double range_resolutions = 4.0;
// Features of this band bound the travel after a step of one resolution on slopes up to 60 degrees.
constexpr double band_resolutions = 2.0;
// Far above the rounding of heights (about 1e-12 mm) and below the slope that the solvers treat as level:
// 1e-3 in the search (solve/stability_search.cpp).
constexpr double level_slope = 1e-3;

Eigen::Vector3d vector_at(const std::vector<double>& rows, std::size_t row)
{
  return {rows[3 * row], rows[3 * row + 1], rows[3 * row + 2]};
}

void add_applied(const store::LoadRows& rows, std::size_t flexion, const SolverFrame& frame, Loads& loads)
{
  for (std::size_t k = 0; k < rows.name.size(); ++k) {
    const std::size_t at = flexion * rows.name.size() + k;
    loads.applied.push_back(
        {static_cast<LoadFrame>(rows.frame[k]), solver_translation_mm(frame, vector_at(rows.force_n, at)),
         solver_moment_nmm(frame, vector_at(rows.moment_nmm, at)),
         solver_translation_mm(frame, rows.point_mm.row(static_cast<Eigen::Index>(k)).transpose())});
  }
}

// Between the last point on the reference and the first on the moving object.
void add_lines(const store::LineRows& rows, std::size_t flexion, const SolverFrame& frame, Loads& loads)
{
  const std::size_t n_lines = rows.name.size();
  for (std::size_t p = 0; p + 1 < rows.point_line.size(); ++p) {
    const bool is_free_segment = rows.point_line[p] == rows.point_line[p + 1] && rows.point_body[p] == 0 &&
                                 rows.point_body[p + 1] == 1;
    if (!is_free_segment) continue;
    const auto row = static_cast<Eigen::Index>(p);
    loads.lines.push_back({rows.tension_n[flexion * n_lines + static_cast<std::size_t>(rows.point_line[p])],
                           solver_translation_mm(frame, rows.point_mm.row(row).transpose()),
                           solver_translation_mm(frame, rows.point_mm.row(row + 1).transpose())});
  }
}

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
  if (model.push.loads) add_applied(*model.push.loads, row, frame, loads);
  if (model.push.lines) add_lines(*model.push.lines, row, frame, loads);
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

// Failure of an anterior cruciate ligament (Noyes and Grood 1976).
constexpr double largest_strain = 0.44;
constexpr double largest_bundle_n = 1730.0;

/// The edges at which the surfaces of both objects end.
struct Borders {
  std::vector<std::int8_t> reference, moving;
};

bool is_overstrained(const store::LigamentRows& rows, std::size_t cell)
{
  const std::size_t n = rows.name.size();
  std::map<std::string, double> bundle_n;
  for (std::size_t k = 0; k < n; ++k) {
    if (rows.strain[cell * n + k] > largest_strain) return true;
    double& tension_n = bundle_n[rows.bundle[k]];
    tension_n += rows.tension_n[cell * n + k];
    if (tension_n > largest_bundle_n) return true;
  }
  return false;
}

/// A configuration and its travel along Delta into contact.
struct ContactTravel {
  solve::Configuration configuration;
  double travel_mm = 0.0;
};

/// Assesses the stable poses of one row of the grid.
class RowAssessor {
 public:
  RowAssessor(const store::MotionModel& model, Eigen::Index flexion, const model::Ligaments& canonical,
              const JointBounds& bounds, const Borders& borders, PoseMeter& meter)
      : model_(model),
        flexion_(flexion),
        bounds_(bounds),
        borders_(borders),
        meter_(meter),
        resolution_mm_(model.contact_resolution_mm),
        rotation_scale_(solve::rotation_scale_of(meter.scene().moving.mesh)),
        ligaments_(model::solver_ligaments(canonical, meter.scene().frame)),
        loads_(loads_of(model, flexion, meter.scene().frame)),
        forces_{ligaments_, loads_, rotation_scale_,
                rad_from_deg(model.flexion_deg[static_cast<std::size_t>(flexion)])}
  {
    if (!loads_.applied.empty() || !loads_.lines.empty()) forces_.applied = &applied_;
  }

  void assess(Eigen::Index varus, bool is_varus_free, PoseAssessment& verdicts)
  {
    const Attitude attitude{forces_.flexion_rad, rad_from_deg(model_.varus_solved_deg(flexion_, varus))};
    const std::size_t cell = static_cast<std::size_t>(flexion_ * model_.status.cols() + varus);
    const PoseAudit found =
        meter_.measure(attitude, store::pose_in(model_.X_reference_moving, cell), OverlapTest::sweep);
    verdicts.is_overlapping(flexion_, varus) = found.is_overlapping ? 1 : 0;
    if (found.is_overlapping) return;
    verdicts.plausibility(flexion_, varus) =
        static_cast<std::int8_t>(plausibility_of(cell, attitude, found.gap_mm, is_varus_free));
  }

 private:
  Plausibility plausibility_of(std::size_t cell, const Attitude& attitude, double gap_mm, bool is_varus_free)
  {
    const std::optional<MovingPose> pose = meter_.solver_pose();
    if (pose && !is_within(bounds_, meter_.scene().frame, *pose)) return Plausibility::dislocated;
    if (pose && has_border_contact(cell, attitude, *pose)) return Plausibility::border_contact;
    if (model_.ligaments && is_overstrained(*model_.ligaments, cell)) return Plausibility::overstrained;
    if (!is_held_by_contact(cell)) return Plausibility::nothing_found;
    if (gap_mm > resolution_mm_) return Plausibility::nothing_ahead;
    return neighbour_plausibility(attitude, gap_mm, is_varus_free);
  }

  bool has_border_contact(std::size_t cell, const Attitude& attitude, const MovingPose& pose) const
  {
    const AuditScene& scene = meter_.scene();
    const store::ContactRows& rows = model_.contacts;
    const Eigen::Matrix3d R_reference_solver = reference_rotation(attitude).transpose();
    const Pose X_moving_solver = pose_of(pose).inverse();
    for (std::int64_t i = rows.row_start[cell]; i < rows.row_start[cell + 1]; ++i) {
      const auto k = static_cast<std::size_t>(i);
      const Eigen::Vector3d p_mm = solver_translation_mm(scene.frame, rows.point_world_mm.row(i).transpose());
      // The moving surface is at most the contact's distance away from the point.
      if (is_at_border(scene.reference.mesh, borders_.reference, rows.triangle_reference[k],
                       R_reference_solver * p_mm, resolution_mm_) ||
          is_at_border(scene.moving.mesh, borders_.moving, rows.triangle_moving[k], X_moving_solver * p_mm,
                       resolution_mm_ + rows.distance_mm[k]))
        return true;
    }
    return false;
  }

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
    // About this pose, of whose neighbours the energies are compared.
    applied_ = solve::potential_near(loads_, attitude, *pose);
    meter_.note_features(band_resolutions * resolution_mm_);
    for (const Vector5d& direction : free_directions(is_varus_free)) {
      if (is_clearly_held(start, direction)) continue;
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

  // By upper bounds of both travels: most directions of most poses need no query.
  bool is_clearly_held(const ContactTravel& start, const Vector5d& direction)
  {
    double sum_mm = 0.0;
    for (const double side : {1.0, -1.0}) {
      const solve::Configuration aside =
          solve::moved(start.configuration, side * resolution_mm_ * direction, rotation_scale_);
      const double bound_mm = meter_.travel_near_bound_mm({forces_.flexion_rad, aside.varus_rad},
                                                          solve::pose_at(aside, rotation_scale_));
      if (!(bound_mm <= resolution_mm_) || bound_mm < -range_resolutions * resolution_mm_) return false;
      sum_mm += bound_mm;
    }
    return is_level(start.travel_mm, sum_mm);
  }

  // In equilibrium the slope along the path is 0, so only its curvature can lower the energy on both sides.
  bool is_level(double start_mm, double sum_mm) const
  {
    return sum_mm - 2.0 * start_mm <= 2.0 * level_slope * resolution_mm_;
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
    if (is_level(start.travel_mm, one.travel_mm + other.travel_mm)) return false;
    const double least_nmm = energy_nmm(start) - level_slope * resolution_mm_ * loads_.force_n.norm();
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
  const JointBounds& bounds_;
  const Borders& borders_;
  PoseMeter& meter_;
  double resolution_mm_;
  solve::RotationScale rotation_scale_;
  model::Ligaments ligaments_;
  Loads loads_;
  solve::LoadPotential applied_;
  solve::NonContactForces forces_;
};

}  // namespace

PoseAssessment assess_poses(const store::MotionModel& model, const model::Ligaments& ligaments,
                            const JointBounds& bounds, int n_threads)
{
  const store::Motion motion(model, "raw");
  PoseAssessment verdicts;
  verdicts.is_overlapping = store::GridB::Zero(model.status.rows(), model.status.cols());
  verdicts.plausibility =
      store::GridB::Constant(model.status.rows(), model.status.cols(), plausibility_not_judged);
  const Borders borders{boundary_edges(model.reference.contact.mesh),
                        boundary_edges(model.moving.contact.mesh)};
  std::vector<Eigen::Vector3d> deltas;
  for (Eigen::Index i = 0; i < model.push.delta.rows(); ++i)
    deltas.emplace_back(model.push.delta.row(i).transpose());
  for_each_delta(model, deltas, n_threads, [&](std::size_t row, PoseMeter& meter) {
    const auto i = static_cast<Eigen::Index>(row);
    RowAssessor assessor(model, i, ligaments, bounds, borders, meter);
    for (Eigen::Index j = 0; j < model.status.cols(); ++j) {
      if (model.status(i, j) == status_stable) assessor.assess(j, motion.is_varus_free(), verdicts);
    }
  });
  return verdicts;
}

}  // namespace vrda::analysis
