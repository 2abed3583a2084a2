/// A virtual bench, a simulated operator and a session.
#pragma once

#include <memory>
#include <string>

#include "calibration_tasks/session.hpp"
#include "virtual_bench/operator.hpp"

namespace vrda::test {

/// The virtual bench's file with `changed` replaced by `into`, which must occur in it.
bench_files::BenchFile virtual_bench(bench_files::HeadKind head, const std::string& changed = "",
                                     const std::string& into = "");
/// Options for all parts, or for those of a step.
calibration_tasks::CalibrationSessionOptions options_of(const bench_files::BenchFile& bench,
                                                        const std::string& step = "all");

/// Bench with a stage.
const bench_files::BenchFile& bench();
/// Calibration with all parts done, computed once.
const bench_files::Calibration& all_done();
/// Options that repeat `step`.
calibration_tasks::CalibrationSessionOptions restarted(const std::string& step);

struct Trial {
  explicit Trial(const bench_files::BenchFile& wanted, const std::string& step = "all");
  Trial(const bench_files::BenchFile& wanted, const bench_files::Calibration& begun,
        const calibration_tasks::CalibrationSessionOptions& options);

  void press(navigation::Key key, bool has_shift = false, bool has_control = false);
  void press(char key);
  /// Does the current task.
  void do_task();
  /// Does all tasks before `task` of `part`, or fails.
  void go_to(bench_files::CalibrationPart part, const std::string& task);
  void do_part(bench_files::CalibrationPart part);
  void do_all();
  /// Confirms without alignment and sends the samples.
  void do_badly();
  std::string words() const;
  bool is_requested(bench_files::CalibrationPart part, const std::string& task) const;
  const bench_files::CalibrationRecord& record(bench_files::CalibrationPart part) const;

  bench_files::BenchFile bench;
  virtual_bench::VirtualTruth truth;
  virtual_bench::VirtualOperator virtual_operator;
  std::unique_ptr<calibration_tasks::CalibrationSession> session;
};

}  // namespace vrda::test
