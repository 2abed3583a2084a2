/// What the simulated world does, as the bench file tells it: degrees, mm, seconds.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/frames.hpp"

namespace vrda {

/// Between keys values go smoothly, without leaving their range (simulation/key_path.hpp).
struct LegKey {
  double time_s = 0.0;
  double flexion_deg = 0.0;
  double varus_deg = 0.0;
};
struct StageKey {
  double time_s = 0.0;
  double position_mm = 0.0;
};
struct PotentiometerKey {
  double time_s = 0.0;
  double count = 0.0;  ///< 0 to 1023
};

/// While it lasts the tool, and every marker of a body, is not seen.
struct Occlusion {
  std::string tool;
  double from_s = 0.0, to_s = 0.0;
  double every_s = 0.0;  ///< again after so long, for ever; 0: once
};

/// A tracked body: a tool of its own; its markers are tools too, named "femur-1" and on after it.
struct SimulatedBody {
  std::string tool;
  Pose X_body_bone = Pose::Identity();      ///< how the bone, or the head frame, lies in the body
  std::vector<Eigen::Vector3d> markers_mm;  ///< in the body's frame
};

struct ClockStep {
  double at_s = 0.0;
  double by_ms = 0.0;
};

/// The tracker's clock, of true times.
struct DeviceClock {
  double offset_s = 1000.0;  ///< what it shows at time 0
  double drift_ppm = 20.0;   ///< how much faster it runs
  std::vector<ClockStep> steps;
};

/// Facing the knee at 1.5 m: X to the viewer's right, Y up, Z towards the viewer; the leg seen from ahead.
Pose default_X_tracker_femur();

struct SimulationScript {
  std::uint64_t seed = 1;
  Side side = Side::right;  ///< without a motion, which has its own
  double rate_hz = 100.0;
  double jitter_ms = 2.0;    ///< a frame is sent up to that much after its tick, evenly
  double drop_rate = 0.005;  ///< share of frames that are never sent
  double noise_mm = 0.1;     ///< standard deviation of each coordinate of tools and markers
  double noise_deg = 0.03;   ///< and of a body's turn about each of its axes

  bool is_looped = true;  ///< each path by itself, from its last key, which equals its first; else held
  std::vector<LegKey> leg = {{0, 0, 0}, {2, 45, 2}, {4, 90, 0}, {6, 45, -2}, {8, 0, 0}};
  std::vector<StageKey> stage = {{0, 0}, {2.5, 25}, {7.5, -25}, {10, 0}};
  std::vector<PotentiometerKey> potentiometer = {{0, 100}, {4, 900}, {8, 100}};
  double potentiometer_noise_counts = 0.7;

  Pose X_tracker_femur = default_X_tracker_femur();  ///< of the bone, in the middle of its sway
  double sway_mm = 2.0;                              ///< of the femur to and fro along its X
  double sway_s = 5.0;
  SimulatedBody femur = {"femur", Pose::Identity(), {}};
  SimulatedBody tibia = {"tibia", Pose::Identity(), {}};
  std::optional<SimulatedBody> head;  ///< a body on the display
  Pose X_tracker_head =
      Pose::Identity();             ///< where the head frame is with the stage at 0; it goes along its X
  double firing_interval_ms = 0.4;  ///< a body's marker k fires k intervals after the tick

  std::vector<Occlusion> occlusions = {{"tibia", 5.0, 6.0, 16.0}};
  DeviceClock clock;
};

/// Names of bodies and markers: each body, then its markers; femur, tibia, head.
std::vector<std::string> tool_names(const SimulationScript& script);

/// Throws InputError naming `file` and the field of what does not fit together; ranges are the bench file's
/// schema's.
void require_usable(const SimulationScript& script, const std::string& file);

}  // namespace vrda
