/// How a motion step ended. The values are those of the motion model's `status`.
#pragma once

#include <cstdint>

namespace vrda {

enum class StepStatus : std::int8_t {
  pending = -1,         ///< not solved yet
  stable = 0,           ///< a stable pose
  no_contact = 1,       ///< left the reference behind
  no_clearance = 2,     ///< no free pose along -Delta
  iteration_limit = 3,  ///< max_steps or max_iterations reached
  unbounded = 4,        ///< no rest: slides off however small the steps
  overlapping = 5,      ///< came to rest, but measured again the meshes overlap
};

/// As stored.
inline constexpr auto status_pending = static_cast<std::int8_t>(StepStatus::pending);
inline constexpr auto status_stable = static_cast<std::int8_t>(StepStatus::stable);

inline constexpr StepStatus all_step_statuses[] = {
    StepStatus::pending,         StepStatus::stable,    StepStatus::no_contact, StepStatus::no_clearance,
    StepStatus::iteration_limit, StepStatus::unbounded, StepStatus::overlapping};

const char* name_of(StepStatus status);
/// What it means, in a few words.
const char* meaning_of(StepStatus status);

}  // namespace vrda
