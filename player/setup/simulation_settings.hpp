/// The [simulation] table of a bench file.
#pragma once

#include "documents/document.hpp"
#include "setup/bench_file.hpp"

namespace vrda {

/// Script of the simulated devices: bodies and markers of `bench`, paths and noise of the schema-checked
/// file. Throws InputError with file and key.
SimulationScript simulation_of(const Document& document, const BenchFile& bench);

/// Numeric listening address of the simulated tracker; loopback unless the file sets another.
std::string simulation_address_of(const Document& document);

}  // namespace vrda
