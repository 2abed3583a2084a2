// Every damage of the list, damage anywhere in the bytes of a file, and changes that leave a file valid.
#include "support/damaged_models.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <map>

#include "core/text.hpp"
#include "core/units.hpp"
#include "store/read_separately.hpp"
#include "store/sample_model.hpp"
#include "support/refusal.hpp"
#include "support/scratch.hpp"

namespace vrda::damaged_models_test {

using test::change;
using test::expect_first;

// The finding names the object, the value and the rule; reading is refused with the same.
TEST(DamagedModels, EachIsNamed)
{
  const test::Scratch scratch;
  const std::string path = scratch.path() / "knee.h5";
  std::map<test::Intact, store::MotionModel> models;
  for (const test::Damage& damage : test::damages()) {
    SCOPED_TRACE(damage.name);
    if (models.count(damage.intact) == 0) models[damage.intact] = test::model_of(damage.intact);
    store::MotionModel model = models[damage.intact];
    const auto* of_values = std::get_if<test::ValueDamage>(&damage.act);
    if (of_values != nullptr) (*of_values)(model);
    store::write_motion_model(path, model);
    if (of_values == nullptr) change(path, std::get<test::FileDamage>(damage.act));
    const std::vector<store::Finding> findings = store::validate_hdf5(path);
    EXPECT_TRUE(of_values == nullptr || findings.size() == 1);
    expect_first(findings, damage.where, damage.found, damage.wanted);
    EXPECT_THAT(test::input_error([&] { store::read_motion_model(path); }),
                test::refuses({path, damage.where}));
  }
}

TEST(DamagedModels, AllFindingsAreListed)
{
  const test::Scratch scratch;
  const std::string path = scratch.path() / "knee.h5";
  store::MotionModel model = test::sample_model();
  model.side = "both";
  model.tx_mm(0, 0) = nan;
  model.contacts.compartment[0] = -7;
  store::write_motion_model(path, model);
  std::vector<std::string> places;
  for (const store::Finding& finding : store::validate_hdf5(path)) places.push_back(finding.where);
  EXPECT_EQ(places, (std::vector<std::string>{"/@side", "/tx", "/contacts/compartment"}));
}

// With one varus in the axis, each flexion has its own.
TEST(IntactModels, FreeVarus)
{
  store::MotionModel model = test::with_derived(test::sample_model({4, 1, true, true, false}));
  model.varus_solved_deg(2, 0) = 3.25;
  const test::Scratch scratch;
  const std::string path = scratch.path() / "knee.h5";
  store::write_motion_model(path, model);
  EXPECT_TRUE(store::validate_hdf5(path).empty());
  model.smoothed[0].surfaces[4].values(2, 0) += 1e-6;
  store::write_motion_model(path, model);
  expect_first(store::validate_hdf5(path), "/smoothed/degree_1/varus_solved", "at entry 2",
               "the value of the polynomial");
}

// One attitude, and a scaling of three factors without landmarks.
TEST(IntactModels, Smallest)
{
  const test::Scratch scratch;
  const std::string path = scratch.path() / "knee.h5";
  test::SampleOptions one;
  one.n_flexion = one.n_varus = 1;
  one.has_failed_cell = false;
  store::MotionModel model = test::sample_model(one);
  model.smoothed.clear();
  for (const store::MotionModel& written : {model, test::model_of(test::Intact::stretched)}) {
    store::write_motion_model(path, written);
    EXPECT_TRUE(store::validate_hdf5(path).empty());
    test::expect_equal(store::read_motion_model(path), written);
  }
}

// Another program's change keeps a file valid; later versions have objects that this one ignores.
TEST(IntactModels, ChangedByAnotherProgram)
{
  const test::Scratch scratch;
  const std::string path = scratch.path() / "knee.h5";
  const store::MotionModel model = test::whole_model();
  store::write_motion_model(path, model);
  change(path, [](hid_t file) {
    test::set_text(file, "/", "title", "renamed");
    test::set_text(file, "/", "format_version", "1.999");
    test::make_group(file, "/later");
    test::make_group(file, "/audit/living");
  });
  EXPECT_TRUE(store::validate_hdf5(path).empty());
  EXPECT_EQ(store::read_motion_model(path).title, "renamed");
  EXPECT_EQ(store::read_motion_model(path).audits.size(), model.audits.size());
}

TEST(IntactModels, WithoutDerivedData)
{
  const test::Scratch scratch;
  const std::string path = scratch.path() / "knee.h5";
  store::write_motion_model(path, test::whole_model());
  change(path, [](hid_t file) {
    for (const char* object : {"/zero_varus", "/audit/raw", "/job/scaling", "/ligaments"})
      test::remove(file, object);
  });
  EXPECT_TRUE(store::validate_hdf5(path).empty());
  const store::MotionModel read = store::read_motion_model(path);
  EXPECT_FALSE(read.zero_varus || read.job.scaling || read.ligaments);
  EXPECT_EQ(read.audits.size(), 3u);
}

/// A bit flip, an overwritten block or a truncation anywhere must give an InputError that names the file.
void expect_refused(const test::Scratch& scratch, const std::string& bytes)
{
  const std::string file = scratch.write("damaged.h5", bytes);
  try {
    store::validate_hdf5(file);
    ADD_FAILURE() << "no InputError";
  } catch (const InputError& error) {
    EXPECT_EQ(error.facts().file, file);
    EXPECT_TRUE(test::names_value(error.facts().wanted, "motion model")) << error.facts().wanted;
  }
}

TEST(DamagedFile, Anywhere)
{
  const test::Scratch scratch;
  const std::string path = scratch.path() / "knee.h5";
  store::write_motion_model(path, test::sample_model());
  const std::string whole = test::read_bytes(path);
  // A prime step, so that the flips hit every position within aligned structures.
  for (std::size_t at = 0; at < whole.size(); at += 199) {
    SCOPED_TRACE(at);
    std::string flipped = whole;
    flipped[at] = static_cast<char>(flipped[at] ^ (1 << at % 8));
    expect_refused(scratch, flipped);
  }
  for (std::size_t at = 0; at < whole.size(); at += 4096) {
    SCOPED_TRACE(at);
    std::string zeroed = whole;
    const std::size_t size = std::min<std::size_t>(4096, whole.size() - at);
    zeroed.replace(at, size, std::string(size, '\0'));
    expect_refused(scratch, zeroed);
  }
  for (std::size_t size = 0; size < whole.size(); size += 499) {
    SCOPED_TRACE(size);
    expect_refused(scratch, whole.substr(0, size));
  }
  for (std::size_t cut = 1; cut < 16; ++cut) expect_refused(scratch, whole.substr(0, whole.size() - cut));
  expect_refused(scratch, whole + "x");
}

TEST(DamagedFile, WithoutSeal)
{
  const test::Scratch scratch;
  const std::string path = scratch.path() / "knee.h5";
  store::write_motion_model(path, test::sample_model());
  std::filesystem::resize_file(path, std::filesystem::file_size(path) - 16);
  EXPECT_THAT(test::input_error([&] { store::validate_hdf5(path); }),
              test::refuses({.wanted = "--unsealed"}));
  store::accept_unsealed_files();
  EXPECT_TRUE(store::validate_hdf5(path).empty());
  store::accept_unsealed_files(false);
}

TEST(DamagedFile, CorruptChunk)
{
  const test::Scratch scratch;
  const std::string path = scratch.path() / "knee.h5";
  store::write_motion_model(path, test::sample_model({91, 21, true, true, true}));
  std::string bytes = test::read_bytes(path);
  bytes.resize(bytes.size() - 16);
  const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  const hid_t dataset = H5Dopen2(file, "/X_reference_moving", H5P_DEFAULT);
  hsize_t offset[4] = {}, size = 0;
  unsigned mask = 0;
  haddr_t address = 0;
  const hid_t space = H5Dget_space(dataset);
  ASSERT_GE(H5Dget_chunk_info(dataset, space, 0, offset, &mask, &address, &size), 0);
  H5Sclose(space);
  H5Dclose(dataset);
  H5Fclose(file);
  bytes[address + size / 2] = static_cast<char>(bytes[address + size / 2] ^ 1);
  const std::string damaged = scratch.write("damaged.h5", bytes + store::seal_of(bytes));
  const std::vector<store::Finding> findings = store::validate_hdf5(damaged);
  expect_first(findings, "/X_reference_moving", "HDF5 error", "intact");
}

}  // namespace vrda::damaged_models_test
