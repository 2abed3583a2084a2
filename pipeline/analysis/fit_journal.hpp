/// The append-only journal of an identification, from which an interrupted one continues: a frame of
/// journal/framed_file.hpp per evaluation.
#pragma once

#include <string>
#include <vector>

#include "analysis/identification.hpp"
#include "core/framed_file.hpp"

namespace vrda::analysis {

/// SHA-256 of what determines the evaluations: job, inputs, solver, unknowns, measurements.
std::string identification_key(const FitData& data, const IdentifyPlan& plan,
                               const std::vector<std::string>& hashes_of_data);

/// Continues the journal at `path`, adding its evaluations, or starts one; with `is_fresh` always starts one.
/// Throws InputError if it has another key or is being written.
core::FrameWriter open_evaluations(const std::string& path, const std::string& key, bool is_fresh,
                                      std::vector<Evaluation>& known);

std::string evaluation_bytes(const Evaluation& evaluation);

}  // namespace vrda::analysis
