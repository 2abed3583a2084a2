/// The bench's keys (thesis 7.2): they select a parameter and change it.
#pragma once

#include <span>
#include <string>

#include "bench/bench_state.hpp"
#include "view/keys.hpp"

namespace vrda {

/// What a key asks of whoever runs the loop; it has changed the state already.
enum class BenchRequest {
  none,
  zero_stage,         ///< the stage is at its stop
  write_calibration,  ///< with every kept parameter as it is now
  screenshot,
  show_panel,  ///< on and off
  show_help,   ///< on and off
  quit
};

/// Changes `state` as the key says.
BenchRequest press_key(BenchState& state, const KeyPress& press);

/// Keys and what they do, for the help page and the command line.
std::span<const HelpLine> bench_key_lines();

/// "flexion 35.5 deg"; "left.k1 0.021".
std::string parameter_text(const BenchState& state, std::size_t parameter);

}  // namespace vrda
