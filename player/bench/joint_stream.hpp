/// Sends the joint to other programs by OpenIGTLink: poses of both bones, of the eyes and of the probe as
/// TRANSFORM, angles and marks as STRING, each mesh once per client as POLYDATA. In: the frames of a bench or
/// of a motion. Errors: InputError before anything is sent.
#pragma once

#include <mutex>

#include "bench/bench_state.hpp"
#include "bench/simulated_devices.hpp"
#include "store/motion_model.hpp"

namespace vrda::bench {

struct IgtlOptions {
  std::optional<int> port;  ///< empty: nothing is sent; 0: any free port
  std::string address = "127.0.0.1";
};

/// One frame of the joint, in the tracker's frame (of a bench) or the reference's (of a motion).
struct StreamedFrame {
  BenchFrame frame;
  bool has_eyes = false;
  std::optional<Pose> X_tracker_probe;  ///< at the tip if the probe is calibrated; empty if not seen
  InputStatus probe;                    ///< used once it was seen
  std::int64_t utc_ns = 0;
  std::uint64_t number = 0;  ///< counted from the start; set by JointStream
};

/// Text of the STRING "angles": one JSON object with the Grood-Suntay coordinates, whether all is live, and
/// the marks that the bench shows, and that of a probe that is no longer seen.
std::string angles_text(const StreamedFrame& streamed, Side side, const Eigen::Vector3d& rotation_centre_mm);

/// The messages of one frame. The pose of a bone, of the eyes or of the probe is left out while a body that
/// it needs is hidden or its cell is not solved: a client then keeps the last one.
std::vector<std::uint8_t> frame_messages(const StreamedFrame& streamed, const store::MotionModel& model);

/// The meshes of both bones in their own frames, by the names on screen: "femur_mesh", "tibia_mesh".
std::vector<std::uint8_t> mesh_messages(const store::MotionModel& model, std::int64_t utc_ns);

class JointStream {
 public:
  /// Starts to listen. `model` must outlive the stream. Throws InputError.
  JointStream(const IgtlOptions& options, const store::MotionModel& model);

  std::uint16_t port() const { return server_->port(); }

  /// Sends a frame to every client, in another thread. Never blocks for them or allocates. A frame is dropped
  /// if 64 wait to be encoded.
  void put(const StreamedFrame& streamed);

 private:
  std::vector<std::uint8_t> next();

  static constexpr std::size_t capacity = 64;  ///< a second of frames
  const store::MotionModel& model_;
  std::mutex mutex_;
  std::array<StreamedFrame, capacity> frames_;
  std::uint64_t n_put_ = 0, n_taken_ = 0, number_ = 0;
  std::unique_ptr<IgtlServer> server_;  ///< last: its thread reads the members above
};

/// ns since 1970, the time stamp of the protocol.
std::int64_t utc_now_ns();

/// The probe among a bench's tools: its last pose, at the tip of a calibrated probe.
class ProbeTool {
 public:
  ProbeTool(const BenchFile& bench, const Calibration& calibration);
  /// Any sample, in order of arrival.
  void take(const Sample& sample);
  /// Empty while it is hidden.
  const std::optional<Pose>& X_tracker_probe() const { return pose_; }
  /// `now_ns`: the clock of the samples' arrival.
  InputStatus status(std::int64_t now_ns) const;

 private:
  std::optional<std::size_t> tool_;
  Pose X_tool_tip_ = Pose::Identity();
  std::optional<Pose> pose_;
  std::optional<std::int64_t> seen_ns_;
  ToolVisibility state_ = ToolVisibility::missing;
};

}  // namespace vrda::bench
