/// State of the bench as a function of samples, keys and times, so that recordings replay exactly.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "bench/body_tracker.hpp"
#include "bench/leg_check.hpp"
#include "bench/parameters.hpp"
#include "model/clinical.hpp"
#include "store/poses.hpp"
#include "bench/one_euro.hpp"

namespace vrda::bench {

/// State of an input.
struct InputStatus {
  bool is_used = false;
  bool is_live = false;  ///< false: the last valid value is shown
  bool was_seen = false;
  double age_s = 0.0;                                                ///< age of the shown value
  bench::ToolVisibility state = bench::ToolVisibility::missing;  ///< `seen` for a stage that is not live
                                                                     ///< but sends counts without zero
};

/// Poses and input states of one displayed frame.
struct BenchFrame {
  store::JointPose pose;     ///< motion model at the leg's attitude
  bool is_pose_held = false;  ///< the model has no pose there: `pose` is the last one
  LegCheck leg;               ///< whether that is the tracked leg's
  Pose X_tracker_reference = Pose::Identity();
  Pose X_tracker_moving = Pose::Identity();
  Pose X_tracker_eyes = Pose::Identity();
  std::array<InputStatus, bench::n_body_roles> bodies;
  InputStatus stage, potentiometer;
  double stage_mm = 0.0;
  bool is_stage_zeroed = false, stage_has_lost_counts = false;
  bool is_moved_aside = false;         ///< the pointer moved the joint relative to the leg
  std::int64_t newest_arrival_ns = 0;  ///< newest tracker sample since the previous frame; 0: none
  int n_samples = 0;                   ///< tracker samples since the previous frame
};

/// Whether all used inputs are live.
bool is_live(const BenchFrame& frame);

class BenchState {
 public:
  /// `motion` must outlive the state; `frame`: solver frame of the model at the first flexion.
  BenchState(const bench::BenchFile& bench, const bench::Calibration& calibration,
             const store::Motion& motion, const SolverFrame& frame);

  /// Processes a sample, in order of arrival. All samples of a message must precede the next frame().
  void take(const bench::Sample& sample);

  /// Frame to draw at `now_ns` of the samples' clock. Does not allocate.
  const BenchFrame& frame(std::int64_t now_ns);

  bench::BenchValues& values() { return values_; }
  const bench::BenchValues& values() const { return values_; }
  /// Parameter changed by keys, and by a potentiometer that drives "selected".
  std::size_t selected() const { return selected_; }
  void select(std::size_t parameter);
  void set_filter(bool is_on) { is_filtered_ = is_on; }
  bool is_filtered() const { return is_filtered_; }
  const bench::BenchFile& bench() const { return bench_; }
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
  const bench::PoseFit* fit(bench::BodyRole role) const;

 private:
  struct BoardInput {
    bool is_live = false, was_seen = false, is_heard = false;
    double time_s = 0.0;
    std::int32_t count = 0;
    std::uint8_t flags = 0;
  };
  void take_place(const bench::Sample& sample);
  void take_link(const bench::Sample& sample);
  void take_stage(const bench::Sample& sample);
  void take_potentiometer(const bench::Sample& sample);
  bool is_turning(double time_s);
  void end_messages();
  void update_leg();
  double least_of(std::size_t parameter) const;
  double most_of(std::size_t parameter) const;
  Pose X_tracker_eyes(double time_s) const;
  void place_model(double time_s);
  InputStatus mark_of(const BodyTracker& tracker, double now_s) const;
  InputStatus mark_of(const BoardInput& input, double now_s) const;
  double stage_mm() const;

  bench::BenchFile bench_;
  bench::BenchValues values_;
  const store::Motion& motion_;
  SolverFrame frame_of_model_;
  TrackedBodies trackers_;
  BoardInput stage_, potentiometer_;
  bool has_lost_zero_ = false;         ///< the board restarted since the stage was zeroed
  std::optional<std::size_t> driven_;  ///< parameter driven by the potentiometer; empty: the selected one
  bench::OneEuroFilter potentiometer_filter_;
  double potentiometer_count_ = 0.0;   ///< filtered
  std::optional<double> start_count_;  ///< count when the parameter was selected
  double start_value_ = 0.0;           ///< value of the driven parameter at start_count_
  std::optional<double> rest_count_;   ///< count at rest, or at the last detected turn
  double turning_until_s_ = 0.0;
  std::size_t selected_ = 0;
  bool is_filtered_ = true;
  bench::OneEuroAngles filter_;
  bench::AnglesPredictor angles_predictor_;
  std::optional<bench::TimedAngles> angles_;  ///< two bodies: filtered angles
  bench::LegAngles exchanged_;                ///< each body on the other bone
  Pose X_leg_joint_ = Pose::Identity();
  std::int64_t newest_arrival_ns_ = 0;
  int n_samples_ = 0;
  BenchFrame shown_;
};

}  // namespace vrda::bench
