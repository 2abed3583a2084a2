/// A virtual bench, a simulated operator and a session.
#pragma once

#include <memory>

#include "calibration/operator.hpp"

namespace vrda::test {

/// The virtual bench's file with `changed` replaced by `into`, which must occur in it.
bench::BenchFile virtual_bench(bench::HeadKind head, const std::string& changed = "",
                               const std::string& into = "");
/// Options for all parts, or for those of a step.
calibration::CalibrationSessionOptions options_of(const bench::BenchFile& bench,
                                                  const std::string& step = "all");

/// Bench with a stage.
const bench::BenchFile& bench();
/// Calibration with all parts done, computed once.
const bench::Calibration& all_done();
/// Options that repeat `step`.
calibration::CalibrationSessionOptions restarted(const std::string& step);

/// A kind of task that has only traits.
struct PlainKind : calibration::TaskKind {
  using TaskKind::TaskKind;
  void sketch(calibration::Sketch&, const calibration::Task&, const bench::BenchFile&) const override {}
};

/// Name of the kind of a task: "scan line".
inline std::string kind_of(const calibration::Task& task)
{
  return task.kind->traits().name;
}

struct Trial {
  explicit Trial(const bench::BenchFile& wanted, const std::string& step = "all");
  Trial(const bench::BenchFile& wanted, const bench::Calibration& begun,
        const calibration::CalibrationSessionOptions& options);

  void press(view::Key key, bool has_shift = false, bool has_control = false);
  void press(char key);
  /// Does the current task.
  void do_task();
  /// Does all tasks before `task` of `part`, or fails.
  void go_to(bench::CalibrationPart part, const std::string& task);
  void do_part(bench::CalibrationPart part);
  void do_all();
  /// Confirms without alignment and sends the samples.
  void do_badly();
  /// Sends a sample of a static tool at `p_mm`, or of the stage.
  void send_still(const std::string& tool, const Eigen::Vector3d& p_mm);
  void send_stage(double at_mm, std::uint8_t flags = 0);
  std::string words() const;
  /// Expects an error with these words, after which the task is requested.
  void expect_refused(const std::string& with, bench::CalibrationPart part, const std::string& task) const;
  bool is_requested(bench::CalibrationPart part, const std::string& task) const;
  const bench::CalibrationRecord& record(bench::CalibrationPart part) const;

  bench::BenchFile bench;
  calibration::VirtualTruth truth;
  calibration::VirtualOperator virtual_operator;
  std::unique_ptr<calibration::CalibrationSession> session;
};

}  // namespace vrda::test
