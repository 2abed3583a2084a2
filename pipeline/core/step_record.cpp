#include "core/step_record.hpp"

#include "core/error.hpp"

namespace vrda {

const char* name_of(StepKind kind)
{
  switch (kind) {
    case StepKind::spine_probe:
      return "spine_probe";
    case StepKind::spine:
      return "spine";
    case StepKind::row:
      return "row";
    case StepKind::free_spine:
      return "free_spine";
    case StepKind::band:
      return "band";
  }
  throw InternalError("a kind of step without a name");
}

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

}  // namespace vrda
