/// Parts of the procedure: applicability to a bench, dependencies and preconditions.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "calibration/task.hpp"

namespace vrda::calibration {

/// Parts that apply to a bench, in the order of execution.
std::vector<CalibrationPart> parts_of(const BenchFile& bench);

/// Whether the part only refines others and is done only when requested by name.
bool is_optional(CalibrationPart part);

/// Parts of the bench whose results `part` uses.
std::vector<CalibrationPart> dependencies_of(CalibrationPart part, const BenchFile& bench);

/// Whether the part is solved and not outdated.
bool is_done(const Calibration& calibration, CalibrationPart part);

/// Marks all parts that depend on `part`, directly or indirectly, as outdated.
void outdate_dependents(Calibration& calibration, CalibrationPart part, const BenchFile& bench);

/// Parts of a command line step ("all", "bench", "person", "tracking" or a part) that apply to the bench.
/// Throws InputError with the step.
std::vector<CalibrationPart> parts_of_step(const std::string& step, const BenchFile& bench);

/// Throws InputError with the bench file's key if it lacks data for the part.
void require_bench_data(CalibrationPart part, const BenchFile& bench);

/// Comma-separated names: "rails, stop".
std::string names_of(std::span<const CalibrationPart> parts);

/// Whether the part is leg, femur or tibia.
bool is_model_part(CalibrationPart part);
/// Body of a model part.
BodyRole role_of(CalibrationPart part);
/// Points of a model part.
const std::vector<CalibrationPoint>& points_of(CalibrationPart part, const CalibrationSettings& settings);

/// Whether the bench has a stage with an encoder.
bool has_stage(const BenchFile& bench);

/// Nominal calibration with the per-bench records and results of `other` (screens, table, stage) and without
/// its person. Throws InputError with `other_path` and the part if one of these parts is not done.
Calibration start_calibration_from(const Calibration& other, const BenchFile& bench,
                                   const std::string& other_path);

/// Throws InputError with `path` unless the per-bench records of `begun` and `other` are equal.
void require_same_bench_parts(const Calibration& begun, const std::string& path, const Calibration& other,
                              const std::string& other_path);

/// Bench file values on which the marks of a part depend (`made_with`); may be empty.
std::vector<double> bench_numbers_of(CalibrationPart part, const BenchFile& bench);

/// Throws InputError with the part if a mark belongs to no task, its rows do not match the task
/// kind, or the bench file had other values.
void require_current_record(CalibrationPart part, const PartInput& in);

/// Updates the record's bench file values before solving again, unless the samples depend on them.
void update_made_with(CalibrationRecord& record, CalibrationPart part, const BenchFile& bench);

/// require_current_record() for `parts`, to be executed in this order, and for all their dependencies. Also
/// throws InputError if a dependency is not done, the bench file lacks data (with the key), or a fit of
/// earlier marks fails.
void require_ready_parts(const std::vector<CalibrationPart>& parts, const PartInput& in);

}  // namespace vrda::calibration
