// Tables of measured poses. The first byte selects the kind of file.
#include "fuzz/outcome.hpp"
#include "tables/imported_model.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  using namespace vrda;
  if (size == 0) return 0;
  const char* const names[] = {"m.csv", "m.sto", "m.tra"};
  const std::string name = names[data[0] % 3];
  test::read_or_refuse([&] {
    const tables::MotionTable table =
        tables::motion_table_from_text(name, test::text_of(data + 1, size - 1), {});
    test::require(!table.key.empty(), "a table without frames");
    const tables::Convention convention = tables::completed({}, table.stated, Side::left);
    for (const Pose& X : tables::poses_of(table, convention, {}))
      test::require(X.matrix().allFinite(), "a pose that is no number");
  });
  return 0;
}
