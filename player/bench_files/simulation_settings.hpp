/// The [simulation] table of a bench file.
#pragma once

#include "bench_files/bench_file.hpp"
#include "documents/document.hpp"

namespace vrda::bench_files {

/// Script of the simulated devices: bodies and markers of `bench`, paths and noise of the schema-checked
/// file. Throws InputError with file and key.
simulation::SimulationScript simulation_of(const documents::Document& document, const BenchFile& bench);

/// Numeric listening address of the simulated tracker; loopback unless the file sets another.
std::string simulation_address_of(const documents::Document& document);

}  // namespace vrda::bench_files
