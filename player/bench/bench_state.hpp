/// State of the bench as a function of samples, keys and times, so that recordings replay exactly.
#pragma once

#include <iosfwd>

#include "bench/body_tracker.hpp"
#include "bench/calibration_file.hpp"
#include "model/coordinates.hpp"
#include "store/motion.hpp"
#include "view/camera.hpp"
#include "view/keys.hpp"

namespace vrda::bench {

/// State of an input.
struct InputStatus {
  bool is_used = false;
  bool is_live = false;  ///< false: the last valid value is shown
  bool was_seen = false;
  double age_s = 0.0;                              ///< age of the shown value
  ToolVisibility state = ToolVisibility::missing;  ///< `seen` for a stage that is not live
                                                   ///< but sends counts without zero
};

/// Poses and input states of one displayed frame.
struct BenchFrame {
  store::JointPose pose;      ///< motion model at the leg's attitude
  bool is_pose_held = false;  ///< the model has no pose there: `pose` is the last one
  LegCheck leg;               ///< whether that is the tracked leg's
  Pose X_tracker_reference = Pose::Identity();
  Pose X_tracker_moving = Pose::Identity();
  Pose X_tracker_eyes = Pose::Identity();
  ByRole<InputStatus> bodies;
  InputStatus stage, potentiometer;
  double stage_mm = 0.0;
  bool is_stage_zeroed = false, stage_has_lost_counts = false;
  bool is_moved_aside = false;         ///< the pointer moved the joint relative to the leg
  std::int64_t newest_arrival_ns = 0;  ///< newest tracker sample since the previous frame; 0: none
  int n_samples = 0;                   ///< tracker samples since the previous frame
};

/// Whether all used inputs are live.
/// An input that the bench does not have does not count.
bool is_live(const BenchFrame& frame);

class BenchState {
 public:
  /// `motion` must outlive the state; `frame`: solver frame of the model at the first flexion.
  BenchState(const BenchFile& bench, const Calibration& calibration, const store::Motion& motion,
             const SolverFrame& frame);

  /// Processes a sample, in order of arrival. All samples of a message must precede the next frame().
  void take(const Sample& sample);

  /// Frame to draw at `now_ns` of the samples' clock. Does not allocate.
  const BenchFrame& frame(std::int64_t now_ns);

  BenchValues& values() { return values_; }
  const BenchValues& values() const { return values_; }
  /// Parameter changed by keys, and by a potentiometer that drives "selected".
  std::size_t selected() const { return selected_; }
  /// `parameter`: index into parameters(). The potentiometer counts from its present position.
  void select(std::size_t parameter);
  /// The filter of the leg's angles.
  void set_filter(bool is_on) { is_filtered_ = is_on; }
  bool is_filtered() const { return is_filtered_; }
  const BenchFile& bench() const { return bench_; }
  /// Of a solved pose of the model.
  ClinicalCoordinates clinical(const store::JointPose& pose) const
  {
    return clinical_coordinates(pose.X_reference_moving, frame_of_model_.side,
                                frame_of_model_.rotation_centre_mm);
  }
  /// Offset of the drawn joint from the leg, by the pointer; identity until an `offset` sample.
  const Pose& X_leg_joint() const { return X_leg_joint_; }
  void reset_offset() { X_leg_joint_ = Pose::Identity(); }
  /// Last pose fit of a body of markers; nullptr for a tool.
  const PoseFit* fit(BodyRole role) const;

 private:
  struct BoardInput {
    bool is_live = false, was_seen = false, is_heard = false;
    double time_s = 0.0;
    std::int32_t count = 0;
    std::uint8_t flags = 0;
  };
  void take_place(const Sample& sample);
  void take_link(const Sample& sample);
  void take_stage(const Sample& sample);
  void take_potentiometer(const Sample& sample);
  bool is_turning(double time_s);
  void end_messages();
  void update_leg();
  Pose X_tracker_eyes(double time_s) const;
  void place_model(double time_s);
  static InputStatus mark_of(const BodyTracker& tracker, double now_s);
  static InputStatus mark_of(const BoardInput& input, double now_s);
  double stage_mm() const { return bench_.stage_mm_per_count * static_cast<double>(stage_.count); }

  BenchFile bench_;
  BenchValues values_;
  const store::Motion& motion_;
  SolverFrame frame_of_model_;
  TrackedBodies trackers_;
  BoardInput stage_, potentiometer_;
  bool has_lost_zero_ = false;         ///< the board restarted since the stage was zeroed
  std::optional<std::size_t> driven_;  ///< parameter driven by the potentiometer; empty: the selected one
  OneEuroFilter potentiometer_filter_;
  double potentiometer_count_ = 0.0;   ///< filtered
  std::optional<double> start_count_;  ///< count when the parameter was selected
  double start_value_ = 0.0;           ///< value of the driven parameter at start_count_
  std::optional<double> rest_count_;   ///< count at rest, or at the last detected turn
  double turning_until_s_ = 0.0;
  std::size_t selected_ = 0;
  bool is_filtered_ = true;
  OneEuroAngles filter_;
  AnglesPredictor angles_predictor_;
  std::optional<TimedAngles> angles_;  ///< two bodies: filtered angles
  LegAngles exchanged_;                ///< each body on the other bone
  Pose X_leg_joint_ = Pose::Identity();
  std::int64_t newest_arrival_ns_ = 0;
  int n_samples_ = 0;
  BenchFrame shown_;
};

// Statistics of the bench's latency and of its tools' samples. In: times in ms, time stamps in ns. Out:
// counts, mean, percentiles in ms. Adding a value allocates nothing.

/// Histogram of times with bins of 0.25 ms up to 250 ms; the last bin counts longer times.
class TimeHistogram {
 public:
  static constexpr double bin_ms = 0.25;
  static constexpr std::size_t n_bins = 1001;

