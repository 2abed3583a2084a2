/// Rows of numbers for a task, from what tracker and board say.
#pragma once

#include <array>
#include <optional>

#include "bench/body_tracker.hpp"
#include "devices/sample.hpp"
#include "guide/task.hpp"

namespace vrda {

class SampleTaker {
 public:
  explicit SampleTaker(const BenchFile& bench);

  /// Takes rows for `task` from now on, together with where the body of `role` is.
  void begin(const Task& task, const std::optional<BodyRole>& role);
  void end() { is_taking_ = false; }
  bool is_taking() const { return is_taking_; }
  const std::vector<std::vector<double>>& rows() const { return rows_; }

  /// In the order of arrival; true: another row has come.
  bool take(const Sample& sample);

  /// Nothing before the board spoke.
  const std::optional<double>& stage_mm() const { return stage_mm_; }
  /// It was set to zero since the board was switched on.
  bool is_stage_zeroed() const { return is_stage_zeroed_; }
  /// As the board is being told.
  void zero_stage();

 private:
  bool take_place(const Sample& sample);
  const BodyTracker* fresh_body(double time_s);

  BenchFile bench_;
  std::array<std::optional<BodyTracker>, n_body_roles> trackers_;
  ClockMap clock_;
  std::optional<double> stage_mm_;
  bool is_stage_zeroed_ = false;
  bool is_taking_ = false;
  TaskKind kind_ = TaskKind::sweep;
  std::size_t tool_ = 0;
  std::optional<BodyRole> role_;
  std::vector<std::vector<double>> rows_;
};

/// mm to ten nanometres: far finer than any tracker, and files stay short.
double rounded_mm(double value);

}  // namespace vrda
