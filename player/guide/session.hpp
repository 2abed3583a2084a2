/// The guided procedure: asks for one task after the other, takes keys and samples, solves each part when its
/// tasks are done. No clock, no device, no screen.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "devices/sample.hpp"
#include "guide/task.hpp"
#include "view/keys.hpp"

namespace vrda {

struct GuideOptions {
  std::vector<CalibrationPart> parts;  ///< to be done, in order
  bool is_anew = false;  ///< their records are outdated at once: they are done from the first task
  std::string date;      ///< of today
  std::string path;      ///< of the calibration file, for messages
};

/// How far it is.
struct GuideProgress {
  CalibrationPart part = CalibrationPart::viewport;
  int n_tasks = 0, n_done = 0;  ///< of that part
  int n_samples = 0;            ///< taken of the task at hand
  bool is_taking = false;       ///< samples are being taken
  /// What the operator has to know: a refusal with its reason, a part's result, what is to be expected.
  std::vector<std::string> words;
  bool is_refused = false;  ///< the words are a refusal; marks to be done again have been taken away
};

/// Parts named by a step of the command line ("all", "bench" and "person" for those once a bench and once a
/// person, "tracking", or a part itself) that make sense on that bench. Throws InputError naming the step.
std::vector<CalibrationPart> parts_of_step(const std::string& step, const BenchFile& bench);

class GuideSession {
 public:
  /// `begun`: what is calibrated so far; parts under way go on behind their last mark. Throws InputError when
  /// a part is asked for before one it rests on, or the bench file lacks what it wants (which key).
  GuideSession(const BenchFile& bench, const Calibration& begun, const GuideOptions& options);
  ~GuideSession();
  GuideSession(const GuideSession&) = delete;
  GuideSession& operator=(const GuideSession&) = delete;

  /// The one at hand; nothing: all parts are done.
  const Task* task() const;
  /// Of its dials, as they stand.
  std::span<const double> values() const;
  std::size_t selected_dial() const;
  const GuideProgress& progress() const;

  /// Left and Right change the first dial, Up and Down the second (a cross moves with all four); of tasks of
  /// more than two dials Up and Down select, Left and Right change. A step; with Shift ten, with Control a
  /// hundred. Enter: it is aligned, or begins to take samples. Backspace: the task before again. R: the part
  /// from its first task. Z: the stage stands against its stop, which is zero. Escape or Q: leave; everything
  /// done so far is kept.
  void take(const KeyPress& press);
  /// In the order of arrival.
  void take(const Sample& sample);
  /// The stage is to be set to zero (a stop task was confirmed, or Z pressed); true once.
  bool zeroes_stage();
  bool is_left() const;

  /// With every mark, estimate and value so far.
  const Calibration& calibration() const;
  /// What the task at hand is drawn by: of a look, eyes and image distance as the part's marks have them.
  const Calibration& drawn_by() const;
  /// Grows from 0 with every mark, result and refusal: time to write the file.
  std::uint64_t revision() const;

 private:
  struct Inner;
  std::unique_ptr<Inner> inner_;
};

/// Solves every part of `calibration` anew that has all its marks, from the marks and the bench file's
/// numbers as they are now. Throws InputError.
Calibration solved_again(const BenchFile& bench, const Calibration& calibration, const std::string& path);

/// Keys and what they do.
std::span<const HelpLine> guide_key_lines();

}  // namespace vrda
