/// What somebody reads off or brings the dials to.
#pragma once

#include <optional>

#include "setup/calibration_record.hpp"
#include "simulation/draws.hpp"
#include "virtual_bench/operator.hpp"

namespace vrda {

/// The task at hand.
struct AskedFor {
  const Task& task;
  CalibrationPart part = CalibrationPart::viewport;
  const Calibration& found;  ///< so far: what the guide draws by
};

/// What a ruler, a tape or a pupillometer says; nothing of tasks that ask for no number.
std::optional<double> number_read(const AskedFor& asked, const BenchFile& bench, const VirtualTruth& truth,
                                  const VirtualNoise& noise, Draws& draws);

/// Where the dials stand when everything is seen aligned, in their order and units; nothing of tasks without
/// dials.
std::vector<double> dial_values(const AskedFor& asked, const BenchFile& bench, const VirtualTruth& truth,
                                const VirtualNoise& noise, Draws& draws);

}  // namespace vrda
