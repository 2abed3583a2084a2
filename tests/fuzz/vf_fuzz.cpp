// The thesis's Vertices-Faces format.
#include "fuzz/mesh_outcome.hpp"
#include "job/mesh_file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  using namespace vrda;
  const std::string bytes = test::text_of(data, size);
  const bool is_taken_for_one = job::is_vertices_faces(bytes);
  test::read_or_refuse([&] { job::read_vertices_faces("mesh.vf", bytes); });
  if (is_taken_for_one) test::read_and_clean("mesh.obj", bytes);
  return 0;
}
