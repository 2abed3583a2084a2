/// Keys of the bench (thesis 7.2), which select and change parameters of the displayed joint and of the
/// calibration. In: a key press. Out: the changed BenchState and a request to the loop. Texts show degrees
/// and mm.
#pragma once

#include <span>
#include <string>

#include "bench/bench_state.hpp"
#include "view/keys.hpp"

namespace vrda::bench {

/// Request of a key to the loop.
enum class BenchRequest {
  none,
  zero_stage,         ///< the stage is at its stop
  write_calibration,  ///< with the current values of all saved parameters
  screenshot,
  show_panel,  ///< toggle
  show_help,   ///< toggle
  quit
};

/// Applies a key to `state` and returns the remaining request.
BenchRequest apply_key(BenchState& state, const view::KeyPress& press);

/// Help lines of the keys, for the help page and the command line.
std::span<const view::HelpLine> bench_key_lines();

/// "flexion 35.5 deg"; "left.k1 0.021".
std::string parameter_text(const BenchState& state, std::size_t parameter);

}  // namespace vrda::bench
