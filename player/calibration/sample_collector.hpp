/// Collects rows of numbers for a task from tracker and board samples.
#pragma once

#include <array>
#include <optional>

#include "bench/body_tracker.hpp"
#include "calibration/task.hpp"
#include "bench/sample.hpp"

namespace vrda::calibration {

class SampleCollector {
 public:
  explicit SampleCollector(const BenchFile& bench);

  /// Starts collecting rows for `task`, with the pose of the body `role` if given.
  void begin(const Task& task, const std::optional<BodyRole>& role);
  void end() { is_taking_ = false; }
  bool is_sampling() const { return is_taking_; }
  const std::vector<std::vector<double>>& rows() const { return rows_; }

  /// Processes a sample (in order of arrival). Returns true if it added a row.
  bool take(const bench::Sample& sample);

  /// Empty before the first message of the board.
  const std::optional<double>& stage_mm() const { return stage_mm_; }
  /// Whether the stage was zeroed since the board was switched on.
  bool is_stage_zeroed() const { return is_stage_zeroed_; }
  /// Mirrors the zero command that is sent to the board.
  void zero_stage();

 private:
  bool take_place(const bench::Sample& sample);
  void end_message(bench::BodyTracker& tracker);
  bool take_leg();
  const bench::BodyTracker* fresh_body(double time_s);

  BenchFile bench_;
  bench::TrackedBodies trackers_;
  std::optional<double> stage_mm_;
  bool is_stage_zeroed_ = false;
  bool is_taking_ = false;
  TaskKind kind_ = TaskKind::sweep;
  std::size_t tool_ = 0;
  std::optional<BodyRole> role_;
  std::vector<std::vector<double>> rows_;
  /// bend: the last two poses of the thigh, and a pose of the shank without one of the thigh at its time.
  std::optional<bench::TimedPose> thigh_before_, thigh_, shank_;
};

/// Rounds mm to 10 nm, far below tracker noise, to keep files short.
double rounded_mm(double value);

}  // namespace vrda::calibration
