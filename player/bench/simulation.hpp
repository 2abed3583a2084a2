/// Script of the simulated world, from the bench file (degrees, mm, seconds), and its paths.
#pragma once

#include <Eigen/Core>

#include <random>

#include "bench/rigid_body.hpp"
#include "core/units.hpp"
#include "store/motion.hpp"

namespace vrda::bench {

struct PathPoint {
  double time_s = 0.0;
  double value = 0.0;
};

/// Monotone piecewise cubic with continuous slope: never leaves the range of the neighbouring keys; the
/// slope is 0 at extrema. Source: Fritsch and Butland (1984) SIAM J Sci Stat Comput 5:300-304.
class KeyPath {
 public:
  /// One point or more, ascending in time. If looped, the last value must equal the first; otherwise the
  /// end values are held.
  KeyPath(std::vector<PathPoint> points, bool is_looped);
  /// In the unit of the keys. `time_s`: any; beyond the keys see the constructor.
  double at(double time_s) const;

 private:
  std::vector<PathPoint> points_;
  std::vector<double> slopes_;  ///< per second
  bool is_looped_ = false;
};

struct LegKey {
  double time_s = 0.0;
  double flexion_deg = 0.0;
  double varus_deg = 0.0;
};

/// Interval in which the tool, and every marker of a body, is not visible.
struct Occlusion {
  std::string tool;
  double from_s = 0.0, to_s = 0.0;
  double every_s = 0.0;  ///< period of repetition; 0: once
};

/// A tracked body is a tool; its markers are tools too, named "femur-1", "femur-2", ...
struct SimulatedBody {
  std::string tool;
  std::vector<Eigen::Vector3d> markers_mm;  ///< in the body's frame
};

struct ClockStep {
  double at_s = 0.0;
  double by_ms = 0.0;
};

/// The tracker's clock as a function of true time.
struct DeviceClock {
  double offset_s = 1000.0;  ///< reading at time 0
  double drift_ppm = 20.0;   ///< rate error: positive runs fast
  std::vector<ClockStep> steps;
};

/// Tracker in front of the knee at 1.5 m: X to the viewer's right, Y up, Z towards the viewer.
Pose default_X_tracker_femur();

struct SimulationScript {
  std::uint64_t seed = 1;
  Side side = Side::right;  ///< used without a motion, which has its own
  double rate_hz = 100.0;
  double jitter_ms = 2.0;                 ///< send delay after the tick, uniform from 0 to this
  double drop_rate = 0.005;               ///< share of frames that are not sent
  double noise_mm = 0.1;                  ///< standard deviation of each coordinate of tools and markers
  double noise_rad = rad_from_deg(0.03);  ///< and of a body's rotation about each of its axes

  bool is_looped =
      true;  ///< each path repeats from its last key, which equals its first; otherwise the end is held
  std::vector<LegKey> leg = {{0, 0, 0}, {2, 45, 2}, {4, 90, 0}, {6, 45, -2}, {8, 0, 0}};
  std::vector<PathPoint> stage = {{0, 0}, {2.5, 25}, {7.5, -25}, {10, 0}};  ///< mm
  std::vector<PathPoint> potentiometer = {{0, 100}, {4, 900}, {8, 100}};    ///< counts, 0 to 1023
  double potentiometer_noise_counts = 0.7;

  Pose X_tracker_femur = default_X_tracker_femur();  ///< of the bone, at the centre of its sway
  double sway_mm = 2.0;                              ///< amplitude of the femur's oscillation along its X
  double sway_s = 5.0;
  SimulatedBody femur = {"femur", {}};
  SimulatedBody tibia = {"tibia", {}};
  std::optional<SimulatedBody> head;       ///< tracked body on the display
  Pose X_tracker_head = Pose::Identity();  ///< head frame with the stage at 0; moves along its X
  double firing_interval_ms = 0.4;         ///< marker k fires k intervals after the tick

