// Serialized motion models and traces, without HDF5: shapes, value rules, and the player's use of valid ones.
#include "fuzz/changed_content.hpp"
#include "fuzz/outcome.hpp"
#include "fuzz/small_models.hpp"
#include "store/read_separately.hpp"
#include "store/trace.hpp"

namespace {

using namespace vrda;

const std::vector<test::BaseContent>& bases()
{
  static const std::vector<test::BaseContent> made = [] {
    std::vector<test::BaseContent> all;
    for (const store::MotionModel& model : test::small_models())
      all.push_back({store::serialize(model), {}, {}});
    all.push_back({store::serialize(test::small_trace()), {}, {}});
    return all;
  }();
  return made;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  const std::string bytes = test::changed(bases(), data, size);
  test::read_or_refuse([&] { test::use_as_player(store::deserialize_motion_model(bytes, "a.h5")); });
  test::read_or_refuse([&] { store::film_of(store::trace_of(bytes, "a.trace.h5"), "a.trace.h5", {}); });
  return 0;
}
