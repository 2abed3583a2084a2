/// Parts of the procedure: applicability to a bench, dependencies and preconditions.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "bench_files/calibration.hpp"

namespace vrda::calibration_tasks {

/// Parts that apply to a bench, in the order of execution.
std::vector<bench_files::CalibrationPart> parts_of(const bench_files::BenchFile& bench);

/// Parts of the bench whose results `part` uses.
std::vector<bench_files::CalibrationPart> dependencies_of(bench_files::CalibrationPart part,
                                                          const bench_files::BenchFile& bench);

/// Whether the part is solved and not outdated.
bool is_done(const bench_files::Calibration& calibration, bench_files::CalibrationPart part);

/// Marks all parts that depend on `part`, directly or indirectly, as outdated.
void outdate_dependents(bench_files::Calibration& calibration, bench_files::CalibrationPart part,
                        const bench_files::BenchFile& bench);

/// Parts of a command line step; see guide/session.hpp.
std::vector<bench_files::CalibrationPart> parts_of_step(const std::string& step,
                                                        const bench_files::BenchFile& bench);

/// Throws InputError with the bench file's key if it lacks data for the part.
void require_bench_data(bench_files::CalibrationPart part, const bench_files::BenchFile& bench);

/// Comma-separated names: "rails, stop".
std::string names_of(std::span<const bench_files::CalibrationPart> parts);

/// Whether the part is leg, femur or tibia.
bool is_model_part(bench_files::CalibrationPart part);
/// Body of a model part.
bench_files::BodyRole role_of(bench_files::CalibrationPart part);
/// Points of a model part.
const std::vector<bench_files::CalibrationPoint>& points_of(bench_files::CalibrationPart part,
                                                            const bench_files::CalibrationSettings& settings);

/// Whether the bench has a stage with an encoder.
bool has_stage(const bench_files::BenchFile& bench);

/// Nominal calibration with the per-bench records and results of `other` (screens, table, stage) and without
/// its person. Throws InputError with `other_path` and the part if one of these parts is not done.
bench_files::Calibration start_calibration_from(const bench_files::Calibration& other,
                                                const bench_files::BenchFile& bench,
                                                const std::string& other_path);

/// Throws InputError with `path` unless the per-bench records of `begun` and `other` are equal.
void require_same_bench_parts(const bench_files::Calibration& begun, const std::string& path,
                              const bench_files::Calibration& other, const std::string& other_path);

/// Bench file values on which the marks of a part depend (`made_with`); may be empty.
std::vector<double> bench_numbers_of(bench_files::CalibrationPart part, const bench_files::BenchFile& bench);

/// Throws InputError with `path` and the part if a mark belongs to no task, its rows do not match the task
/// kind, or the bench file had other values.
void require_current_record(bench_files::CalibrationPart part, const bench_files::BenchFile& bench,
                            const bench_files::Calibration& begun, const std::string& path);

/// Updates the record's bench file values before solving again, unless the samples depend on them.
void update_made_with(bench_files::CalibrationRecord& record, bench_files::CalibrationPart part,
                      const bench_files::BenchFile& bench);

/// require_current_record() for `parts`, to be executed in this order, and for all their dependencies. Also
/// throws InputError if a dependency is not done, the bench file lacks data (with the key), or a fit of
/// earlier marks fails.
void require_ready_parts(const std::vector<bench_files::CalibrationPart>& parts,
                         const bench_files::BenchFile& bench, const bench_files::Calibration& begun,
                         const std::string& path);

}  // namespace vrda::calibration_tasks