  /// A negative time counts in the first bin.
  void add(double time_ms);
  std::uint64_t n() const { return n_; }
  double mean_ms() const { return n_ == 0 ? 0.0 : sum_ms_ / static_cast<double>(n_); }
  double max_ms() const { return longest_ms_; }
  /// Smallest bin edge that `share` of the times do not exceed; from 250 ms the longest time; 0 if empty.
  double percentile_ms(double share) const;
  /// Standard deviation.
  double spread_ms() const;
  const std::array<std::uint64_t, n_bins>& bins() const { return bins_; }

 private:
  std::array<std::uint64_t, n_bins> bins_{};
  std::uint64_t n_ = 0;
  double sum_ms_ = 0.0, sum_squares_ = 0.0, longest_ms_ = 0.0;
};

/// Counts missed and late samples of one tool by the device's time stamps.
class StreamStatistics {
 public:
  /// Samples of a hidden tool count as received; samples without a stamp are ignored.
  void add(const Sample& sample)
  {
    if (sample.device_ns != 0) add(sample.device_ns, sample.arrival_ns);
  }
  void add(std::int64_t device_ns, std::int64_t arrival_ns);
  std::uint64_t n() const { return n_; }
  std::uint64_t n_missed() const { return n_missed_; }  ///< gaps of whole intervals between stamps
  std::uint64_t n_late() const { return n_late_; }      ///< more than half an interval above the least delay
  double jitter_ms() const;  ///< standard deviation of the delays between stamps and arrivals

 private:
  bool follow_pace(double step_ns);

  std::uint64_t n_ = 0, n_missed_ = 0, n_late_ = 0;
  std::int64_t device_ns_ = 0, least_delay_ns_ = 0;
  double interval_ns_ = 0.0;  ///< estimated sample interval
  int n_short_ = 0;           ///< consecutive much shorter steps, and their sum
  double short_sum_ns_ = 0.0;
  double sum_ms_ = 0.0, sum_squares_ = 0.0;
  std::int64_t n_delays_ = 0;
};

struct BenchTiming {
  TimeHistogram latency;   ///< from the arrival of a frame's newest sample to its last pixel
  TimeHistogram camera;    ///< from the exposure of a webcam's newest picture to the last pixel; else empty
  TimeHistogram interval;  ///< between frames
  TimeHistogram drawing;   ///< duration of a frame
  std::uint64_t n_pictures = 0;
  std::uint64_t n_without_sample = 0;  ///< frames without a new sample
  std::uint64_t n_not_live = 0;        ///< frames with an input that is not live
  std::uint64_t n_samples = 0, n_missed = 0, n_late = 0, n_lost = 0;
  double jitter_ms = 0.0;  ///< largest of all tools
};

/// JSON: {"pictures": ..., "latency_ms": {"median": ..., "p99": ..., "bins_from_ms": [[from, count], ...]},
/// ...}
void write_timing(std::ostream& out, const BenchTiming& timing);
/// One line of text.
std::string timing_text(const BenchTiming& timing);

// The thesis's trackball on the bench (chapter 7): the pointer moves the drawn joint relative to the leg,
// with the buttons of `show`. In: pointer events and the displayed frame. Out: the offset of the joint as a
// sample, so that it is recorded with those of the devices. Lengths in mm, positions in px of the frame
// buffer.

class Trackball {
 public:
  /// `centre_mm`: of the rotations, in the axes of the reference object.
  Trackball(const DisplaySettings& display, const Eigen::Vector3d& centre_mm)
      : display_(display), centre_mm_(centre_mm)
  {
  }

  /// Processes an event over the picture of `frame`, the last one drawn; returns the new offset, if it
  /// changed, as a sample of kind `offset` that arrived at `now_ns`.
  std::optional<Sample> take(const view::InputEvent& event, const BenchState& state, const BenchFrame& frame,
                             std::int64_t now_ns);

 private:
  struct HeldDrag {
    view::Drag drag;
    view::MouseButton button = view::MouseButton::left;
    view::Viewport window;
    double pixel_aspect = 1.0;              ///< of the eye
    Pose X_tracker_leg = Pose::Identity();  ///< of the joint without offset, at the press
    Pose X_leg_joint = Pose::Identity();    ///< offset at the press
  };
  Eigen::Vector2d picture_px(const HeldDrag& held, const view::InputEvent& event) const;

  DisplaySettings display_;
  Eigen::Vector3d centre_mm_;
  std::optional<HeldDrag> held_;
};

}  // namespace vrda::bench
