/// The records of a calibration file (schemas/calibration.md).
#pragma once

#include <map>

#include "documents/document.hpp"
#include "setup/calibration_record.hpp"

namespace vrda {

using CalibrationRecords = std::map<CalibrationPart, CalibrationRecord>;

/// Reads the records of a schema-checked file; may be empty. Throws InputError with file and key.
CalibrationRecords records_in(const Document& document);

/// TOML tables for the end of the file; reading them gives equal records.
std::string records_text(const CalibrationRecords& records);

}  // namespace vrda
