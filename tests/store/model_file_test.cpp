// Every damage of the list, damage anywhere in the bytes of a file, and changes that leave a file valid.
// Serialization of motion models and traces between processes.
#include <gmock/gmock.h>
#include <sys/stat.h>
#include <unistd.h>

#include <bit>
#include <cmath>
#include <filesystem>
#include <map>

#include "core/files.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "store/h5_file.hpp"
#include "store/motion_model.hpp"
#include "store/read_separately.hpp"
#include "store/registry.hpp"
#include "store/sample_model.hpp"
#include "store/solved_cells.hpp"
#include "support/damaged_models.hpp"
#include "support/refusal.hpp"
#include "support/scratch.hpp"
#include "support/traces.hpp"

namespace vrda::model_file_test {

using test::expect_equal;
using test::input_error;

// Every variant, with and without derived data, and as a start file, is valid, comes back to the last bit,
// and is written again with the same bytes.
TEST(MotionModelFile, RoundTrip)
{
  const test::Scratch scratch;
  const std::string path = scratch.path() / "knee.h5", again = scratch.path() / "again.h5";
  std::vector<store::MotionModel> models{test::whole_model(), test::frames_model(),
                                         test::model_of(test::Intact::stretched)};
  for (const test::SampleOptions& options :
       {test::SampleOptions{}, test::SampleOptions{4, 3, false, false, false},
        test::SampleOptions{3, 1, true, true, false}, test::SampleOptions{1, 1, false, true, false},
        test::SampleOptions{91, 21, true, true, true, true, 55, 3},
        test::SampleOptions{4, 3, false, false, true, true, 2, 0},
        test::SampleOptions{4, 3, true, false, true, false, 1, 1},
        test::SampleOptions{4, 1, true, false, false, true, 0, 0}}) {
    store::MotionModel model = test::sample_model(options);
    if (options.n_flexion == 1) model.smoothed.clear();  // the sample's set has a term of flexion
    models.push_back(test::with_derived(model));
    models.push_back(std::move(model));
  }
  for (std::size_t k = 0; k < 6; ++k) models.push_back(store::with_pending_cells(models[k]));
  for (std::size_t k = 0; k < models.size(); ++k) {
    SCOPED_TRACE(k);
    store::write_motion_model(path, models[k]);
    for (const store::Finding& finding : store::validate_hdf5(path))
      ADD_FAILURE() << finding.where << ": " << finding.found << ", wanted " << finding.wanted;
    const store::MotionModel read = store::read_motion_model(path);
    expect_equal(read, models[k]);
    store::write_motion_model(again, read);
    EXPECT_EQ(test::read_bytes(again), test::read_bytes(path));
  }
}

TEST(MotionModelFile, WithoutAPushItIsTheConstantOneAlongDelta)
{
  store::MotionModel model = test::sample_model();
  model.delta = {0.0, 0.6, 0.8};
  model.push = {};
  model = store::with_pending_cells(model);
  EXPECT_EQ(model.push.delta, (Eigen::RowVector3d(0.0, 0.6, 0.8).replicate(4, 1)));
  EXPECT_EQ(model.push.force_n, Points::Zero(4, 3));
  EXPECT_EQ(model.push.moment_nmm, std::vector<double>(4, 0.0));
}

TEST(MotionModelFile, EqualModelsGiveEqualBytes)
{
  const test::Scratch scratch;
  const std::string a = scratch.path() / "a.h5", b = scratch.path() / "folder" / "longer-name.h5";
  std::filesystem::create_directory(scratch.path() / "folder");
  store::MotionModel model = test::with_derived(test::sample_model({91, 21, true, true, true, true, 4, 2}));
  store::write_motion_model(a, model);
  sleep(1);  // so that a stored time would differ
  // NaNs are written with one bit pattern.
  model.tx_mm(1, 2) = std::bit_cast<double>(0xfff8000000000001u);
  model.audits[0].gap_mm(0, 0) = model.tx_mm(1, 2);
  store::write_motion_model(b, model);
  EXPECT_EQ(test::read_bytes(a), test::read_bytes(b));
}

// A model that breaks a promise of its struct is not written.
TEST(MotionModelFile, Misshapen)
{
  using Model = store::MotionModel;
  const test::Scratch scratch;
  const std::string path = scratch.path() / "knee.h5";
  const Model model = test::with_derived(test::sample_model());
  const std::function<void(Model&)> damages[] = {
      [](Model& m) { m.tx_mm.conservativeResize(2, 2); },
      [](Model& m) { m.smoothed[0].surfaces.pop_back(); },
      [](Model& m) { m.smoothed.push_back(m.smoothed[0]); },
      [](Model& m) { m.method = "equilibrium"; },
      [](Model& m) { m.contact_paths.reset(); },
      [](Model& m) { m.push.moment_nmm.pop_back(); },
      [](Model& m) { std::swap(m.audits[0], m.audits[1]); },
      [](Model& m) { m.audits = {store::AuditSet()}; },
      [](Model& m) { m.zero_varus->helical_rotation_deg.pop_back(); },
      [](Model& m) { m.smoothed[0].recontact_mm->conservativeResize(2, 2); },
      [](Model& m) { m.smoothed[0].surfaces.push_back(m.smoothed[0].surfaces[0]); }};
  for (const auto& damage : damages) {
    Model damaged = model;
    damage(damaged);
    EXPECT_THROW(store::write_motion_model(path, damaged), InternalError) << &damage - damages;
  }
  EXPECT_FALSE(std::filesystem::exists(path));
}

using test::change;
using test::expect_first;

// The finding names the object, the value and the rule. That reading is refused with the same is checked of
// every change of hostile_file_test.cpp, and here of the first of each model.
TEST(DamagedModels, EachIsNamed)
{
  const test::Scratch scratch;
  const std::string path = scratch.path() / "knee.h5";
  std::map<test::Intact, store::MotionModel> models;
  for (const test::Damage& damage : test::damages()) {
    SCOPED_TRACE(damage.name);
    const bool is_first = models.count(damage.intact) == 0;
    if (is_first) models[damage.intact] = test::model_of(damage.intact);
    store::MotionModel model = models[damage.intact];
    const auto* of_values = std::get_if<test::ValueDamage>(&damage.act);
    if (of_values != nullptr) (*of_values)(model);
    store::write_motion_model(path, model);
    if (of_values == nullptr) change(path, std::get<test::FileDamage>(damage.act));
    const std::vector<store::Finding> findings = store::validate_hdf5(path);
    EXPECT_TRUE(of_values == nullptr || findings.size() == 1);
    expect_first(findings, damage.where, damage.found, damage.wanted);
    if (!is_first) continue;
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
  for (std::size_t at = 0; at < whole.size(); at += 1999) {
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
  for (std::size_t size = 0; size < whole.size(); size += 4999) {
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

// Of read_motion_model(), which gets a model in this form from another process.
TEST(PlainBytes, CutAnywhereTheyAreRefused)
{
  const std::string bytes = store::serialize(test::whole_model());
  for (std::size_t size = 0; size < bytes.size(); size += 13) {
    try {
      store::deserialize_motion_model(std::string_view(bytes).substr(0, size), "knee.h5");
      ADD_FAILURE() << "no InputError of " << size << " bytes";
    } catch (const InputError& error) {
      EXPECT_EQ(error.facts().file, "knee.h5");
    }
  }
}

using test::whole_model;

struct Numbers {
  std::string unit;
  bool is_pose = false;
  std::vector<double> values;
};

/// All lengths, angles and other numbers of a model by name.
class AllNumbers : public store::RegistryVisitor {
 public:
  std::map<std::string, Numbers> numbers;

  void visit_attribute(const std::string& object, const std::string& name, Attribute value,
                       const core::Unit& units) override
  {
    Numbers& found = numbers[object + "@" + name];
    found.unit = units.name;
    if (const auto* number = std::get_if<double*>(&value)) found.values = {**number};
    if (const auto* vector = std::get_if<Eigen::Vector3d*>(&value))
      found.values.assign((*vector)->begin(), (*vector)->end());
  }
  void visit_dataset(const store::Dataset& dataset, Member member) override
  {
    if (store::kind_of(member) != store::ValueKind::float64) return;
    Numbers& found = numbers[dataset.path];
    found = {dataset.units.name, dataset.path.find("/X_") != std::string::npos, {}};
    store::with_values(member, [&]<typename Scalar>(std::span<Scalar> values) {
      if constexpr (std::is_same_v<Scalar, double>) found.values.assign(values.begin(), values.end());
    });
  }
};

std::map<std::string, Numbers> numbers_of(const store::MotionModel& model)
{
  AllNumbers all;
  store::visit_registry(model, all);
  return all.numbers;
}

/// Whether entry k of row-major poses is a translation.
bool is_shift(std::size_t k)
{
  return k % 4 == 3 && k % 16 != 15;
}

// Lengths, energies and moments are found by their units, so none is missed. Powers of two are exact.
TEST(ScaledModel, WhateverHasALengthIsTwiceAsLong)
{
  const store::MotionModel model = whole_model();
  const std::map<std::string, Numbers> small = numbers_of(model),
                                       large = numbers_of(store::scaled_model(model, 2.0));
  int n_lengths = 0, n_others = 0;
  for (const auto& [name, before] : small) {
    SCOPED_TRACE(name);
    // The landmarks are input to the scaling.
    const bool has_length = before.unit.find("mm") != std::string::npos && name.rfind("/job/scaling", 0) != 0;
    const double scale = before.unit == "N mm-1" ? 0.5 : 2.0;
    ++(has_length ? n_lengths : n_others);
    const std::vector<double>& after = large.at(name).values;
    for (std::size_t k = 0; k < before.values.size(); ++k) {
      const double factor = has_length && (!before.is_pose || is_shift(k)) ? scale : 1.0;
      const double wanted = factor * before.values[k];
      EXPECT_TRUE(after[k] == wanted || (std::isnan(wanted) && std::isnan(after[k])))
          << k << ": " << before.values[k] << " became " << after[k];
    }
  }
  EXPECT_GT(n_lengths, 60);
  EXPECT_GT(n_others, 40);
  for (const char* name : {"/@rotation_centre_mm", "/@contact_resolution_mm", "/push@point_mm",
                           "/equilibrium@band_moment_nmm", "/smoothed/degree_1/tx@rms"})
    EXPECT_EQ(small.at(name).unit.substr(small.at(name).unit.size() - 2), "mm") << name;
}

TEST(ScaledModel, BackAgainIsTheSame)
{
  const store::MotionModel model = whole_model();
  test::expect_equal(store::scaled_model(store::scaled_model(model, 0.5), 2.0), model);
  test::expect_equal(store::scaled_model(model, 1.0), model);
}

using testing::ElementsAre;

template <typename Value>
std::vector<Value> read_back(const store::H5Reader& reader, const std::string& path, std::size_t n)
{
  std::vector<Value> values(n);
  reader.read(path, std::span<Value>(values));
  return values;
}

TEST(IndexTable, CsvHasWordsEmptyFieldsAndQuotes)
{
  EXPECT_EQ(store::index_csv(test::sample_index()),
            "case,status,remark,gap_mm\n"
            "a_rest,done,,0.125\n"
            "a_search,failed,\"a \"\"quoted\"\", longer\nremark\",\n"
            "b_rest,missing,,-1e-05\n");
}

}  // namespace vrda::model_file_test
