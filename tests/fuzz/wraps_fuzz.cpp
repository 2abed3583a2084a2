// Wrapping surfaces in JSON.
#include "fuzz/outcome.hpp"
#include "job/ligament_files.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  using namespace vrda;
  test::read_or_refuse([&] {
    for (const model::Wrap& wrap :
         job::read_wraps("wraps.json", test::text_of(data, size), {"femur", "tibmen"})) {
      test::require(wrap.radii_mm.minCoeff() > 0.0, "a wrap without size");
    }
  });
  return 0;
}