  std::vector<Occlusion> occlusions = {{"tibia", 5.0, 6.0, 16.0}};
  DeviceClock clock;
};

/// Names of bodies and markers: each body followed by its markers, in the order femur, tibia, head.
std::vector<std::string> tool_names(const SimulationScript& script);

/// Throws InputError naming `file` and the field of an inconsistent value; ranges are checked by the bench
/// file's schema.
void require_usable(const SimulationScript& script, const std::string& file);

// Simulated world in front of the bench's devices: a moving leg, a tracker, a stage, a potentiometer.

/// True state, without noise.
struct SimulatedTruth {
  LegAngles angles;  ///< as scripted; with a motion, the attitude it returns
  Pose X_femur_tibia = Pose::Identity();
  Pose X_tracker_femur = Pose::Identity();  ///< of the bone; likewise the tibia's
  Pose X_tracker_tibia = Pose::Identity();
  Pose X_tracker_head = Pose::Identity();
  double stage_mm = 0.0;
  double potentiometer_count = 0.0;
};

class RandomSequence;

struct SimulatedTool {
  Pose X_tracker_tool = Pose::Identity();  ///< of a marker the position only
  bool is_seen = true;
};

/// A tick of the tracker.
struct SimulatedFrame {
  double time_s = 0.0;  ///< of the tick
  double send_s = 0.0;  ///< with jitter
  std::int64_t device_ns = 0;
  bool is_dropped = false;           ///< not sent
  std::vector<SimulatedTool> tools;  ///< in the order of tool_names()
};

/// 5 micrometres a count: all four edges of a period are counted.
inline constexpr double stage_mm_a_count = 0.005;

class Simulation {
 public:
  /// Without a motion theta and the translation are 0. Throws InputError naming `file` if the script is
  /// inconsistent or contains attitudes where the motion is not solved.
  explicit Simulation(const SimulationScript& script, std::optional<store::Motion> motion = {},
                      const std::string& file = "simulation");

  /// A scripted attitude beyond the motion, whose nearest attitude the leg has instead: the first one, with
  /// the motion's range as the wanted value. Empty without one, or without a motion.
  std::optional<InputError::Facts> beyond_motion(const std::string& file) const;

  const std::vector<std::string>& tools() const { return tools_; }
  /// `time_s`: of the simulation, from 0.
  SimulatedTruth truth(double time_s) const;
  /// Tick k, at k / rate_hz seconds. Depends only on the script and k.
  SimulatedFrame frame(std::uint64_t k) const;
  /// Reading of the tracker's clock.
  std::int64_t device_ns(double time_s) const;

  /// Encoder count, 0 at stage position 0.
  std::int64_t stage_count(double time_s) const;
  /// 0 to 1023, with noise.
  int potentiometer_count(double time_s) const;

 private:
  LegAngles scripted_angles(double time_s) const;
  template <typename IsWrong>
  std::optional<std::string> first_where(const IsWrong& is_wrong) const;
  void require_solved(const std::string& file) const;
  bool is_hidden(const std::string& tool, double time_s) const;
  void add_body(SimulatedFrame& frame, const SimulatedBody& body, RandomSequence& draws) const;
  Pose X_tracker_body(const SimulatedBody& body, double time_s) const;

  SimulationScript script_;
  std::optional<store::Motion> motion_;
  std::vector<std::string> tools_;
  KeyPath flexion_rad_, varus_rad_, stage_mm_, potentiometer_;
};

// Random numbers seeded by purpose and index, independent of how many were drawn before.

/// Purpose of a random sequence.
enum class RandomPurpose : std::uint64_t {
  frame,
  potentiometer,
  virtual_bench,
  virtual_hand,
  virtual_tracker,
  tracker_jitter
};

class RandomSequence {
 public:
  /// Equal seed, purpose and index give an equal sequence.
  RandomSequence(std::uint64_t seed, RandomPurpose purpose, std::uint64_t index);
  /// In [0, 1), 53 bits.
  double uniform();
  /// Mean 0, variance 1, within +-6: the sum of twelve uniform numbers minus 6, with identical bits on
  /// every processor, since no logarithm is used.
  double normal();
  /// Three normal() numbers: x, y, z.
  Eigen::Vector3d normal_vector();

 private:
  std::mt19937_64 bits_;
};

}  // namespace vrda::bench
