/// Guided calibration: presents the tasks in order, processes keys and samples, and solves each part when its
/// tasks are done. No clock, device or screen.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "devices/sample.hpp"
#include "guide/task.hpp"
#include "view/keys.hpp"

namespace vrda {

struct GuideOptions {
  std::vector<CalibrationPart> parts;  ///< requested parts, in order
  bool is_anew = false;  ///< repeat the parts from the first task: their records become outdated
  std::string date;      ///< today
  std::string path;      ///< calibration file, for messages
};

/// Progress of the current part.
struct GuideProgress {
  CalibrationPart part = CalibrationPart::viewport;
  int n_tasks = 0, n_done = 0;  ///< tasks of the part
  int n_samples = 0;            ///< samples of the current task
  bool is_taking = false;       ///< samples are being collected
  /// Messages for the operator: an error, the result of a part, the expected accuracy.
  std::vector<std::string> words;
  bool is_refused = false;  ///< the messages are an error; the rejected marks have been removed
};

/// Parts of a command line step ("all", "bench", "person", "tracking" or a part) that apply to the bench.
/// Throws InputError with the step.
std::vector<CalibrationPart> parts_of_step(const std::string& step, const BenchFile& bench);

class GuideSession {
 public:
  /// `begun`: calibration so far; unfinished parts resume after their last mark. Throws InputError if a
  /// dependency of a part is not done or the bench file lacks data (with the key).
  GuideSession(const BenchFile& bench, const Calibration& begun, const GuideOptions& options);
  ~GuideSession();
  GuideSession(const GuideSession&) = delete;
  GuideSession& operator=(const GuideSession&) = delete;

  /// Current task; nullptr when all parts are done.
  const Task* task() const;
  /// Current values of its dials.
  std::span<const double> values() const;
  std::size_t selected_dial() const;
  const GuideProgress& progress() const;

  /// Left and Right change the first dial, Up and Down the second (a cross follows all four). With more than
  /// two dials Up and Down select a dial and Left and Right change it. One step; Shift ten, Control a
  /// hundred. Enter: confirm, or start sampling. Backspace: repeat the previous task. R: repeat the part. Z:
  /// zero the stage at its stop. Escape or Q: quit; finished tasks are kept.
  void take(const KeyPress& press);
  /// Processes a sample, in order of arrival.
  void take(const Sample& sample);
  /// Returns true once after the stage must be zeroed (stop task confirmed, or Z pressed).
  bool zeroes_stage();
  bool is_left() const;

  /// Calibration so far, with all marks, estimates and values.
  const Calibration& calibration() const;
  /// Calibration for drawing the current task; a depth check uses the values just measured.
  const Calibration& drawn_by() const;
  /// Counts changes (mark, result, error); a new value means that the file must be written.
  std::uint64_t revision() const;

 private:
  struct Inner;
  std::unique_ptr<Inner> inner_;
};

/// Solves all complete parts again, from the marks and the current bench file. Throws InputError.
Calibration solved_again(const BenchFile& bench, const Calibration& calibration, const std::string& path);

/// Help lines of the keys.
std::span<const HelpLine> guide_key_lines();

}  // namespace vrda
