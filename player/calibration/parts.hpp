/// The parts of the procedure: their list, which of them apply, their order and preconditions, and how they
/// are solved.
#pragma once

#include "calibration/eyepoint_fit.hpp"
#include "calibration/task.hpp"
#include "calibration/tracker_fits.hpp"

namespace vrda::calibration {

/// Object of a part.
const Part& part_object(CalibrationPart id);

/// Tasks of a part, determined by the bench file and the earlier estimates.
std::vector<Task> tasks_of(CalibrationPart id, const BenchFile& bench, const Calibration& calibration);

/// Range of tasks that are checked together.
struct TaskGroup {
  std::size_t begin = 0, end = 0;
};
TaskGroup task_group_of(CalibrationPart id, const std::vector<Task>& tasks, std::size_t task);

/// Parts that apply to a bench, in the order of execution.
std::vector<CalibrationPart> parts_of(const BenchFile& bench);

/// Parts of the bench whose results `id` uses.
std::vector<CalibrationPart> dependencies_of(CalibrationPart id, const BenchFile& bench);

/// Whether the part is solved and not outdated.
bool is_done(const Calibration& calibration, CalibrationPart id);

/// Marks all parts that depend on `id`, directly or indirectly, as outdated.
void outdate_dependents(Calibration& calibration, CalibrationPart id, const BenchFile& bench);

/// Parts of a command line step ("all", "bench", "person", "tracking" or a part) that apply to the bench.
/// Throws InputError with the step.
std::vector<CalibrationPart> parts_of_step(const std::string& step, const BenchFile& bench);

/// Throws InputError with the bench file's key if it lacks data for the part.
void require_bench_data(CalibrationPart id, const BenchFile& bench);

/// Comma-separated names: "rails, stop".
std::string names_of(std::span<const CalibrationPart> parts);

/// Whether the part is leg, femur or tibia.
bool is_model_part(CalibrationPart id);
/// Body of a model part, and the points of the model on it.
BodyRole role_of(CalibrationPart id);
const std::vector<CalibrationPoint>& points_of(BodyRole role, const CalibrationSettings& settings);

/// Whether the bench has a stage with an encoder.
bool has_stage(const BenchFile& bench);

/// Nominal calibration with the per-bench records and results of `other` (screens, table, stage) and without
/// its person. Throws InputError with `other_path` and the part if one of these parts is not done.
Calibration start_calibration_from(const Calibration& other, const BenchFile& bench,
                                   const std::string& other_path);

/// Throws InputError with `path` unless the per-bench records of `begun` and `other` are equal.
void require_same_bench_parts(const Calibration& begun, const std::string& path, const Calibration& other,
                              const std::string& other_path);

/// Checks records of `parts`, to be executed in this order, and of all their dependencies. Throws InputError
/// if a mark belongs to no task, its rows do not match the task kind, or the bench file had other values
/// (with the part); if a dependency is not done, the bench file lacks data (with the key), or a fit of
/// earlier marks fails.
void require_ready_parts(const std::vector<CalibrationPart>& parts, const PartInput& in);

/// Returns `begun` with the estimate in the part's record and in the calibration values. All tasks must have
/// marks and all dependencies estimates; only marks and estimates of earlier parts are used. Throws
/// PartRefusal if a fit fails.
Calibration solve_part(CalibrationPart id, const PartInput& in);

/// Solves all complete parts again, from the marks and the current bench file. Throws InputError.
Calibration solve_again(const BenchFile& bench, const Calibration& calibration, const std::string& path);

/// "PART is done:"; one line per number with its 95 % interval ("left.k1 0.1023 +- 0.0012"), then residual
/// and remarks.
std::vector<std::string> result_lines(CalibrationPart id, const Estimate& estimate);

// What parts use of each other.

/// Throws PartRefusal if the mark of task `done` crosses a scan of the opposite edge.
void require_edge_order(const std::vector<Task>& tasks, const CalibrationRecord& record, std::size_t done,
                        const std::string& path);
/// Marks of the rectangles of one eye and the fit to them. Throws PartRefusal.
EyeRectangles solve_eye_rectangles(const PartInput& in, bool is_right);
/// Side of the frame of the depth check.
inline constexpr double test_frame_size_mm = 100.0;
/// Requested marker position of a bull's-eye: -1, 0 or 1 for left to right, low to high, near to far. The
/// first six spread in all directions.
Eigen::Vector3i requested_marker_position(int index);
void put_model(Calibration& c, BodyRole role, const Pose& X_body_model);
/// Touched points of a model, in the frame of its body.
std::vector<Fiducial> touched_points(BodyRole role, const PartInput& in);

}  // namespace vrda::calibration
