#include "assemble/scaled_result.hpp"

namespace vrda {

SweepResult scaled(const SweepResult& result, double factor)
{
  SweepResult out = result;
  for (StepRecord& r : out.cells) r = scaled(r, factor);
  for (FreeSpineStep& step : out.free_spine) {
    step.chosen = scaled(step.chosen, factor);
    step.band_low = scaled(step.band_low, factor);
    step.band_high = scaled(step.band_high, factor);
    step.energy_spread_nmm *= factor;
  }
  return out;
}

}  // namespace vrda
