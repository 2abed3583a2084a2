/// `vrda-player simulate --rehearse FILE`: moves probe, marker and stage of a simulated bench as the
/// calibration that is written to FILE requires next, so that `calibrate --bench` can be rehearsed without a
/// bench. In: bench file, calibration so far, time (s). Out: tracker messages, encoder counts, and
/// instructions in words.
#pragma once

#include <mutex>

#include "bench/bench_run.hpp"
#include "bench/igtl_message.hpp"
#include "calibration/operator.hpp"

namespace vrda::calibration {

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
