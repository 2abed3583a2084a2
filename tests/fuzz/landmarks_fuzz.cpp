// Tables of landmarks, and the factor fitted to them.
#include <cmath>

#include "fuzz/outcome.hpp"
#include "job/ligament_files.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  using namespace vrda;
  test::read_or_refuse([&] {
    const std::vector<job::LandmarkPair> pairs = job::read_landmarks("marks.csv", test::text_of(data, size));
    test::require(!pairs.empty(), "no pair");
    const Scaling scaling = job::fit_scaling(pairs, 1000.0);
    test::require(std::isfinite(scaling.factor.x()) && scaling.factor.x() > 0.0, "an invalid factor");
    test::require(std::isfinite(scaling.residual_rms_mm), "an invalid residual");
  });
  return 0;
}
