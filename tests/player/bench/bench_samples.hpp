/// Benches without devices, with synthetic samples.
#pragma once

#include "bench/bench_state.hpp"
#include "bench/recording.hpp"
#include "bench/rigid_body.hpp"

namespace vrda::test {

inline constexpr std::int64_t ms_in_ns = 1'000'000;

bench::Sample place_sample(std::uint16_t tool, const Pose& X_tracker_tool, std::int64_t device_ns,
                           std::int64_t arrival_ns);
bench::Sample hidden_sample(std::uint16_t tool, std::int64_t arrival_ns);
bench::Sample potentiometer_sample(int count, std::int64_t arrival_ns);
bench::Sample stage_sample(int count, std::int64_t arrival_ns, std::uint8_t flags = 0);
bench::Sample link_sample(bench::DeviceId device, bench::LinkState state, std::int64_t arrival_ns);

/// A model with flexion 0 to 90 and varus -4 to 4 degrees, whose tibia translates and rotates with both.
store::MotionModel bench_model(const std::string& side);

/// A bench with its state.
struct SmallBench {
  /// `text`: bench file; the calibration is random but usable.
  explicit SmallBench(const std::string& text, const std::string& side = "right");

  store::MotionModel model;
  store::Motion motion;
  SolverFrame frame;
  bench::BenchFile bench;
  bench::Calibration calibration;
  bench::BenchState state;

  Pose X_body_model(bench::BodyRole role) const;
  /// Pose of the tibia's body for the femur's body at `X_tracker_thigh` and the knee at `angles`.
  Pose X_tracker_shank(const Pose& X_tracker_thigh, const bench::LegAngles& angles) const;
  /// Samples of both bodies in these poses, as one message.
  void take_leg(const Pose& X_tracker_thigh, const bench::LegAngles& angles, std::int64_t device_ns,
                std::int64_t arrival_ns);
};

/// Bench with two bodies (tools), no filter, and a board.
std::string two_bodies_text(const std::string& head = "stage");
/// Bench with a rigid leg (tool); the potentiometer drives the parameter `potentiometer`.
std::string rigid_text(const std::string& potentiometer = "selected");

/// A pose 1 m from the tracker.
Pose some_pose(int number);

/// A body at `start` at time 0 with the constant velocity `a_second` in body axes.
Pose moved(const Pose& start, const bench::Screw& a_second, double time_s);

double distance_of(const Pose& a, const Pose& b);

// Generated recordings, and whole recordings in memory.

bench::RecordingFacts sample_facts();

/// Samples of every kind and various keys; some frames have none.
std::vector<bench::RecordedFrame> sample_pictures(int n);

/// File contents of a recording.
std::string recording_bytes(const bench::RecordingFacts& facts,
                            const std::vector<bench::RecordedFrame>& pictures);

/// A reader of such contents, which must outlive it; `n_read` counts the bytes it asks for.
bench::RecordingReader reader_of(const std::string& bytes, std::size_t* n_read = nullptr);

/// All frames of a recording.
std::vector<bench::RecordedFrame> frames_of(bench::RecordingReader reader);

/// Whether both are bitwise equal.
bool is_same(const bench::RecordedFrame& a, const bench::RecordedFrame& b);

}  // namespace vrda::test
