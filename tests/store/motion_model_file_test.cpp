#include "store/motion_model.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <bit>
#include <filesystem>
#include <limits>

#include "core/text.hpp"
#include "store/sample_model.hpp"
#include "support/refusal.hpp"
#include "support/scratch.hpp"

namespace vrda::motion_model_file_test {

using test::expect_equal;
using test::input_error;

// Every variant, with and without derived data, and as a start file, is valid, comes back to the last bit,
// and is written again with the same bytes.
TEST(MotionModelFile, RoundTrip)
{
  const test::Scratch scratch;
  const std::string path = scratch.path() / "knee.h5", again = scratch.path() / "again.h5";
  std::vector<store::MotionModel> models{test::whole_model(), test::frames_model()};
  for (const test::SampleOptions& options :
       {test::SampleOptions{}, test::SampleOptions{91, 21, true, true, true},
        test::SampleOptions{4, 3, false, false, false}, test::SampleOptions{3, 1, true, true, false},
        test::SampleOptions{1, 1, false, true, false},
        test::SampleOptions{91, 21, true, true, true, true, 55, 3},
        test::SampleOptions{4, 3, false, false, true, true, 2, 0},
        test::SampleOptions{4, 3, true, false, true, false, 1, 1},
        test::SampleOptions{4, 1, true, false, false, true, 0, 0}}) {
    store::MotionModel model = test::sample_model(options);
    if (options.n_flexion == 1) model.smoothed.clear();  // the sample's set has a term of flexion
    models.push_back(test::with_derived(model));
    models.push_back(std::move(model));
  }
  for (std::size_t k = models.size(); k-- > 0;) models.push_back(store::with_pending_cells(models[k]));
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

// A start file has no cell solved; it keeps keys, push, fibres and the moment of the band.
TEST(MotionModelFile, PendingCells)
{
  for (const std::int32_t n_wraps : {0, 2}) {
    const store::MotionModel model = test::sample_model({4, 3, true, true, true, true, 5, n_wraps});
    const store::MotionModel start = store::with_pending_cells(model);
    EXPECT_TRUE((start.status == status_pending).all());
    EXPECT_EQ(start.contacts.row_start, std::vector<std::int64_t>(13, 0));
    EXPECT_EQ(start.push.delta, model.push.delta);
    EXPECT_EQ(start.ligaments->slack_length_mm, model.ligaments->slack_length_mm);
    EXPECT_EQ(start.equilibrium->band_moment_nmm, 500.0);
    EXPECT_EQ(start.equilibrium->forces.row_start, std::vector<std::int64_t>(13, 0));
    EXPECT_EQ(start.ligaments->is_wrapped, std::vector<std::int8_t>(60, -1));
  }
  const store::MotionModel walk = test::frames_model();
  EXPECT_EQ(store::with_pending_cells(walk).frames->key, walk.frames->key);
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

TEST(MotionModelFile, ReplacesAFileAndLeavesNothingElse)
{
  const test::Scratch scratch;
  const std::string path = (scratch.path() / "knee.h5").string();
  for (int n = 0; n < 2; ++n) store::write_motion_model(path, test::sample_model());
  EXPECT_TRUE(store::validate_hdf5(path).empty());
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(scratch.path()), {}), 1);
}

TEST(MotionModelFile, AnUnwritableOutputIsNamedAndTheOldFileKept)
{
  const test::Scratch scratch;
  const std::string nowhere = scratch.path() / "no" / "such" / "knee.h5";
  const InputError::Facts facts =
      input_error([&] { store::write_motion_model(nowhere, test::sample_model()); });
  EXPECT_EQ(facts.file, nowhere);
  EXPECT_NE(facts.found.find("No such file or directory"), std::string::npos);
  EXPECT_NE(facts.wanted.find("written"), std::string::npos);

  const std::string folder = scratch.path() / "knee.h5";
  std::filesystem::create_directory(folder);
  scratch.write("knee.h5/inside", "kept");
  EXPECT_EQ(input_error([&] { store::write_motion_model(folder, test::sample_model()); }).file, folder);
  EXPECT_TRUE(std::filesystem::exists(scratch.path() / "knee.h5" / "inside"));
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(scratch.path()), {}), 1);
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

TEST(MotionModelFile, WhatIsNoMotionModelIsRefused)
{
  const test::Scratch scratch;
  const std::string missing = scratch.path() / "missing.h5";
  EXPECT_EQ(input_error([&] { store::read_motion_model(missing); }).file, missing);
  EXPECT_THAT(input_error([&] { store::read_motion_model(missing); }),
              test::refuses({.found = "No such file"}));
  EXPECT_THAT(input_error([&] { store::read_motion_model(scratch.path()); }),
              test::refuses({.found = "not a regular file"}));
  for (const std::string& bytes :
       {std::string(), std::string("title = \"a job\"\n"), std::string(4096, '\0')}) {
    const std::string file = scratch.write("job.toml", bytes);
    EXPECT_THAT(input_error([&] { store::read_motion_model(file); }), test::refuses({file, "", "HDF5"}));
    EXPECT_THROW(store::validate_hdf5(file), InputError);
  }
}

}  // namespace vrda::motion_model_file_test
