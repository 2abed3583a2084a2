/// The parts that are done once a bench, for the next person.
#pragma once

#include "setup/calibration.hpp"

namespace vrda {

/// A nominal calibration with what `other` knows of the bench: its once-per-bench records, what they found of
/// the eyes' screens, table and stage; nothing of its person. Throws InputError naming `other_path` and the
/// part when one of them is not done.
Calibration begun_from(const Calibration& other, const BenchFile& bench, const std::string& other_path);

/// Throws InputError naming `path` unless `begun` has just the once-per-bench records of `other`.
void require_same_bench_parts(const Calibration& begun, const std::string& path, const Calibration& other,
                              const std::string& other_path);

}  // namespace vrda
