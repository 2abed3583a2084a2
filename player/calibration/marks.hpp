/// Access to marks and estimates, the eyes as estimated by earlier parts, checks of marks, and errors with
/// the tasks that must be repeated.
#pragma once

#include "calibration/task.hpp"

namespace vrda::calibration {

/// Mark of `task` in a record, or nullptr.
const CalibrationMark* find_mark(const CalibrationRecord& record, const std::string& task);

/// Index of the first task without a mark, or the number of tasks.
std::size_t next_task(const std::vector<Task>& tasks, const CalibrationRecord& record);

/// Inserts `mark` in task order, replacing an earlier mark of the task.
void insert_mark(CalibrationRecord& record, const std::vector<Task>& tasks, CalibrationMark mark);

/// Throws InputError with `path` and the record's key `place` if a mark belongs to no task or its rows do not
/// match the task kind.
void require_task_marks(const CalibrationRecord& record, const std::vector<Task>& tasks,
                        const std::string& place, const std::string& path);

/// Pose from seven numbers of a row, starting at `at`.
Pose sampled_pose(std::span<const double> row, std::size_t at = 0);
/// Position from the first three numbers of a row.
Eigen::Vector3d sampled_position(std::span<const double> row);

/// A task with its mark, or nullptr.
struct MarkedTask {
  Task task;
  const CalibrationMark* mark = nullptr;
};
/// All tasks of a part; those of one eye that have a mark.
std::vector<MarkedTask> marked_tasks(CalibrationPart part, const PartInput& in);
std::vector<MarkedTask> tasks_of_eye(CalibrationPart part, const PartInput& in, bool is_right);
/// Names of the tasks.
std::vector<std::string> names_of(std::span<const MarkedTask> tasks);
/// Mark of a task that is done.
const CalibrationMark& mark_named(CalibrationPart part, const PartInput& in, const std::string& task);

/// Nominal eyes with the estimates of the parts of the display before `part`.
view::EyePair eyes_before(CalibrationPart part, const PartInput& in);

/// Record and estimate of a part, or nullptr.
const CalibrationRecord* find_record(const Calibration& calibration, CalibrationPart part);
const Estimate* find_estimate(const Calibration& calibration, CalibrationPart part);
/// Throws InputError if the estimate is missing.
const Estimate& estimate_of(CalibrationPart part, const PartInput& in);

/// Block of an estimate's covariance for `names`, scaled to the normal distribution with the same 95 %
/// intervals. Used as the prior covariance of later fits.
Eigen::MatrixXd prior_covariance(const Estimate& estimate, const std::vector<std::string>& names);

double value_in(const Estimate& estimate, const std::string& name);
/// Pose from the six numbers "name.shift_x" to "name.turn_z".
Pose pose_in(const Estimate& estimate, const std::string& name);
/// Names of the distortion numbers of one eye: "left.k1", ...
std::vector<std::string> distortion_names(bool is_right);

/// Mean and scatter of repeated positions.
struct MeanPosition {
  Eigen::Vector3d p_mm = Eigen::Vector3d::Zero();
  double sd_mm = 0.0;  ///< standard deviation of a coordinate of one sample
  double furthest_mm = 0.0;
};
MeanPosition mean_position(const std::vector<Eigen::Vector3d>& places);
/// Where the tool of a static measurement was, in the frame of the body that is sampled with it, else of the
/// tracker; empty for other kinds.
std::vector<Eigen::Vector3d> places_of(const Task& task, const CalibrationMark& mark);

class PartRefusal : public InputError {
 public:
  explicit PartRefusal(Facts facts, std::vector<std::string> tasks = {})
      : InputError(std::move(facts)), tasks_(std::move(tasks))
  {
  }
  /// Names of the tasks whose marks are rejected; empty: all checked tasks.
  const std::vector<std::string>& tasks() const { return tasks_; }

 private:
  std::vector<std::string> tasks_;
};

/// Runs a fit to the marks of `tasks` (same order) and converts FitError to PartRefusal with task names.
template <typename Fit>
auto run_fit(const std::vector<std::string>& tasks, const Fit& fit)
{
  try {
    return fit();
  } catch (const bench::FitError& refusal) {
    std::vector<std::string> rejected;
    for (const std::size_t mark : refusal.marks()) rejected.push_back(tasks.at(mark));
    throw PartRefusal(refusal.facts(), std::move(rejected));
  }
}

/// Message for the screen: field, found and wanted, without the file.
std::string screen_message(const InputError& error);

/// Throws PartRefusal if the samples of a static measurement moved.
void require_static(CalibrationPart part, const Task& task, const CalibrationMark& mark,
                    const std::string& path);

// Checks of readings before they become marks: not touched, implausible, at the place of another one. The
// texts are for the screen and say what to do; empty: nothing to object.

/// `touched`: whether each dial was changed since the task began. Both lines of a rectangle must be.
std::string untouched_text(const Task& task, const std::vector<bool>& touched);

/// A value outside the plausible range of its dial.
std::string implausible_text(const Task& task, std::span<const double> values);

/// Samples of a touched point or a marker position that are where those of another one were, within 1 mm: the
/// tool was not moved.
std::string same_place_text(const std::vector<Task>& tasks, const CalibrationRecord& record, const Task& task,
                            const CalibrationMark& mark);

/// Why the readings of a part, which agree with each other, must be measured again: its estimate, or
/// readings of `tasks` that were confirmed although implausible, are far from what the tasks start from.
std::string unexpected_text(const std::vector<Task>& tasks, const CalibrationRecord& record,
                            const Estimate& estimate, const Calibration& nominal);

}  // namespace vrda::calibration
