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

}  // namespace vrda
