/// Samples of the devices, as the frame loop receives them and a recording stores them, and their queue.
#pragma once

#include <Eigen/Geometry>

#include <array>
#include <atomic>
#include <chrono>
#include <memory>
#include <mutex>
#include <type_traits>

#include "bench/igtl_message.hpp"

namespace vrda::bench {

enum class SampleKind : std::uint8_t {
  tool_pose,      ///< pose of a tracked tool; of a single marker only the position is valid
  potentiometer,  ///< `count` from 0 to 1023
  stage,          ///< `count` of the parallax stage's encoder; `state` holds StageFlags
  link,           ///< `state` is a LinkState, `source` the device
  offset          ///< of the drawn joint from the leg, by the pointer: a pose in the leg's axes
};

enum class LinkState : std::uint8_t { closed, opening, up };

/// Sources of SampleKind::link.
enum class DeviceId : std::uint16_t { tracker, board };

enum StageFlags : std::uint8_t { stage_zeroed = 1, stage_lost_counts = 2 };

/// Pose of a tool in the tracker's frame: position (mm) and unit quaternion (w, x, y, z).
struct ToolPose {
  double position_mm[3] = {0.0, 0.0, 0.0};
  double rotation[4] = {1.0, 0.0, 0.0, 0.0};
};
/// Tool to tracker; the quaternion is normalised.
inline Pose pose_of(const ToolPose& place)
{
  const double* q = place.rotation;
  Pose X = Pose::Identity();
  X.linear() = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized().toRotationMatrix();
  X.translation() = Eigen::Vector3d(place.position_mm[0], place.position_mm[1], place.position_mm[2]);
  return X;
}
/// `pose`: tool to tracker, mm.
inline ToolPose place_of(const Pose& pose)
{
  const Eigen::Quaterniond q = Eigen::Quaterniond(Eigen::Matrix3d(pose.linear())).normalized();
  const Eigen::Vector3d p = pose.translation();
  return {{p.x(), p.y(), p.z()}, {q.w(), q.x(), q.y(), q.z()}};
}

/// Trivially copyable without padding: equal samples have equal bytes.
struct Sample {
  std::int64_t arrival_ns = 0;  ///< steady clock, since the start of the session
  std::int64_t device_ns = 0;   ///< the device's own clock, any epoch; 0: none
  ToolPose tool_pose;
  std::int32_t count = 0;
  std::uint16_t source = 0;  ///< of tool poses: index into TrackerSettings::tools
  SampleKind kind = SampleKind::link;
  std::uint8_t state = 0;  ///< by kind: ToolVisibility, StageFlags, LinkState

  bool is(ToolVisibility visibility) const
  {
    return kind == SampleKind::tool_pose && state == static_cast<std::uint8_t>(visibility);
  }
};
static_assert(std::is_trivially_copyable_v<Sample> && sizeof(Sample) == 80);

/// Single producer, single consumer. When nearly full it rejects new readings, but keeps the last slots for
/// link changes and tools that are no longer visible.
class SampleQueue {
 public:
  /// 16 tools at 100 Hz fill it in 2.5 s; 320 KB.
  static constexpr std::size_t capacity = 4096;
  static constexpr std::size_t n_reserved = 64;

  SampleQueue() : slots_(capacity) {}

  /// Appends a sample that becomes visible at publish(), so that the samples of a message are taken
  /// together. False if full.
  bool stage(const Sample& sample);
  void publish() { n_put_.store(n_staged_, std::memory_order_release); }
  /// False if empty. Never blocks or allocates.
  bool take(Sample& sample);

