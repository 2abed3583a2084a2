/// A virtual bench, a simulated operator and a session.
#pragma once

#include <memory>
#include <string>

#include "guide/session.hpp"
#include "virtual_bench/operator.hpp"

namespace vrda::test {

/// The virtual bench's file with `changed` replaced by `into`, which must occur in it.
BenchFile virtual_bench(HeadKind head, const std::string& changed = "", const std::string& into = "");
/// Options for all parts, or for those of a step.
GuideOptions options_of(const BenchFile& bench, const std::string& step = "all");

/// Bench with a stage.
const BenchFile& bench();
/// Calibration with all parts done, computed once.
const Calibration& all_done();
/// Options that repeat `step`.
GuideOptions anew(const std::string& step);

struct Trial {
  explicit Trial(const BenchFile& wanted, const std::string& step = "all");
  Trial(const BenchFile& wanted, const Calibration& begun, const GuideOptions& options);

  void press(Key key, bool has_shift = false, bool has_control = false);
  void press(char key);
  /// Does the current task.
  void do_task();
  /// Does all tasks before `task` of `part`, or fails.
  void go_to(CalibrationPart part, const std::string& task);
  void do_part(CalibrationPart part);
  void do_all();
  /// Confirms without alignment and sends the samples.
  void do_badly();
  std::string words() const;
  bool is_asked(CalibrationPart part, const std::string& task) const;
  const CalibrationRecord& record(CalibrationPart part) const;

  BenchFile bench;
  VirtualTruth truth;
  VirtualOperator somebody;
  std::unique_ptr<GuideSession> session;
};

}  // namespace vrda::test
