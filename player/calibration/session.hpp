/// A calibration session: the dials of a task, the rows collected from tracker and board samples, the marks.
#pragma once

#include <set>
#include <utility>

#include "bench/body_tracker.hpp"
#include "calibration/marks.hpp"
#include "calibration/parts.hpp"
#include "view/keys.hpp"

namespace vrda::calibration {

/// A motion of the pointer with a pressed button, from the press: x right, y down, in pixels.
struct DialDrag {
  Eigen::Vector2d moved_px = Eigen::Vector2d::Zero();
  bool is_second = false;  ///< right button: the second of two dials
  bool is_fine = false;    ///< a tenth
};

class Dials {
 public:
  Dials() : Dials(Task{}) {}
  explicit Dials(const Task& task);

  std::span<const double> values() const { return values_; }
  std::size_t selected() const { return selected_; }
  /// Whether each dial was changed by the operator, also if it is back at its start value.
  const std::vector<bool>& touched() const { return touched_; }

  /// Handles arrow keys (session.hpp); ignores others.
  void press(const view::KeyPress& press);
  /// Handles a potentiometer value: 200 steps per turn, relative to its position when the dial was selected.
  void turn(int count, double time_s);
  /// Marks the values from which drag() counts.
  void begin_drag() { drag_start_ = values_; }
  /// Dials in px follow the pointer, others change by a step a pixel: a cross in both directions, a row
  /// vertically, everything else horizontally; of more than two dials the selected one. Ignored without
  /// begin_drag().
  void drag(const DialDrag& drag);

 private:
  void change(std::size_t dial, double steps);
  void assign(std::size_t dial, double value);
  void set(std::size_t dial, double value);
  void select(std::size_t dial);

  std::vector<Dial> dials_;
  bool is_cross_ = false;  ///< Up decreases y
  bool is_row_ = false;    ///< a scan line that moves vertically
  std::vector<double> values_;
  std::vector<bool> touched_;
  std::vector<double> drag_start_;  ///< empty: no drag
  std::size_t selected_ = 0;
  bench::OneEuroFilter filter_;
  std::optional<double> start_count_;
  double start_value_ = 0.0;  ///< of the selected dial at start_count_
  double last_steps_ = 0.0;
};

// Rows of numbers for a task, from tracker and board samples.

class SampleCollector {
 public:
  explicit SampleCollector(const BenchFile& bench) : bench_(bench), trackers_(bench) {}

  /// Starts collecting rows for `task`.
  void begin(const Task& task);
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
  void zero_stage() { stage_mm_ = 0.0, is_stage_zeroed_ = true; }

 private:
  bool take_place(const bench::Sample& sample);
  void end_message(BodyRole role);
  bool take_leg();
  const bench::BodyTracker* fresh_body(double time_s);

  BenchFile bench_;
  bench::TrackedBodies trackers_;
  std::optional<double> stage_mm_;
  bool is_stage_zeroed_ = false;
  bool is_taking_ = false;
  TaskKind::Samples samples_ = TaskKind::Samples::none;
  std::size_t tool_ = 0;
  std::optional<BodyRole> role_;
  std::vector<std::vector<double>> rows_;
  /// bend: the last two poses of the thigh, and a pose of the shank without one of the thigh at its time.
  std::optional<bench::TimedPose> thigh_before_, thigh_, shank_;
};

/// Rounds mm to 10 nm, far below tracker noise, to keep files short.
double rounded_mm(double value);

// Guided calibration: presents the tasks in order, processes keys and samples, and solves each part when its
// tasks are done. No clock, device or screen.

struct CalibrationSessionOptions {
  std::vector<CalibrationPart> parts;  ///< requested parts, in order
  bool is_repeated = false;  ///< repeat the parts from the first task: their records become outdated
  std::string date;          ///< today
  std::string path;          ///< calibration file, for messages
  /// Motion of the model, unscaled; required for the part functional.
  std::optional<JointCurve> joint = std::nullopt;
};

/// Progress of the current part.
struct CalibrationProgress {
  CalibrationPart part = CalibrationPart::viewport;
  int n_tasks = 0, n_done = 0;  ///< tasks of the part
  int n_parts = 0, number = 0;  ///< requested parts; number of the current one, from 1
  double typical_left_s = 0.0;  ///< typical time of the remaining tasks of all requested parts
  int n_samples = 0;            ///< samples of the current task
  bool is_sampling = false;     ///< samples are being collected
  /// Messages for the operator: an error, the result of a part, the expected accuracy.
  std::vector<std::string> messages;
  bool has_error = false;  ///< the messages are an error; the rejected marks have been removed
};

/// Done so far of all requested parts, each counted the same; 0 to 1.
double overall_progress(const CalibrationProgress& progress);

/// An operator's time for the tasks so far, beside their typical time.
struct Pace {
  double typical_s = 0.0, used_s = 0.0;
};
/// The typical time scaled by the operator's pace, which counts more the longer it was observed; s.
double time_left_s(const Pace& pace, double typical_left_s);

class CalibrationSession {
 public:
  /// `begun`: calibration so far; unfinished parts resume after their last mark. Throws InputError if a
  /// dependency of a part is not done or the bench file lacks data (with the key).
  CalibrationSession(const BenchFile& bench, const Calibration& begun,
                     const CalibrationSessionOptions& options);

