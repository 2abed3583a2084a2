// What `vrda-player` refuses: the rows of refusals.json, on the models made here. No row has a screen.
#include <cstdlib>

#include "store/motion_model.hpp"
#include "store/read_separately.hpp"
#include "store/trace.hpp"
#include "support/damaged_models.hpp"
#include "support/models.hpp"
#include "support/refusal_table.hpp"
#include "support/traces.hpp"
#include "view/image.hpp"

namespace vrda::player_refusals_test {

using test::Scratch;

void knee(const Scratch& scratch)
{
  store::write_motion_model((scratch.path() / "knee.h5").string(), test::small_model());
  store::write_trace((scratch.path() / "knee.trace.h5").string(), test::trace_beside(test::small_model()));
  const auto picture = [&](const char* name, int width) {
    view::write_png({width, 1, std::vector<std::uint8_t>(4 * static_cast<std::size_t>(width))},
                    (scratch.path() / name).string());
  };
  picture("bone.png", 8);
  picture("large.png", 4097);  // beyond the limit of textures
}

/// Four frames of a sequence.
void walk(const Scratch& scratch)
{
  store::write_motion_model((scratch.path() / "walk.h5").string(), test::small_sequence());
}

/// A model with a valid seal that crashes HDF5 1.10.8: an object of its global heap has a huge length.
std::string deadly_for_hdf5(std::string bytes)
{
  bytes.resize(bytes.size() - store::seal_of("").size());
  bytes.replace(bytes.find("GCOL") + 24, 8, std::string(7, '\xff') + '\x7f');
  return bytes + store::seal_of(bytes);
}

void damaged(const Scratch& scratch)
{
  knee(scratch);
  const std::filesystem::path whole = scratch.path() / "knee.h5";
  const auto copy = [&](const char* damage, const char* name) {
    std::filesystem::rename(test::damaged_copy(whole, scratch.path(), damage), scratch.path() / name);
  };
  copy("gigabytes_of_vertices", "huge.h5");
  copy("contacts_beyond_an_index", "endless.h5");
  scratch.write("deadly.h5", deadly_for_hdf5(test::read_bytes(whole)));
}

/// A run that has begun, and a start file with solved attitudes.
void run(const Scratch& scratch)
{
  const auto path = [&](const char* name) { return (scratch.path() / name).string(); };
  store::write_motion_model(path("knee.h5.start.h5"), store::with_pending_cells(test::small_model()));
  store::write_motion_model(path("solved.h5.start.h5"), test::small_model());
}

class Refused : public testing::TestWithParam<test::RefusalRow> {};

TEST_P(Refused, Row)
{
  unsetenv("DISPLAY");
  unsetenv("WAYLAND_DISPLAY");
  test::expect_row_refused(GetParam(), VRDA_PLAYER_PROGRAM,
                           {{"knee", knee}, {"walk", walk}, {"damaged", damaged}, {"run", run}});
}

INSTANTIATE_TEST_SUITE_P(Player, Refused, testing::ValuesIn(test::read_refusals(VRDA_PLAYER_REFUSALS)),
                         test::name_of_row);

}  // namespace vrda::player_refusals_test
