/// Simulated world in front of the bench's devices: a moving leg, a tracker, a stage, a potentiometer.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "store/poses.hpp"
#include "bench/script.hpp"
#include "bench/leg.hpp"

namespace vrda::bench {

/// True state, without noise.
struct SimulatedTruth {
  bench::LegAngles angles;  ///< as scripted; with a motion, the attitude it returns
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
  bench::LegAngles scripted_angles(double time_s) const;
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

}  // namespace vrda::bench
