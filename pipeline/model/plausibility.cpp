#include "model/plausibility.hpp"

#include "core/error.hpp"

namespace vrda::inline model {

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
