/// Result of the independent check of a stable pose. The values are those of the motion model's
/// `plausibility`.
#pragma once

#include <cstdint>

namespace vrda::inline model {

enum class Plausibility : std::int8_t {
  not_judged = -1,       ///< no stable pose
  nothing_found = 0,     ///< the check found no objection
  nothing_ahead = 1,     ///< no surface along Delta within the contact resolution
  unstable_balance = 2,  ///< the energy decreases both ways along one direction
  dislocated = 3,        ///< further from the neutral pose than the joint's size allows
  border_contact = 4,    ///< a contact at an edge where a surface ends
  overstrained = 5,      ///< beyond the strain or tension that ligaments bear
};

/// As stored.
inline constexpr auto plausibility_not_judged = static_cast<std::int8_t>(Plausibility::not_judged);

inline constexpr Plausibility all_plausibilities[] = {
    Plausibility::not_judged,       Plausibility::nothing_found, Plausibility::nothing_ahead,
    Plausibility::unstable_balance, Plausibility::dislocated,    Plausibility::border_contact,
    Plausibility::overstrained};
/// The values that make a pose doubtful.
inline constexpr Plausibility doubtful_plausibilities[] = {
    Plausibility::dislocated, Plausibility::border_contact, Plausibility::overstrained,
    Plausibility::nothing_ahead, Plausibility::unstable_balance};
inline bool is_doubtful(Plausibility plausibility)
{
  return plausibility > Plausibility::nothing_found;
}

const char* name_of(Plausibility plausibility);
/// One-line description.
const char* meaning_of(Plausibility plausibility);

}  // namespace vrda::inline model
