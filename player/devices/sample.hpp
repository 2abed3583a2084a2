/// What a device said, which the loop takes and a recording keeps, and its queue to the loop.
#pragma once

#include <atomic>
#include <cstdint>
#include <type_traits>
#include <vector>

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

/// One thread puts, one takes. A loop that does not take loses the newest readings, never the news of links
/// and of tools that are no longer seen: the last slots are kept for these.
class SampleQueue {
 public:
  /// 16 tools at 100 Hz fill it in 2.5 s; 320 KB.
  static constexpr std::size_t capacity = 4096;
  static constexpr std::size_t n_reserved = 64;

  SampleQueue() : slots_(capacity) {}

  /// Puts it in behind the others; it is taken from publish() on, so that what came in one message is taken
  /// at once or not at all. False where it is full.
  bool stage(const Sample& sample);
  void publish();
  /// Both for one sample.
  bool put(const Sample& sample);
  /// False where it is empty. Neither blocks nor allocates.
  bool take(Sample& sample);

 private:
  std::vector<Sample> slots_;
  std::uint64_t n_staged_ = 0;  ///< of the thread that puts
  std::atomic<std::uint64_t> n_put_{0}, n_taken_{0};
};

}  // namespace vrda
