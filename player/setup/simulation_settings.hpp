/// The [simulation] table of a bench file.
#pragma once

#include "documents/document.hpp"
#include "setup/bench_file.hpp"

namespace vrda {

/// What is simulated of `bench`: its bodies and markers, moved as the checked file says.
/// Throws InputError naming file and key.
SimulationScript simulation_of(const Document& document, const BenchFile& bench);

/// Where the simulated tracker listens: beyond this machine only if the table says so.
std::string simulation_address_of(const Document& document);

}  // namespace vrda
