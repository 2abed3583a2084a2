#include "core/plausibility.hpp"

#include "core/error.hpp"

namespace vrda::inline core {

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
      return "no stable pose, or not checked";
    case Plausibility::nothing_found:
      return "the check found no objection to the pose";
    case Plausibility::nothing_ahead:
      return "no surface along Delta within the contact resolution, here or displaced sideways by it";
    case Plausibility::unstable_balance:
      return "the energy is lower one contact resolution away in both senses of one direction";
  }
  throw InternalError("a plausibility without a meaning");
}

}  // namespace vrda::inline core
