/// A virtual bench, somebody at it, and a session.
#pragma once

#include <memory>
#include <string>

#include "guide/session.hpp"
#include "virtual_bench/operator.hpp"

namespace vrda::test {

/// The virtual bench's file with `changed` replaced by `into`, which must occur in it.
BenchFile virtual_bench(HeadKind head, const std::string& changed = "", const std::string& into = "");
/// Everything, or the parts of a step.
GuideOptions options_of(const BenchFile& bench, const std::string& step = "all");

/// On a stage.
const BenchFile& bench();
/// All its parts done, once for all tests.
const Calibration& all_done();
/// `step` of it, as whoever does it again.
GuideOptions anew(const std::string& step);

struct Trial {
  explicit Trial(const BenchFile& wanted, const std::string& step = "all");
  Trial(const BenchFile& wanted, const Calibration& begun, const GuideOptions& options);

  void press(Key key, bool has_shift = false, bool has_control = false);
  void press(char key);
  /// Does what is asked.
  void do_task();
  /// Does all tasks before that one. Stands there, or fails.
  void go_to(CalibrationPart part, const std::string& task);
  void do_part(CalibrationPart part);
  void do_all();
  /// Enter without aligning anything; then whatever samples are wanted.
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
