/// The [simulation] table of a bench file.
#pragma once

#include "settings/settings_table.hpp"
#include "setup/bench_file.hpp"

namespace vrda {

/// What is simulated of `bench`: its bodies and markers, moved as the table of `root` says, or by default.
/// Throws InputError naming file and key.
SimulationScript simulation_of(const SettingsTable& root, const BenchFile& bench);

/// Where the simulated tracker listens: beyond this machine only if the table says so.
std::string simulation_address_of(const SettingsTable& root);

}  // namespace vrda
