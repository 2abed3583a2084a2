/// Guided calibration: presents the tasks in order, processes keys and samples, and solves each part when its
/// tasks are done. No clock, device or screen.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "calibration_tasks/task.hpp"
#include "devices/sample.hpp"
#include "navigation/keys.hpp"

namespace vrda::calibration_tasks {

struct CalibrationSessionOptions {
  std::vector<bench_files::CalibrationPart> parts;  ///< requested parts, in order
  bool is_repeated = false;  ///< repeat the parts from the first task: their records become outdated
  std::string date;          ///< today
  std::string path;          ///< calibration file, for messages
};

/// Progress of the current part.
struct CalibrationProgress {
  bench_files::CalibrationPart part = bench_files::CalibrationPart::viewport;
  int n_tasks = 0, n_done = 0;  ///< tasks of the part
  int n_samples = 0;            ///< samples of the current task
  bool is_sampling = false;     ///< samples are being collected
  /// Messages for the operator: an error, the result of a part, the expected accuracy.
  std::vector<std::string> messages;
  bool has_error = false;  ///< the messages are an error; the rejected marks have been removed
};

/// Parts of a command line step ("all", "bench", "person", "tracking" or a part) that apply to the bench.
/// Throws InputError with the step.
std::vector<bench_files::CalibrationPart> parts_of_step(const std::string& step,
                                                        const bench_files::BenchFile& bench);

class CalibrationSession {
 public:
  /// `begun`: calibration so far; unfinished parts resume after their last mark. Throws InputError if a
  /// dependency of a part is not done or the bench file lacks data (with the key).
  CalibrationSession(const bench_files::BenchFile& bench, const bench_files::Calibration& begun,
                     const CalibrationSessionOptions& options);
  ~CalibrationSession();
  CalibrationSession(const CalibrationSession&) = delete;
  CalibrationSession& operator=(const CalibrationSession&) = delete;

  /// Current task; nullptr when all parts are done.
  const Task* task() const;
  /// Current values of its dials.
  std::span<const double> values() const;
  std::size_t selected_dial() const;
  const CalibrationProgress& progress() const;

  /// Left and Right change the first dial, Up and Down the second (a cross follows all four). With more than
  /// two dials Up and Down select a dial and Left and Right change it. One step; Shift ten, Control a
  /// hundred. Enter: confirm, or start sampling. Backspace: repeat the previous task. R: repeat the part. Z:
  /// zero the stage at its stop. Escape or Q: quit; finished tasks are kept.
  void take(const navigation::KeyPress& press);
  /// Processes a sample, in order of arrival.
  void take(const devices::Sample& sample);
  /// Returns true once after the stage must be zeroed (stop task confirmed, or Z pressed).
  bool take_zero_request();
  bool has_quit() const;

  /// Calibration so far, with all marks, estimates and values.
  const bench_files::Calibration& calibration() const;
  /// Calibration for drawing the current task; a depth check uses the values just measured.
  const bench_files::Calibration& drawing_calibration() const;
  /// Counts changes (mark, result, error); a new value means that the file must be written.
  std::uint64_t revision() const;

 private:
  struct Inner;
  std::unique_ptr<Inner> inner_;
};

/// Solves all complete parts again, from the marks and the current bench file. Throws InputError.
bench_files::Calibration solve_again(const bench_files::BenchFile& bench,
                                     const bench_files::Calibration& calibration, const std::string& path);

/// Help lines of the keys.
std::span<const navigation::HelpLine> session_key_lines();

}  // namespace vrda::calibration_tasks
