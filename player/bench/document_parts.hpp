/// Parts of bench and calibration files with a source of their own. The documents are schema-checked; all
/// readers throw InputError with file and key.
#pragma once

#include <map>

#include "bench/bench_file.hpp"
#include "bench/calibration_record.hpp"
#include "core/document.hpp"

namespace vrda::bench {

/// Length of the device name field of an OpenIGTLink message, bytes.
inline constexpr std::size_t longest_tool_name = 20;
/// One name of a tracker tool, or a list of names.
std::string tool_name(const core::Document& document, const std::string& key);
std::vector<std::string> tool_names(const core::Document& document, const std::string& key);

/// The table [calibration].
CalibrationSettings calibration_settings_of(const core::Document& document);

/// Script of the simulated devices: bodies and markers of `bench`, paths and noise of the schema-checked
/// file. Throws InputError with file and key.
bench::SimulationScript simulation_of(const core::Document& document, const BenchFile& bench);

/// Numeric listening address of the simulated tracker; loopback unless the file sets another.
std::string simulation_address_of(const core::Document& document);

using CalibrationRecords = std::map<CalibrationPart, CalibrationRecord>;

/// Reads the records of a schema-checked file; may be empty. Throws InputError with file and key.
CalibrationRecords read_calibration_records(const core::Document& document);

/// TOML tables for the end of the file; reading them gives equal records.
std::string records_text(const CalibrationRecords& records);

}  // namespace vrda::bench
