/// The records of a calibration file (schemas/calibration.md).
#pragma once

#include <map>

#include "documents/document.hpp"
#include "setup/calibration_record.hpp"

namespace vrda {

using CalibrationRecords = std::map<CalibrationPart, CalibrationRecord>;

/// Of a checked file; none where it has none. Throws InputError naming file and key of what does not fit
/// together.
CalibrationRecords records_in(const Document& document);

/// Tables behind everything else: reading them gives equal records.
std::string records_text(const CalibrationRecords& records);

}  // namespace vrda
