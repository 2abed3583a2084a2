#include "core/step_status.hpp"

#include "core/error.hpp"

namespace vrda {

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
      return "came to rest";
    case StepStatus::no_contact:
      return "nothing of the reference lies along Delta: slid off, or never met";
    case StepStatus::no_clearance:
      return "no free pose within reach behind: the objects stay locked into each other";
    case StepStatus::iteration_limit:
      return "did not come to rest within max_steps or max_iterations";
    case StepStatus::unbounded:
      return "no place of rest: the loads carry it off the reference";
    case StepStatus::overlapping:
      return "came to rest, but the meshes overlap there: see what vrda check says of their winding";
  }
  throw InternalError("a step status without a meaning");
}

}  // namespace vrda
