#include "audit/plausibility.hpp"

#include <algorithm>
#include <cmath>

#include "audit/attitude_rows.hpp"
#include "core/units.hpp"
#include "solve/potential.hpp"
#include "store/solved_cells.hpp"

namespace vrda {
namespace {

// Looks for the touch of a neighbouring pose this many resolutions either way: beside a wall as steep as 1 :
// 4 (76 degrees) it is there. Steeper ones are left to the narrow phase.
constexpr double range_resolutions = 4.0;
// Far above the rounding of heights, some 1e-12 mm, and below the rise of a slope that the solvers take for
// level: a thousandth in the search (solve/stability_search.cpp).
constexpr double level_slope = 1e-3;

Loads loads_of(const MotionModel& model, Eigen::Index flexion, const SolverFrame& frame)
{
  Loads loads;
  loads.force_n = Eigen::Vector3d::UnitY();  // all that the stability search knows
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

/// How far along Delta a place is from contact.
struct Landing {
  Place place;
  double travel_mm = 0.0;
};

/// The stable poses of one row of the grid.
class RowJudge {
 public:
  RowJudge(const MotionModel& model, Eigen::Index flexion, const Ligaments& canonical, PoseMeter& meter)
      : model_(model),
        flexion_(flexion),
        meter_(meter),
        resolution_mm_(model.contact_resolution_mm),
        grip_(grip_of(meter.scene().moving.mesh)),
        ligaments_(solver_ligaments(canonical, meter.scene().frame)),
        loads_(loads_of(model, flexion, meter.scene().frame)),
        forces_{ligaments_, loads_, grip_, rad_from_deg(model.flexion_deg[static_cast<std::size_t>(flexion)])}
  {
  }

  void judge(Eigen::Index varus, bool is_varus_free, PoseVerdicts& verdicts)
  {
    const Attitude attitude{forces_.flexion_rad, rad_from_deg(model_.varus_solved_deg(flexion_, varus))};
    const std::size_t cell = static_cast<std::size_t>(flexion_ * model_.status.cols() + varus);
    const PoseAudit found = meter_.measure(attitude, pose_in(model_.X_reference_moving, cell), Judge::sweep);
    verdicts.is_overlapping(flexion_, varus) = found.is_overlapping ? 1 : 0;
    if (found.is_overlapping) return;
    Plausibility plausibility = Plausibility::nothing_found;
    if (is_held_by_contact(cell)) {
      plausibility = found.gap_mm > resolution_mm_ ? Plausibility::nothing_ahead
                                                   : beside(attitude, found.gap_mm, is_varus_free);
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

  Plausibility beside(const Attitude& attitude, double gap_mm, bool is_varus_free)
  {
    const std::optional<MovingPose> pose = meter_.solver_pose();
    if (!pose) return Plausibility::nothing_found;
    const Place here = place_at(*pose, attitude.varus_rad, grip_);
    const Landing start{here, gap_mm};
    for (const Vector5d& direction : free_directions(is_varus_free)) {
      const Landing one = landing(moved(here, resolution_mm_ * direction, grip_));
      const Landing other = landing(moved(here, -resolution_mm_ * direction, grip_));
      const double furthest_mm = std::max(one.travel_mm, other.travel_mm);
      if (std::isfinite(furthest_mm) && is_lower_both_ways(start, one, other))
        return Plausibility::unstable_balance;
      if (furthest_mm > resolution_mm_) return Plausibility::nothing_ahead;
    }
    return Plausibility::nothing_found;
  }

  Landing landing(const Place& place)
  {
    return {place, meter_.travel_near_mm({forces_.flexion_rad, place.varus_rad}, pose_at(place, grip_),
                                         range_resolutions * resolution_mm_)};
  }

  bool is_lower_both_ways(const Landing& start, const Landing& one, const Landing& other) const
  {
    const double level_mm = level_slope * resolution_mm_;
    // A pose in balance gains along no way, so that only a bend of the way lowers the energy on both sides.
    // Spares most fibres' paths.
    if (one.travel_mm + other.travel_mm - 2.0 * start.travel_mm <= 2.0 * level_mm) return false;
    const double least_nmm = energy_nmm(start) - level_mm * loads_.force_n.norm();
    return energy_nmm(one) < least_nmm && energy_nmm(other) < least_nmm;
  }

  double energy_nmm(const Landing& landing) const
  {
    Place place = landing.place;
    place.pivot_mm.y() += landing.travel_mm;
    return potential_at(forces_, place).energy_nmm;
  }

  const MotionModel& model_;
  Eigen::Index flexion_;
  PoseMeter& meter_;
  double resolution_mm_;
  Grip grip_;
  Ligaments ligaments_;
  Loads loads_;
  Forces forces_;
};

}  // namespace

PoseVerdicts pose_verdicts(const MotionModel& model, const Ligaments& ligaments, int n_threads)
{
  const Motion motion(model, "raw");
  PoseVerdicts verdicts;
  verdicts.is_overlapping = GridB::Zero(model.status.rows(), model.status.cols());
  verdicts.plausibility = GridB::Constant(model.status.rows(), model.status.cols(), plausibility_not_judged);
  for_each_row(model, motion, model.flexion_deg, n_threads, [&](std::size_t row, PoseMeter& meter) {
    const auto i = static_cast<Eigen::Index>(row);
    RowJudge judge(model, i, ligaments, meter);
    for (Eigen::Index j = 0; j < model.status.cols(); ++j) {
      if (model.status(i, j) == status_stable) judge.judge(j, motion.is_varus_free(), verdicts);
    }
  });
  return verdicts;
}

}  // namespace vrda