 private:
  std::vector<Sample> slots_;
  std::uint64_t n_staged_ = 0;  ///< written by the producer
  std::atomic<std::uint64_t> n_put_{0}, n_taken_{0};
};

// The bench's devices as one stream of samples. A background thread reads them, reconnects with back-off,
// and reports tools that are not visible.

struct TrackerSettings {
  std::string host = "127.0.0.1";
  std::uint16_t port = 18944;
  std::vector<std::string> tools;  ///< device names of messages, or tool names within TDATA and QTDATA
  double stale_after_ms = 100.0;   ///< a tool without news for this long is stale
  double tdata_interval_ms =
      0.0;                  ///< requests TDATA at this interval (STT_TDATA); 0: the server streams unasked
  double retry_ms = 100.0;  ///< first back-off pause, doubling to 20 times that
  /// Instead of host and port: a program and its arguments that writes the messages to its standard output.
  /// Started again with back-off when it ends. Looked up beside this program, then in PATH.
  std::vector<std::string> program;
};

struct BoardSettings {
  std::string port;  ///< serial port or pseudo-terminal
  int baud = 115200;
  double rate_hz = 100.0;  ///< of each reading
  bool has_potentiometer = true;
  bool has_stage = true;
  double retry_ms = 100.0;  ///< as in TrackerSettings
};

struct DeviceReport {
  LinkState link = LinkState::closed;
  std::string peer;                ///< "127.0.0.1:18944", "/dev/ttyUSB0"
  std::string error_message;       ///< why the link is not up, or the last rejected input; may be empty
  std::vector<std::string> notes;  ///< what is odd about the input that is used (TrackerProtocol::notes)
  std::uint64_t n_connects = 0, n_samples = 0;
  std::uint64_t n_refused = 0;  ///< rejected messages or frames: wrong checksum, garbage, wrong size
  std::uint64_t n_lost = 0;     ///< samples dropped because the queue was full
  double rate_hz = 0.0;         ///< of samples over the last 2 s
};

/// ns since construction.
class ArrivalClock {
 public:
  using Time = std::chrono::steady_clock::time_point;
  std::int64_t now_ns() const
  {
    return (std::chrono::steady_clock::now() - begin_) / std::chrono::nanoseconds(1);
  }
  Time time_of(std::int64_t ns) const { return begin_ + std::chrono::nanoseconds(ns); }

 private:
  Time begin_ = std::chrono::steady_clock::now();
};

/// Rate over the last 2 s, in bins of a quarter of a second.
class RateMeter {
 public:
  /// A reading at `now_ns` of the arrival clock; ascending.
  void count(std::int64_t now_ns);
  /// Readings a second up to `now_ns`; 0 without one in the last 2 s.
  double rate_hz(std::int64_t now_ns) const;

 private:
  static constexpr std::int64_t bucket_ns = 250'000'000;
  static constexpr std::size_t n_buckets = 8;
  struct Bucket {
    std::int64_t number = -1;  ///< counted from the clock's start
    std::uint32_t n = 0;
  };
  std::array<Bucket, n_buckets> buckets_{};
  std::int64_t first_ns_ = -1;
};

/// Output of one device: its samples into the queue, its status report.
class DeviceOutput {
 public:
  /// `peer`: as shown, such as "127.0.0.1:18944". `queue` and `clock` must outlive this object.
  DeviceOutput(DeviceId device, std::string peer, SampleQueue& queue, const ArrivalClock& clock);

  /// Puts the samples of one message; the loop receives all of them together.
  void put(const std::vector<Sample>& samples);
  /// Also puts a link sample if the state changed. `error_message` is kept until replaced or the link is up.
  void set_link(LinkState link, const std::string& error_message);
  /// Counts rejected input. An empty `error_message` leaves the last one unchanged.
  void count_rejected(std::uint64_t n, const std::string& error_message);
  void set_notes(std::vector<std::string> notes);
  /// Sets `error_message` without counting anything.
  void set_error_message(const std::string& error_message);

  /// Callable from any thread; the others only from the devices' thread.
  DeviceReport report() const;
  const ArrivalClock& clock() const { return clock_; }

 private:
  void put_one(const Sample& sample);

  const DeviceId device_;
  SampleQueue& queue_;
  const ArrivalClock& clock_;
  mutable std::mutex mutex_;
  DeviceReport report_;
  RateMeter rate_;
};

class Devices {
 public:
  /// Connects in the background; either device may be missing. Failures are in its report, not thrown.
  Devices(const std::optional<TrackerSettings>& tracker, const std::optional<BoardSettings>& board);
  ~Devices();

  /// The next sample in order of arrival; false if the queue is empty. Never blocks or allocates.
  bool take(Sample& sample);

  /// ns since construction: the clock of arrival times.
  std::int64_t now_ns() const;

  /// Requests that the board sets its stage counter to zero. Returns false, without a request, if there is
  /// no stage or the board is not up.
  bool zero_stage();

  DeviceReport report(DeviceId device) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace vrda::bench
