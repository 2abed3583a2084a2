/// From a part's marks to numbers of the calibration.
#pragma once

#include <string>

#include "guide/task.hpp"

namespace vrda {

/// `begun` with the part's estimate in its record and what it found in the calibration's own fields. All of
/// the part's tasks must have marks, and the parts that it rests on estimates. Throws PartRefusal, of the
/// fits and where the samples say that something moved.
Calibration solved_part(CalibrationPart part, const BenchFile& bench, const Calibration& begun,
                        const std::string& path);

/// What solving `part` takes from marks of earlier parts: throws InputError naming that part, when they do
/// not give it. To be asked before the part is begun, as its own marks are not to blame.
void require_earlier_marks(CalibrationPart part, const BenchFile& bench, const Calibration& begun,
                           const std::string& path);

/// The marks of one round alone, which ends with `done`: throws PartRefusal as solving them would, and
/// returns what is to be said of them.
std::vector<std::string> round_remarks(CalibrationPart part, const BenchFile& bench, const Calibration& begun,
                                       const Task& done, const std::string& path);

/// The samples of one mark alone: throws PartRefusal when something moved that had to rest.
void require_still(CalibrationPart part, const Task& task, const CalibrationMark& mark,
                   const std::string& path);

/// "left.k1 0.1023 +- 0.0012": a line for each number of an estimate with its 95 % interval, then its
/// remarks.
std::vector<std::string> lines_of(const Estimate& estimate);

}  // namespace vrda
