#include "core/plausibility.hpp"

#include "core/error.hpp"

namespace vrda {

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
  }
  throw InternalError("a plausibility without a name");
}

const char* meaning_of(Plausibility plausibility)
{
  switch (plausibility) {
    case Plausibility::not_judged:
      return "no stable pose, or not measured again";
    case Plausibility::nothing_found:
      return "measured again, nothing speaks against the pose";
    case Plausibility::nothing_ahead:
      return "nothing lies ahead along Delta within the contact resolution, here or that far to a side";
    case Plausibility::unstable_balance:
      return "a contact resolution either way along one direction the energy is lower";
  }
  throw InternalError("a plausibility without a meaning");
}

}  // namespace vrda
