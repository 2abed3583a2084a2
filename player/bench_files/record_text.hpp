/// The records of a calibration file (schemas/calibration.md).
#pragma once

#include <map>

#include "bench_files/calibration_record.hpp"
#include "documents/document.hpp"

namespace vrda::bench_files {

using CalibrationRecords = std::map<CalibrationPart, CalibrationRecord>;

/// Reads the records of a schema-checked file; may be empty. Throws InputError with file and key.
CalibrationRecords read_calibration_records(const documents::Document& document);

/// TOML tables for the end of the file; reading them gives equal records.
std::string records_text(const CalibrationRecords& records);

}  // namespace vrda::bench_files
