// Tables of ligament fibres.
#include "fuzz/outcome.hpp"
#include "job/ligament_files.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  using namespace vrda;
  test::read_or_refuse([&] {
    for (const job::FibreJob& fibre : job::read_ligament_table("fibres.csv", test::text_of(data, size))) {
      test::require(fibre.stiffness_n > 0.0, "a fibre without stiffness");
      test::require(!job::default_bundle(fibre.name).empty(), "a fibre without a bundle");
    }
  });
  return 0;
}
