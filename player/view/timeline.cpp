#include "view/timeline.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/error.hpp"

namespace vrda {
namespace {

constexpr std::array speeds_deg_s{1.0, 2.0, 5.0, 10.0, 20.0, 30.0, 45.0, 60.0, 90.0, 180.0, 360.0};
constexpr double same_speed = 1e-9;  // relative: the table's own values through degrees and back

/// Where a point `way` along a path that bounces between 0 and `length` is, and which way it goes.
Timeline bounced(Timeline timeline, double travel_rad)
{
  const double length = timeline.last_rad - timeline.first_rad;
  const double done = timeline.flexion_rad - timeline.first_rad;
  // Unfolded: the way back lies beyond the far end.
  const double unfolded = timeline.direction > 0 ? done : 2.0 * length - done;
  const double at = std::fmod(unfolded + travel_rad, 2.0 * length);
  timeline.direction = at < length ? 1 : -1;
  timeline.flexion_rad = timeline.first_rad + (at < length ? at : 2.0 * length - at);
  return timeline;
}

}  // namespace

const char* name_of(LoopMode mode)
{
  switch (mode) {
    case LoopMode::once:
      return "once";
    case LoopMode::wrap:
      return "loop";
    case LoopMode::bounce:
      return "to and fro";
  }
  throw InternalError("a loop mode has a name");
}

Timeline advanced(Timeline timeline, double elapsed_s)
{
  check(elapsed_s >= 0.0, "time goes forward");
  const double length = timeline.last_rad - timeline.first_rad;
  if (!timeline.is_playing || length <= 0.0) return timeline;
  const double travel_rad = timeline.speed_rad_s * elapsed_s;
  switch (timeline.loop) {
    case LoopMode::once:
      timeline.flexion_rad += travel_rad;
      timeline.is_playing = timeline.flexion_rad < timeline.last_rad;
      break;
    case LoopMode::wrap:
      timeline.flexion_rad =
          timeline.first_rad + std::fmod(timeline.flexion_rad - timeline.first_rad + travel_rad, length);
      break;
    case LoopMode::bounce:
      timeline = bounced(timeline, travel_rad);
      break;
  }
  timeline.flexion_rad = std::clamp(timeline.flexion_rad, timeline.first_rad, timeline.last_rad);
  return timeline;
}

Timeline toggled(Timeline timeline)
{
  timeline.is_playing = !timeline.is_playing;
  if (timeline.loop != LoopMode::bounce) timeline.direction = 1;
  const bool is_over = timeline.loop == LoopMode::once && timeline.flexion_rad >= timeline.last_rad;
  if (timeline.is_playing && is_over) timeline.flexion_rad = timeline.first_rad;
  return timeline;
}

Timeline stepped(Timeline timeline, double by_rad)
{
  timeline.is_playing = false;
  return moved_to(timeline, timeline.flexion_rad + by_rad);
}

Timeline moved_to(Timeline timeline, double flexion_rad)
{
  timeline.flexion_rad = std::clamp(flexion_rad, timeline.first_rad, timeline.last_rad);
  return timeline;
}

Timeline with_range(Timeline timeline, double first_rad, double last_rad)
{
  check(first_rad <= last_rad, "a timeline runs upwards");
  timeline.first_rad = first_rad;
  timeline.last_rad = last_rad;
  return moved_to(timeline, timeline.flexion_rad);
}

Timeline faster(Timeline timeline)
{
  for (const double speed_deg_s : speeds_deg_s) {
    const double speed_rad_s = rad_from_deg(speed_deg_s);
    if (speed_rad_s <= timeline.speed_rad_s * (1.0 + same_speed)) continue;
    timeline.speed_rad_s = speed_rad_s;
    return timeline;
  }
  return timeline;
}

Timeline slower(Timeline timeline)
{
  for (auto speed = speeds_deg_s.rbegin(); speed != speeds_deg_s.rend(); ++speed) {
    const double speed_rad_s = rad_from_deg(*speed);
    if (speed_rad_s >= timeline.speed_rad_s * (1.0 - same_speed)) continue;
    timeline.speed_rad_s = speed_rad_s;
    return timeline;
  }
  return timeline;
}

}  // namespace vrda
