// The three files of an Object set, one after the other, "%%" between them.
#include "fuzz/outcome.hpp"
#include "job/thesis_files.hpp"

namespace {

// Removes and returns the text before the next mark of `rest`.
std::string next_part(std::string& rest)
{
  const std::size_t mark = rest.find("%%");
  std::string part = rest.substr(0, mark);
  rest = mark == std::string::npos ? "" : rest.substr(mark + 2);
  return part;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  using namespace vrda;
  test::read_or_refuse([&] {
    std::string rest = test::text_of(data, size);
    const std::string coordinates = next_part(rest), normals = next_part(rest);
    const std::vector<job::ObjectComponent> components =
        job::parse_object_set({{"a.coor", coordinates}, {"a.norm", normals}, {"a.elem", rest}});
    for (const job::ObjectComponent& component : components) {
      // The written file equals the content read, and load accepts it.
      test::require_no_throw([&] {
        const job::RawMesh again = job::read_mesh("a.vf", job::vertices_faces_bytes(component.mesh));
        test::require(again.vertices == component.mesh.vertices && again.corner == component.mesh.corner &&
                          again.size == component.mesh.size,
                      "a component that is written otherwise");
      });
      test::require(component.mesh.normals.rows() == component.mesh.vertices.rows(),
                    "not one normal a vertex");
    }
  });
  return 0;
}
