// /smoothed, /zero_varus and /audit of motion models changed by another HDF5 program.
#include <gtest/gtest.h>
#include <hdf5_hl.h>

#include <limits>

#include "store/changed_file.hpp"
#include "store/motion_model_file.hpp"
#include "store/sample_derived.hpp"
#include "store/sample_model.hpp"
#include "support/scratch.hpp"

namespace vrda::derived_structure_test {

using test::expect_first;
using test::remove;
using test::replace;

std::vector<Finding> findings_after(const std::function<void(hid_t)>& action)
{
  return test::findings_after(test::with_derived(test::sample_model()), action);
}

void remove_attribute(hid_t file, const char* object, const char* name)
{
  ASSERT_GE(H5Adelete_by_name(file, object, name, H5P_DEFAULT), 0);
}

/// Another number in an attribute of one element, of the type that it has.
void set_number(hid_t file, const char* object, const char* name, double value)
{
  const hid_t old = H5Aopen_by_name(file, object, name, H5P_DEFAULT, H5P_DEFAULT);
  const hid_t type = H5Aget_type(old), space = H5Aget_space(old);
  H5Aclose(old);
  remove_attribute(file, object, name);
  const hid_t attribute =
      H5Acreate_by_name(file, object, name, type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  ASSERT_GE(H5Awrite(attribute, H5T_NATIVE_DOUBLE, &value), 0);
  H5Aclose(attribute);
  H5Sclose(space);
  H5Tclose(type);
}

TEST(DerivedStructure, ASmoothedSetSaysWhetherItIsRobust)
{
  const char* group = "/smoothed/degree_1";
  expect_first(findings_after([&](hid_t file) { remove_attribute(file, group, "is_robust"); }),
               "/smoothed/degree_1@is_robust", "nothing", "1 of int8");
  expect_first(findings_after([&](hid_t file) { set_number(file, group, "is_robust", 2.0); }),
               "/smoothed/degree_1@is_robust", "another value", "0 or 1");
  expect_first(findings_after([](hid_t file) {
                 replace(file, {"/smoothed/degree_1/recontact", {4, 2}});
               }),
               "/smoothed/degree_1/recontact", "[4, 2]", "[4, 3]");
}

TEST(DerivedStructure, ASurfaceOfVarusIsWholeOrAbsent)
{
  const MotionModel model = test::with_derived(test::sample_model({4, 1, true, true, false}));
  const char* coefficients = "/smoothed/degree_1/coefficients_varus_solved";
  expect_first(test::findings_after(model, [&](hid_t file) { remove(file, coefficients); }), coefficients,
               "nothing", "a dataset");
  expect_first(
      test::findings_after(
          model, [](hid_t file) { remove_attribute(file, "/smoothed/degree_1/varus_solved", "rms"); }),
      "/smoothed/degree_1/varus_solved@rms", "nothing", "1 of float64");
}

TEST(DerivedStructure, AZeroVarusMotionIsWholeOrAbsent)
{
  for (const char* path :
       {"/zero_varus/source", "/zero_varus/varus_first", "/zero_varus/X_reference_moving",
        "/zero_varus/lateral_moving", "/zero_varus/instant_centre", "/zero_varus/medial_sliding"}) {
    SCOPED_TRACE(path);
    expect_first(findings_after([&](hid_t file) { remove(file, path); }), path, "nothing", "a dataset");
  }
  expect_first(findings_after([](hid_t file) {
                 replace(file, {"/zero_varus/helical_rotation", {4}});
               }),
               "/zero_varus/helical_rotation", "[4]", "[3]");
  expect_first(
      findings_after([](hid_t file) { test::set_text(file, "/zero_varus/source", "flag_meanings", "a b"); }),
      "/zero_varus/source@flag_meanings", "a b", "none both_touch interpolated free");
  const test::Scratch scratch;
  const std::string path = scratch.path() / "knee.h5";
  write_motion_model(path, test::with_derived(test::sample_model()));
  test::change(path, [](hid_t file) { remove(file, "/zero_varus"); });
  EXPECT_TRUE(validate_hdf5(path).empty());
  EXPECT_FALSE(read_motion_model(path).zero_varus.has_value());
}

TEST(DerivedStructure, AnAuditIsWholeOrAbsent)
{
  for (const char* path : {"/audit/raw/state", "/audit/raw/gap", "/audit/raw/penetration"}) {
    SCOPED_TRACE(path);
    expect_first(findings_after([&](hid_t file) { remove(file, path); }), path, "nothing", "a dataset");
  }
  for (const char* path : {"/audit/raw/flexion", "/audit/raw/varus"}) {
    SCOPED_TRACE(path);
    expect_first(findings_after([&](hid_t file) { remove(file, path); }), path, "nothing", "dimension scale");
  }
  for (const char* name : {"refine", "largest_penetration", "largest_gap"}) {
    SCOPED_TRACE(name);
    const std::string where = std::string("/audit/raw@") + name;
    expect_first(findings_after([&](hid_t file) { remove_attribute(file, "/audit/raw", name); }),
                 where.c_str(), "nothing", "1 of");
  }
  const test::Scratch scratch;
  const std::string path = scratch.path() / "knee.h5";
  write_motion_model(path, test::with_derived(test::sample_model()));
  test::change(path, [](hid_t file) { remove(file, "/audit/raw"); });
  EXPECT_TRUE(validate_hdf5(path).empty());
  EXPECT_EQ(read_motion_model(path).audits.size(), 3u);
}

TEST(DerivedStructure, AnAuditHasAGridOfItsOwn)
{
  expect_first(findings_after([](hid_t file) {
                 replace(file, {"/audit/raw/flexion", {0}});
                 const hid_t scale = H5Dopen2(file, "/audit/raw/flexion", H5P_DEFAULT);
                 H5DSset_scale(scale, "flexion");
                 H5Dclose(scale);
               }),
               "/audit/raw/flexion", "no values", "at least one");
  expect_first(findings_after([](hid_t file) {
                 replace(file, {"/audit/raw/state", {4, 3}, H5T_STD_I8LE});
               }),
               "/audit/raw/state", "[4, 3]", "[7, 3]");
}

TEST(DerivedStructure, AnAuditHasTheNameOfAMotion)
{
  for (const char* name : {"smooth", "degree_", "degree_06", "degree_21", "degree_6_", "degree_-1"}) {
    SCOPED_TRACE(name);
    const std::string path = std::string("/audit/") + name;
    expect_first(findings_after([&](hid_t file) { test::make_group(file, path); }), path.c_str(),
                 "no name of a motion", "degree_N_recontacted");
  }
  // A later minor version may know more of them.
  const test::Scratch scratch;
  const std::string path = scratch.path() / "knee.h5";
  const MotionModel model = test::with_derived(test::sample_model());
  write_motion_model(path, model);
  test::change(path, [](hid_t file) {
    test::make_group(file, "/audit/living");
    test::set_text(file, "/", "format_version", "1.999");
  });
  EXPECT_EQ(read_motion_model(path).audits.size(), model.audits.size());
}

TEST(DerivedStructure, TheLargestValuesAreThoseOfTheAudit)
{
  expect_first(findings_after([](hid_t file) { set_number(file, "/audit/raw", "largest_penetration", 0.0); }),
               "/audit/raw@largest_penetration", "0", "1, the largest of its values");
  expect_first(findings_after([](hid_t file) {
                 set_number(file, "/audit/raw", "largest_gap", std::numeric_limits<double>::quiet_NaN());
               }),
               "/audit/raw@largest_gap", "nan", "0.5, the largest of its values");
}

TEST(DerivedStructure, AbsurdSizesAreRefusedBeforeAnythingIsAllocated)
{
  // 24 GB of gaps of which the file stores none.
  const std::vector<Finding> findings = findings_after([](hid_t file) {
    constexpr hsize_t n = 1000000000;
    replace(file, {"/audit/raw/flexion", {n}});
    const hid_t scale = H5Dopen2(file, "/audit/raw/flexion", H5P_DEFAULT);
    ASSERT_GE(H5DSset_scale(scale, "flexion"), 0);
    H5Dclose(scale);
    replace(file, {"/audit/raw/gap", {n, 3}});
  });
  expect_first(findings, "/audit/raw/flexion", "too large for the 0 bytes stored", "can be read");
}

}  // namespace vrda::derived_structure_test
