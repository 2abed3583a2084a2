/// Whether what is asked for can be begun: order, marks that belong to the bench file, what earlier marks
/// say.
#pragma once

#include "guide/task.hpp"

namespace vrda {

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
