/// Benches without devices: samples made by hand.
#pragma once

#include <string>

#include "bench/bench_state.hpp"
#include "devices/sample.hpp"
#include "tracking/screw.hpp"

namespace vrda::test {

inline constexpr std::int64_t ms_in_ns = 1'000'000;

Sample place_sample(std::uint16_t tool, const Pose& X_tracker_tool, std::int64_t device_ns,
                    std::int64_t arrival_ns);
Sample hidden_sample(std::uint16_t tool, std::int64_t arrival_ns);
Sample potentiometer_sample(int count, std::int64_t arrival_ns);
Sample stage_sample(int count, std::int64_t arrival_ns, std::uint8_t flags = 0);
Sample link_sample(DeviceId device, LinkState state, std::int64_t arrival_ns);

/// A model of flexion 0 to 90 and varus -4 to 4 degrees, whose tibia moves and turns with both.
MotionModel bench_model(const std::string& side);

/// A bench and the state made of it.
struct SmallBench {
  /// `text` of a bench file; the calibration is random but usable.
  explicit SmallBench(const std::string& text, const std::string& side = "right");

  MotionModel model;
  Motion motion;
  SolverFrame frame;
  BenchFile bench;
  Calibration calibration;
  BenchState state;

  Pose X_body_model(BodyRole role) const;
  /// The tibia's body where the femur's is at `X_tracker_thigh` and the knee at `angles`.
  Pose X_tracker_shank(const Pose& X_tracker_thigh, const LegAngles& angles) const;
  /// Both bodies so, in one message.
  void take_leg(const Pose& X_tracker_thigh, const LegAngles& angles, std::int64_t device_ns,
                std::int64_t arrival_ns);
};

/// Of two bodies by tools, unfiltered, with a board.
std::string two_bodies_text(const std::string& head = "stage");
/// A rigid leg by a tool; the potentiometer drives what `potentiometer` names.
std::string rigid_text(const std::string& potentiometer = "selected");

/// Some pose a metre from the tracker.
Pose some_pose(int number);

/// A body that is at `start` at time 0 and goes on at `a_second`, in its own axes.
Pose moved(const Pose& start, const Screw& a_second, double time_s);

double distance_of(const Pose& a, const Pose& b);

}  // namespace vrda::test
