/// The records of a calibration file (schemas/calibration.md).
#pragma once

#include <map>

#include "settings/settings_table.hpp"
#include "setup/calibration_record.hpp"

namespace vrda {

using CalibrationRecords = std::map<CalibrationPart, CalibrationRecord>;

/// Of the root table; none where the file has none. Throws InputError naming file and key.
CalibrationRecords records_in(const SettingsTable& root);

/// Tables behind everything else: reading them gives equal records.
std::string records_text(const CalibrationRecords& records);

}  // namespace vrda
