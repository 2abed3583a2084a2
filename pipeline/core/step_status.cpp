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
  }
  throw InternalError("a step status without a name");
}

}  // namespace vrda
