// Binary and ASCII STL.
#include "fuzz/mesh_outcome.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  vrda::test::read_and_clean("mesh.stl", vrda::test::text_of(data, size));
  return 0;
}
