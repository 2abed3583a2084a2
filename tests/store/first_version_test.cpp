// Files of format version 1.0, which knew no push, contact paths, solved varus, and no status `unbounded`,
// and of 1.1, which knew nothing that is made of the surfaces but plain polynomials.
#include <gtest/gtest.h>

#include "store/changed_file.hpp"
#include "store/contact_paths.hpp"
#include "store/equal_models.hpp"
#include "store/motion_model_file.hpp"
#include "store/sample_derived.hpp"
#include "store/sample_model.hpp"
#include "support/scratch.hpp"

namespace vrda::first_version_test {

/// What version 1.0 wrote of the model in `file`.
void make_first_version(hid_t file, bool has_compartments)
{
  test::remove_plausibility(file);
  test::set_text(file, "/", "format_version", "1.0");
  test::remove(file, "/push");
  test::remove(file, "/varus_solved");
  ASSERT_GE(H5Adelete_by_name(file, "/smoothed/degree_1", "is_robust", H5P_DEFAULT), 0);
  if (has_compartments) test::remove(file, "/contact_paths");
  test::set_codes(file, "/status", {-1, 0, 1, 2, 3});
  test::set_text(file, "/status", "flag_meanings", "pending stable no_contact no_clearance iteration_limit");
}

TEST(FirstVersion, IsReadWithThePushOfItsDeltaAndTheVarusOfItsAxis)
{
  const test::Scratch scratch;
  for (const bool has_compartments : {true, false}) {
    const std::string path = scratch.path() / "knee.h5";
    test::SampleOptions options;
    options.has_compartments = has_compartments;
    const MotionModel model = test::without_plausibility(test::sample_model(options));
    write_motion_model(path, model);
    test::change(path, [&](hid_t file) { make_first_version(file, has_compartments); });
    for (const Finding& finding : validate_hdf5(path)) {
      ADD_FAILURE() << finding.where << ": " << finding.found << ", wanted " << finding.wanted;
    }
    // The sample's push is constant, its varus that of the axis, and its paths those of the contacts.
    const MotionModel read = read_motion_model(path);
    test::expect_equal(read, model);
    // So it can be written again, as a file of today.
    const std::string again = scratch.path() / "again.h5";
    write_motion_model(again, read);
    EXPECT_TRUE(validate_hdf5(again).empty());
  }
}

TEST(FirstVersion, AFileOfTodayNeedsWhatVersionOneZeroDidNot)
{
  for (const char* path : {"/push", "/push/delta", "/varus_solved", "/contact_paths"}) {
    SCOPED_TRACE(path);
    const std::vector<Finding> findings =
        test::findings_after(test::sample_model(), [&](hid_t file) { test::remove(file, path); });
    test::expect_first(findings, path, "nothing", "a");
  }
}

TEST(FirstVersion, ItsStatusHasNoUnbounded)
{
  const std::vector<Finding> findings = test::findings_after(test::sample_model(), [](hid_t file) {
    make_first_version(file, true);
    test::set_codes(file, "/status", {-1, 0, 1, 2, 3, 4});
  });
  test::expect_first(findings, "/status@flag_values", "other values", "iteration_limit");
}

TEST(FirstVersion, WhatALaterMinorVersionAddsToItIsIgnored)
{
  const test::Scratch scratch;
  const std::string path = scratch.path() / "knee.h5";
  write_motion_model(path, test::sample_model());
  test::change(path, [](hid_t file) {
    make_first_version(file, true);
    test::make_group(file, "/ligaments");
    test::make_group(file, "/equilibrium");
  });
  EXPECT_TRUE(validate_hdf5(path).empty());
  EXPECT_FALSE(read_motion_model(path).ligaments.has_value());
}

/// What version 1.1 wrote of the model in `file`.
void make_second_version(hid_t file)
{
  test::remove_plausibility(file);
  test::set_text(file, "/", "format_version", "1.1");
  ASSERT_GE(H5Adelete_by_name(file, "/smoothed/degree_1", "is_robust", H5P_DEFAULT), 0);
}

TEST(SecondVersion, IsReadAsItIs)
{
  const test::Scratch scratch;
  const std::string path = scratch.path() / "knee.h5", today = scratch.path() / "today.h5";
  const test::SampleOptions variants[] = {{4, 3, true, true, true, true, 5, 2}, {4, 1}};
  for (const test::SampleOptions& options : variants) {
    const MotionModel model = test::without_plausibility(test::sample_model(options));
    write_motion_model(path, model);
    write_motion_model(today, model);
    test::change(path, make_second_version);
    EXPECT_TRUE(validate_hdf5(path).empty());
    const MotionModel read = read_motion_model(path);
    test::expect_equal(read, model);
    // Written again it is a file of today, to the byte.
    write_motion_model(path, read);
    EXPECT_EQ(test::read_bytes(path), test::read_bytes(today));
  }
}

TEST(SecondVersion, WhatVersionOneTwoAddedIsIgnoredInIt)
{
  const test::Scratch scratch;
  const std::string path = scratch.path() / "knee.h5";
  for (const std::int32_t n_varus : {3, 1}) {
    const MotionModel model =
        test::without_plausibility(test::sample_model({4, n_varus, true, true, n_varus > 1}));
    write_motion_model(path, test::with_derived(model));
    test::change(path, make_second_version);
    EXPECT_TRUE(validate_hdf5(path).empty());
    test::expect_equal(read_motion_model(path), model);
  }
}

TEST(FourthVersion, PosesOfAnOlderFileAreNotJudged)
{
  const test::Scratch scratch;
  const std::string path = scratch.path() / "knee.h5";
  write_motion_model(path, test::sample_model());
  test::change(path, [](hid_t file) {
    test::remove_plausibility(file);
    test::set_text(file, "/", "format_version", "1.3");
  });
  EXPECT_TRUE(validate_hdf5(path).empty());
  test::expect_equal(read_motion_model(path), test::without_plausibility(test::sample_model()));
}

TEST(FourthVersion, AFileOfTodayNeedsPlausibility)
{
  test::expect_first(
      test::findings_after(test::sample_model(), [](hid_t file) { test::remove(file, "/plausibility"); }),
      "/plausibility", "nothing", "a dataset");
}

}  // namespace vrda::first_version_test
