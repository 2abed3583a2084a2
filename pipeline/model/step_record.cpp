#include "model/step_record.hpp"

#include "core/text.hpp"
#include "core/units.hpp"
#include "model/frames.hpp"

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

// From a pose to the numbers of a motion step.

SolverPosition solver_position(const SolverFrame& frame, const Pose& X_reference_moving)
{
  // R = Rz(-f) Rx(v) Ry(theta), as in core/clinical.cpp but about the axes of S.
  const Pose X = X_solver_reference_moving(frame, X_reference_moving);
  const Eigen::Matrix3d R = X.linear();
  SolverPosition result;
  result.attitude = {arc_tangent2(R(0, 1), R(1, 1)), arc_sine(R(2, 1))};
  result.pose.theta_rad = arc_tangent2(-R(2, 0), R(2, 2));
  result.pose.translation_mm = reference_rotation(result.attitude) * X.translation();
  return result;
}

const char* name_of(Plausibility plausibility)
{
  switch (plausibility) {
    case Plausibility::not_judged:
      return "not_judged";
    case Plausibility::nothing_found:
      return "nothing_found";
    case Plausibility::nothing_ahead:
      return "nothing_ahead";
    case Plausibility::unstable_balance:
      return "unstable_balance";
    case Plausibility::dislocated:
      return "dislocated";
    case Plausibility::border_contact:
      return "border_contact";
    case Plausibility::overstrained:
      return "overstrained";
  }
  throw InternalError("a plausibility without a name");
}

const char* meaning_of(Plausibility plausibility)
{
  switch (plausibility) {
    case Plausibility::not_judged:
      return "no stable pose, or not checked";
    case Plausibility::nothing_found:
      return "the check found no objection to the pose";
    case Plausibility::nothing_ahead:
      return "no surface along Delta within the contact resolution, here or displaced sideways by it";
    case Plausibility::unstable_balance:
      return "the energy is lower one contact resolution away in both senses of one direction";
    case Plausibility::dislocated:
      return "further from the start pose in contact than half the joint's smallest width, or rotated by "
             "more "
             "than 45 degrees (a knee) or 90; add ligaments, check side, axes and frame.origin, or narrow "
             "the grid";
    case Plausibility::border_contact:
      return "a contact at an edge where the mesh ends; use a mesh that covers more of the joint, or narrow "
             "the "
             "grid";
    case Plausibility::overstrained:
      return "a fibre's strain above 0.44 or a bundle's tension above 1730 N, where ligaments fail; check "
             "attachments and slack lengths, or narrow the grid";
  }
  throw InternalError("a plausibility without a meaning");
}

}  // namespace vrda::inline model