  /// Current task; nullptr when all parts are done.
  const Task* task() const { return at_task_ < tasks_.size() ? &tasks_[at_task_] : nullptr; }
  /// Current values of its dials.
  std::span<const double> values() const { return dials_.values(); }
  std::size_t selected_dial() const { return dials_.selected(); }
  const CalibrationProgress& progress() const { return progress_; }

  /// Left and Right change the first dial, Up and Down the second (a cross follows all four). With more than
  /// two dials Up and Down select a dial and Left and Right change it. One step; Shift ten, Control a
  /// hundred. Enter: confirm, or start sampling. Backspace: repeat the previous task. R: repeat the part. Z:
  /// zero the stage at its stop. Escape or Q: quit; finished tasks are kept.
  void take(const view::KeyPress& key);
  /// A button was pressed on the pointer, and it moved; ignored during sampling.
  void begin_drag();
  void take(const DialDrag& drag);
  /// Processes a sample, in order of arrival.
  void take(const bench::Sample& sample);
  /// Returns true once after the stage must be zeroed (stop task confirmed, or Z pressed).
  bool take_zero_request() { return std::exchange(must_zero_, false); }
  bool has_quit() const { return has_quit_; }

  /// Calibration so far, with all marks, estimates and values.
  const Calibration& calibration() const { return calibration_; }
  /// Calibration for drawing the current task; a depth check uses the values just measured.
  const Calibration& drawing_calibration() const { return looked_at_ ? *looked_at_ : calibration_; }
  /// Counts changes (mark, result, error); a new value means that the file must be written.
  std::uint64_t revision() const { return revision_; }

 private:
  CalibrationRecord& record() { return calibration_.records[progress_.part]; }
  CalibrationRecord record_so_far() const;
  PartInput input() const
  {
    return {bench_, calibration_, options_.path, options_.joint ? &*options_.joint : nullptr};
  }
  void mark_requested_outdated();
  void next_part();
  void begin_part(CalibrationPart part);
  void next_task_of_part();
  double typical_left_s() const;
  void confirm();
  void take_row();
  std::string objection_to(const Task& current) const;
  void put(CalibrationMark mark);
  void finish(std::vector<std::vector<double>> rows);
  void validate_and_solve(std::size_t done);
  void solve();
  void refuse(const PartRefusal& refusal, const TaskGroup& round);
  void show(std::vector<std::string> messages);
  void show_error(const std::string& why);
  void erase_mark(const std::string& task);
  void previous_task();
  void restart_part();
  void zero();
  void zero_by_key();

  BenchFile bench_;
  Calibration calibration_;
  CalibrationSessionOptions options_;
  SampleCollector collector_;
  std::size_t n_begun_ = 0;  ///< requested parts that were started or skipped
  std::vector<Task> tasks_;
  std::size_t at_task_ = 0;
  bool is_fresh_ = false;  ///< the first new mark will replace all old marks of the part
  Dials dials_;
  std::optional<Calibration> looked_at_;  ///< calibration for drawing a depth check
  std::vector<double> implausible_;  ///< dial values that were refused: confirmed again, they are accepted
  std::set<CalibrationPart> repeated_parts_;  ///< parts whose agreeing readings were refused as unexpected
  std::vector<double> cross_;                 ///< of the position being sampled: x, y as drawn, stage mm
  CalibrationProgress progress_;
  std::uint64_t revision_ = 0;
  bool must_zero_ = false, has_quit_ = false;
};

/// The key press of one notch of the wheel: Right and Left, with Shift Up and Down; Control as for keys.
view::KeyPress press_of_wheel(bool is_away, bool has_shift, bool has_control);

/// Help lines of the keys.
std::span<const view::HelpLine> session_key_lines();

}  // namespace vrda::calibration
