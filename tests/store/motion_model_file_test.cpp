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

TEST(MotionModelFile, GivesBackWhatWasWritten)
{
  const test::Scratch scratch;
  const std::string path = scratch.path() / "knee.h5";
  const test::SampleOptions variants[] = {{},
                                          {91, 21, true, true, true},
                                          {4, 3, false, false, false},
                                          {3, 1, true, true, false},
                                          {1, 1, false, true, false},
                                          {91, 21, true, true, true, true, 55, 3},
                                          {4, 3, false, false, true, true, 2, 0},
                                          {4, 3, true, false, true, false, 1, 1},
                                          {4, 1, true, false, false, true, 0, 0}};
  for (const test::SampleOptions& options : variants) {
    SCOPED_TRACE(options.n_flexion * 10000 + options.n_varus * 100 + options.n_fibres);
    store::MotionModel model = test::sample_model(options);
    if (options.n_flexion == 1) model.smoothed.clear();  // the sample's set has a term of flexion
    for (const store::MotionModel& wanted : {model, test::with_derived(model)}) {
      store::write_motion_model(path, wanted);
      for (const store::Finding& finding : store::validate_hdf5(path)) {
        ADD_FAILURE() << finding.where << ": " << finding.found << ", wanted " << finding.wanted;
      }
      expect_equal(store::read_motion_model(path), wanted);
    }
  }
}

TEST(MotionModelFile, ASequenceOfFramesComesBackWithItsKeys)
{
  const test::Scratch scratch;
  const std::string path = scratch.path() / "walk.h5";
  const store::MotionModel wanted = test::frames_model();
  EXPECT_EQ(wanted.flexion_deg, (std::vector<double>{0, 1, 2, 1, 0, 1}));
  store::write_motion_model(path, wanted);
  EXPECT_TRUE(store::validate_hdf5(path).empty());
  const store::MotionModel read = store::read_motion_model(path);
  expect_equal(read, wanted);
  EXPECT_EQ(read.frames->key_name, "time_s");
  EXPECT_EQ(read.frames->key, (std::vector<double>{-0.25, 0.25, 0.75, 1.25, 1.75, 2.25}));
  EXPECT_EQ(read.audits[0].frame_key, wanted.audits[0].frame_key);
  const store::MotionModel start = store::with_pending_cells(wanted);
  store::write_motion_model(path, start);
  expect_equal(store::read_motion_model(path), start);
  EXPECT_EQ(start.frames->key, wanted.frames->key);
}

TEST(MotionModelFile, StartFileIsAValidModelWithEveryCellPending)
{
  const test::Scratch scratch;
  const std::string path = scratch.path() / "knee.start.h5";
  const store::MotionModel start = store::with_pending_cells(test::with_derived(test::sample_model()));
  store::write_motion_model(path, start);
  EXPECT_TRUE(store::validate_hdf5(path).empty());
  const store::MotionModel read = store::read_motion_model(path);
  expect_equal(read, start);
  EXPECT_TRUE((read.status == status_pending).all());
  EXPECT_EQ(read.contacts.row_start, std::vector<std::int64_t>(13, 0));
}

TEST(MotionModelFile, AStartFileKeepsThePushAndTheFibres)
{
  const test::Scratch scratch;
  const std::string path = scratch.path() / "knee.start.h5";
  for (const std::int32_t n_wraps : {0, 2}) {
    const store::MotionModel model = test::sample_model({4, 3, true, true, true, true, 5, n_wraps});
    const store::MotionModel start = store::with_pending_cells(model);
    store::write_motion_model(path, start);
    EXPECT_TRUE(store::validate_hdf5(path).empty());
    const store::MotionModel read = store::read_motion_model(path);
    expect_equal(read, start);
    EXPECT_EQ(read.push.delta, model.push.delta);
    EXPECT_EQ(read.ligaments->slack_length_mm, model.ligaments->slack_length_mm);
    EXPECT_EQ(read.equilibrium->band_moment_nmm, 500.0);
    EXPECT_EQ(read.equilibrium->forces.row_start, std::vector<std::int64_t>(13, 0));
    EXPECT_EQ(read.ligaments->is_wrapped, std::vector<std::int8_t>(60, -1));
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

TEST(MotionModelFile, WritingReadBackBytesGivesTheSameFile)
{
  const test::Scratch scratch;
  const std::string a = scratch.path() / "a.h5", b = scratch.path() / "b.h5";
  for (const std::int32_t n_varus : {3, 1}) {
    const store::MotionModel model = test::sample_model({4, n_varus, true, true, n_varus == 3, true, 4, 2});
    store::write_motion_model(a, test::with_derived(model));
    store::write_motion_model(b, store::read_motion_model(a));
    EXPECT_EQ(test::read_bytes(a), test::read_bytes(b));
  }
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

TEST(MotionModelFile, InconsistentShapesOfAModelThrowInternalError)
{
  const test::Scratch scratch;
  const std::string path = scratch.path() / "knee.h5";
  store::MotionModel model = test::sample_model();
  model.tx_mm.conservativeResize(2, 2);
  EXPECT_THROW(store::write_motion_model(path, model), InternalError);
  model = test::sample_model();
  model.smoothed[0].surfaces.pop_back();
  EXPECT_THROW(store::write_motion_model(path, model), InternalError);
  model = test::sample_model();
  model.smoothed.push_back(model.smoothed[0]);
  EXPECT_THROW(store::write_motion_model(path, model), InternalError);
  model = test::sample_model();
  model.method = "equilibrium";
  EXPECT_THROW(store::write_motion_model(path, model), InternalError);
  model = test::sample_model();
  model.contact_paths.reset();
  EXPECT_THROW(store::write_motion_model(path, model), InternalError);
  model = test::sample_model();
  model.push.moment_nmm.pop_back();
  EXPECT_THROW(store::write_motion_model(path, model), InternalError);
  model = test::with_derived(test::sample_model());
  std::swap(model.audits[0], model.audits[1]);
  EXPECT_THROW(store::write_motion_model(path, model), InternalError);
  model.audits = {store::AuditSet()};
  EXPECT_THROW(store::write_motion_model(path, model), InternalError);
  model.audits.clear();
  model.zero_varus->helical_rotation_deg.pop_back();
  EXPECT_THROW(store::write_motion_model(path, model), InternalError);
  model.zero_varus.reset();
  model.smoothed[0].recontact_mm->conservativeResize(2, 2);
  EXPECT_THROW(store::write_motion_model(path, model), InternalError);
  model.smoothed[0].recontact_mm.reset();
  model.smoothed[0].surfaces.push_back(model.smoothed[0].surfaces[0]);
  EXPECT_THROW(store::write_motion_model(path, model), InternalError);
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
