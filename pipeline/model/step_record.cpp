#include "model/step_record.hpp"

#include "core/error.hpp"

namespace vrda::inline model {

const char* name_of(StepStatus status)
{
  switch (status) {
    case StepStatus::pending:
      return "pending";
    case StepStatus::stable:
      return "stable";
    case StepStatus::no_contact:
      return "no_contact";
    case StepStatus::no_clearance:
      return "no_clearance";
    case StepStatus::iteration_limit:
      return "iteration_limit";
    case StepStatus::unbounded:
      return "unbounded";
    case StepStatus::overlapping:
      return "overlapping";
  }
  throw InternalError("a step status without a name");
}

const char* meaning_of(StepStatus status)
{
  switch (status) {
    case StepStatus::pending:
      return "not solved yet";
    case StepStatus::stable:
      return "stable pose found";
    case StepStatus::no_contact:
      return "no reference surface along Delta: the objects separated or never met";
    case StepStatus::no_clearance:
      return "no collision-free pose within reach along -Delta: the objects stay interlocked";
    case StepStatus::iteration_limit:
      return "not converged within max_steps or max_iterations";
    case StepStatus::unbounded:
      return "no equilibrium: the loads push the moving object off the reference";
    case StepStatus::overlapping:
      return "equilibrium found, but the meshes overlap there: check their winding with vrda check";
  }
  throw InternalError("a step status without a meaning");
}

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
    case StepKind::sample:
      return "sample";
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
  for (std::size_t k = 0; r.coordinates && k < n_joint_coordinates; ++k) {
    if (is_rotation(k)) r.coordinates->holding[k] *= factor;
  }
  // residual_n is unchanged: its moments are divided by a lever that scales by the same factor.
  for (ContactForce& force : r.balance.forces) force.point_solver_mm *= factor;
  return r;
}

const char* name_of(MoveKind kind)
{
  switch (kind) {
    case MoveKind::retreat:
      return "retreat";
    case MoveKind::approach:
      return "approach";
    case MoveKind::bisect:
      return "bisect";
    case MoveKind::rotate:
      return "rotate";
    case MoveKind::iterate:
      return "iterate";
    case MoveKind::trial:
      return "trial";
    case MoveKind::translate:
      return "translate";
  }
  throw InternalError("a move without a name");
}

}  // namespace vrda::inline model
