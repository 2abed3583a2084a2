// PLY, ASCII and binary of both byte orders.
#include "fuzz/mesh_outcome.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  vrda::test::read_and_clean("mesh.ply", vrda::test::text_of(data, size));
  return 0;
}
