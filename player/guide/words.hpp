/// What the operator has to know before and after a part.
#pragma once

#include "guide/task.hpp"

namespace vrda {

/// What is to be expected of it; often nothing.
std::vector<std::string> words_before(CalibrationPart part, const BenchFile& bench,
                                      const Calibration& calibration);
/// Its result, a line a number.
std::vector<std::string> words_after(CalibrationPart part, const Estimate& estimate);

}  // namespace vrda
