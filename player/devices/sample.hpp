/// What a device said: what the loop takes and a recording keeps.
#pragma once

#include <cstdint>
#include <type_traits>

#include "core/mesh.hpp"

namespace vrda {

enum class SampleKind : std::uint8_t {
  place,          ///< a tracked tool: a body, or a marker, of which only the position counts
  potentiometer,  ///< `count` from 0 to 1023
  stage,          ///< `count` of the parallax stage's encoder; `state` holds StageFlags
  link            ///< of a device: `state` is a LinkState; `source` the device
};

/// Whether a tracked tool was seen.
enum class SeenState : std::uint8_t {
  seen,
  missing,      ///< the tracker does not list it, or says that it is not there
  stale,        ///< nothing new for too long, or a time stamp that does not go on
  not_a_place,  ///< a matrix that is no rotation, a number that is none
};

enum class LinkState : std::uint8_t { closed, opening, up };

/// Sources of SampleKind::link.
enum class DeviceId : std::uint16_t { tracker, board };

enum StageFlags : std::uint8_t { stage_zeroed = 1, stage_lost_counts = 2 };

/// Position (mm) and unit quaternion (w, x, y, z), of a tool in the tracker's frame.
struct Place {
  double position_mm[3] = {0.0, 0.0, 0.0};
  double rotation[4] = {1.0, 0.0, 0.0, 0.0};
};
Pose pose_of(const Place& place);
Place place_of(const Pose& pose);

/// Plain bytes, equal for equal samples.
struct Sample {
  std::int64_t arrival_ns = 0;  ///< a steady clock from the session's begin
  std::int64_t device_ns = 0;   ///< the device's own clock, of any begin; 0 where it has none
  Place place;
  std::int32_t count = 0;
  std::uint16_t source = 0;  ///< of places: which tool of the tracker's settings
  SampleKind kind = SampleKind::link;
  std::uint8_t state = 0;  ///< by kind: SeenState, StageFlags, LinkState
};
static_assert(std::is_trivially_copyable_v<Sample> && sizeof(Sample) == 80);

}  // namespace vrda
