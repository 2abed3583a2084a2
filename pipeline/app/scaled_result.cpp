#include "app/scaled_result.hpp"

namespace vrda {

StepRecord scaled(const StepRecord& record, double factor)
{
  StepRecord r = record;
  r.pose.translation_mm *= factor;
  r.residual_mm *= factor;
  r.gap_medial_mm *= factor;
  r.gap_lateral_mm *= factor;
  for (ContactRecord& contact : r.contacts) {
    contact.point_solver_mm *= factor;
    contact.distance_mm *= factor;
  }
  r.balance.energy_nmm *= factor;
  r.balance.complementarity_mm *= factor;
  r.balance.worst_gap_mm *= factor;
  r.balance.flexion_moment_nmm *= factor;
  r.balance.varus_moment_nmm *= factor;
  // The residual's moments are divided by a lever that grows along: it stays.
  for (ContactForce& force : r.balance.forces) force.point_solver_mm *= factor;
  return r;
}

SweepResult scaled(const SweepResult& result, double factor)
{
  SweepResult out = result;
  for (StepRecord& r : out.cells) r = scaled(r, factor);
  for (FreeSpineStep& step : out.free_spine) {
    step.chosen = scaled(step.chosen, factor);
    step.band_low = scaled(step.band_low, factor);
    step.band_high = scaled(step.band_high, factor);
    step.energy_spread_nmm *= factor;
  }
  return out;
}

}  // namespace vrda
