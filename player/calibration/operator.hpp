/// Simulated operator: does the tasks of a calibration by key presses and tracker samples, with the noise of
/// a hand and an eye (VirtualNoise: px, mm, degrees). In: the session's current task and the truth. Out:
/// input to the session only. Equal seeds give equal input.
#pragma once

#include <map>
#include <mutex>

#include "bench/bench_run.hpp"
#include "bench/igtl_message.hpp"
#include "calibration/session.hpp"
#include "calibration/virtual_bench.hpp"

namespace vrda::calibration {

/// Sends the key presses and samples of a real bench; the session receives nothing else.
class VirtualOperator {
 public:
  VirtualOperator(const BenchFile& bench, const VirtualTruth& truth, const VirtualNoise& noise)
      : bench_(bench), truth_(truth), noise_(noise)
  {
  }

  /// Completes the current task. If it is refused, the repeated task is done by the next call.
  void do_task(CalibrationSession& session);
  int n_refusals() const { return n_refusals_; }
  /// For interactive training, once per frame: sends a tracker frame and the stage for the current task,
  /// and handles take_zero_request(). Does nothing if no samples are required.
  void send_samples(CalibrationSession& session);
  /// Poses of everything during the session's current task; `way` in [0, 1]: progress of a sweep.
  BenchPoses poses(const CalibrationSession& session, double way) const;
  /// Samples of tracker and stage at the poses, with noise by `frame`.
  std::vector<bench::Sample> samples(const CalibrationSession& session, const BenchPoses& poses,
                                     std::uint64_t frame) const;
  /// Values of the dials at which a careful hand has aligned the task; empty if it has none.
  std::vector<double> aligned_values(const CalibrationSession& session) const;
  /// Reading of ruler, tape or pupillometer for a task that requires a number; nullopt otherwise.
  std::optional<double> reading(const CalibrationSession& session) const;
  /// Distance of the dials from the truth; empty for a task without dials.
  std::optional<Deviation> deviation(const CalibrationSession& session) const;
  /// Physical things and drawn lines as the eyes see them during the current task; undistorted px.
  std::vector<DrawnLine> seen(const CalibrationSession& session) const;

 private:
  std::uint64_t draws_index(const CalibrationSession& session) const;
  TaskContext context(const CalibrationSession& session, RandomSequence& draws) const;
  RandomSequence hand(const CalibrationSession& session) const;
  BenchPoses standing(const CalibrationSession& session) const;
  void send_frame(CalibrationSession& session, const BenchPoses& poses);
  void handle_zeroing(CalibrationSession& session);
  void zero_stage(CalibrationSession& session);
  void take_samples(CalibrationSession& session);

  BenchFile bench_;
  VirtualTruth truth_;
  VirtualNoise noise_;
  std::map<std::string, int> n_done_;  ///< by part and task
  int n_refusals_ = 0;
  std::uint64_t n_frames_ = 0;  ///< of the current task
  std::int64_t time_ns_ = 0;
  bool is_stage_zeroed_ = false;
};

// `vrda-player simulate --rehearse FILE`: moves probe, marker and stage of a simulated bench as the
// calibration that is written to FILE requires next, so that `calibrate --bench` can be rehearsed without a
// bench. In: bench file, calibration so far, time (s). Out: tracker messages, encoder counts, and
// instructions in words.

/// Thread-safe.
class Rehearsal {
 public:
  /// `bench` must outlive it and have a table [calibration]. `parts`: those that are rehearsed.
  Rehearsal(const BenchFile& bench, std::vector<CalibrationPart> parts, std::uint64_t seed);

  /// Continues with the first task without a mark in `so_far` at `now_s`. Returns what a person would do
  /// then: "left eye, left edge, 1: column 132 px"; empty if the task is the same as before.
  std::string follow(const Calibration& so_far, double now_s);
  /// "press Enter" each time a sweep begins; empty in between.
  std::string prompt(double now_s);

  /// One message with the seen tools at tick `k` of the tracker, `now_s`.
  bench::IgtlMessage message(std::uint64_t k, double now_s) const;
  int stage_count(double now_s) const;

 private:
  double way(double now_s) const;
  BenchPoses poses(double now_s) const;
  int sweep_number(double now_s) const;

  const BenchFile& bench_;
  std::vector<CalibrationPart> parts_;
  VirtualTruth truth_;
  VirtualOperator operator_;
  mutable std::mutex mutex_;
  std::optional<CalibrationSession> session_;
  std::string task_;      ///< part and name
  double begun_s_ = 0.0;  ///< of the task
  int prompted_ = -1;     ///< sweep that was announced
};

/// Runs until `options.seconds` are over or a stop signal arrives. Throws InputError.
void rehearse(const bench::SimulateOptions& options, const show::Streams& streams);

}  // namespace vrda::calibration
