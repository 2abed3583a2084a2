/// The parts of the procedure: which a bench has, what each rests on, and whether it can begin.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "setup/calibration.hpp"

namespace vrda {

/// In the order of doing them.
std::vector<CalibrationPart> parts_of(const BenchFile& bench);

/// Those whose results it uses, of the ones that the bench has.
std::vector<CalibrationPart> rests_on(CalibrationPart part, const BenchFile& bench);

/// Solved, and nothing that it rests on was done again since.
bool is_done(const Calibration& calibration, CalibrationPart part);

/// All that rest on `part`, and on those, are to be done again.
void outdate_after(Calibration& calibration, CalibrationPart part, const BenchFile& bench);

/// Parts named by a step of the command line; see guide/session.hpp.
std::vector<CalibrationPart> parts_of_step(const std::string& step, const BenchFile& bench);

/// Throws InputError naming the bench file's key when it lacks what the part wants.
void require_wanted(CalibrationPart part, const BenchFile& bench);

/// Their names, "rails, stop".
std::string names_of(std::span<const CalibrationPart> parts);

/// leg, femur or tibia
bool is_model_part(CalibrationPart part);
/// Whose body's model a part places.
BodyRole role_of(CalibrationPart part);
/// The points that it touches.
const std::vector<CalibrationPoint>& points_of(CalibrationPart part, const CalibrationSettings& settings);

/// The stage's encoder is read.
bool has_stage(const BenchFile& bench);

/// A nominal calibration with what `other` knows of the bench: its once-per-bench records, what they found of
/// the eyes' screens, table and stage; nothing of its person. Throws InputError naming `other_path` and the
/// part when one of them is not done.
Calibration begun_from(const Calibration& other, const BenchFile& bench, const std::string& other_path);

/// Throws InputError naming `path` unless `begun` has just the once-per-bench records of `other`.
void require_same_bench_parts(const Calibration& begun, const std::string& path, const Calibration& other,
                              const std::string& other_path);

/// Numbers of the bench file that a part's marks belong to, besides the names of its tasks: what was placed
/// before the eyes, touched or measured. Often none.
std::vector<double> bench_numbers_of(CalibrationPart part, const BenchFile& bench);

/// Throws InputError naming `path` and the part when a mark of its record belongs to no task, its rows are
/// not such as the task makes, or the bench file's numbers were others.
void require_of_plan(CalibrationPart part, const BenchFile& bench, const Calibration& begun,
                     const std::string& path);

/// For marks that are solved anew: they belong to the bench file's numbers as they are now, unless samples
/// hold them.
void take_numbers(CalibrationRecord& record, CalibrationPart part, const BenchFile& bench);

/// The same of `parts`, to be done in that order, and of all that they rest on, on and on. Throws InputError
/// when one is asked for before one it rests on, when the bench file lacks what it wants (which key), and
/// when the marks of earlier parts do not give what solving it takes from them.
void require_order(const std::vector<CalibrationPart>& parts, const BenchFile& bench,
                   const Calibration& begun, const std::string& path);

}  // namespace vrda
