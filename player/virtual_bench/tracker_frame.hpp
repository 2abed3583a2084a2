/// What a tracker and an encoder would send of one moment.
#pragma once

#include "devices/sample.hpp"
#include "simulation/draws.hpp"
#include "virtual_bench/operator.hpp"
#include "virtual_bench/standing.hpp"

namespace vrda {

/// A pose as the tracker says, with its noise.
Pose measured(const Pose& X, const VirtualNoise& noise, Draws& draws);

struct FrameFacts {
  std::int64_t time_ns = 0;
  std::string tool;  ///< that Standing::X_tracker_tool is of
  /// Of the encoder, before it was zeroed at the stop.
  double stage_offset_mm = 0.0;
  bool is_stage_zeroed = false;
  VirtualNoise noise;
};

/// The stage's count, then every tool of the tracker in its order; tools that nobody uses are not seen.
std::vector<Sample> tracker_frame(const BenchFile& bench, const VirtualTruth& truth, const Standing& standing,
                                  const FrameFacts& facts, Draws& draws);

}  // namespace vrda
