// /equilibrium and /ligaments of motion models changed by another HDF5 program.
#include <gtest/gtest.h>
#include <hdf5_hl.h>

#include "store/changed_file.hpp"
#include "store/motion_model_file.hpp"
#include "store/sample_model.hpp"

namespace vrda::mechanics_structure_test {

using test::expect_first;
using test::remove;
using test::replace;

std::vector<Finding> findings_after(const std::function<void(hid_t)>& action)
{
  return test::findings_after(test::sample_model({4, 3, true, true, true, true, 5, 2}), action);
}

/// An axis of `n` entries of which nothing is stored.
void promise(hid_t file, const char* axis, hsize_t n)
{
  replace(file, {axis, {n}, H5T_IEEE_F32BE});
  const hid_t scale = H5Dopen2(file, axis, H5P_DEFAULT);
  ASSERT_GE(H5DSset_scale(scale, "axis"), 0);
  H5Dclose(scale);
}

TEST(MechanicsStructure, AnEquilibriumNeedsItsGroups)
{
  expect_first(findings_after([](hid_t file) { remove(file, "/equilibrium"); }), "/equilibrium/forces/force",
               "nothing", "dimension scale");
  for (const char* path :
       {"/equilibrium/energy", "/equilibrium/worst_gap", "/equilibrium/force_medial",
        "/equilibrium/forces/along_delta", "/equilibrium/spine", "/equilibrium/spine/theta_low"}) {
    SCOPED_TRACE(path);
    expect_first(findings_after([&](hid_t file) { remove(file, path); }), path, "nothing", "a");
  }
  expect_first(findings_after([](hid_t file) {
                 H5Adelete_by_name(file, "/equilibrium", "band_moment_nmm", H5P_DEFAULT);
               }),
               "/equilibrium@band_moment_nmm", "nothing", "1 of float64");
  // The search has none, and one that is there all the same is no object of its.
  EXPECT_TRUE(test::sample_model().equilibrium == std::nullopt);
}

TEST(MechanicsStructure, LigamentsAreWholeOrAbsent)
{
  for (const char* path : {"/ligaments/bundle", "/ligaments/length", "/ligaments/wrap_shape"}) {
    SCOPED_TRACE(path);
    expect_first(findings_after([&](hid_t file) { remove(file, path); }), path, "nothing", "a dataset");
  }
  expect_first(findings_after([](hid_t file) { remove(file, "/ligaments/wrapping"); }), "/ligaments/wrapping",
               "nothing", "dimension scale");
  expect_first(findings_after([](hid_t file) {
                 replace(file, {"/ligaments/is_wrapped", {4, 3, 4}, H5T_STD_I8LE});
               }),
               "/ligaments/is_wrapped", "[4, 3, 4]", "[4, 3, 5]");
  expect_first(findings_after([](hid_t file) {
                 test::set_text(file, "/ligaments/wrap_body", "flag_meanings", "femur tibia");
               }),
               "/ligaments/wrap_body@flag_meanings", "femur tibia", "reference moving");
  expect_first(findings_after([](hid_t file) { test::set_text(file, "/ligaments/energy", "units", "mJ"); }),
               "/ligaments/energy@units", "mJ", "N mm");
}

TEST(MechanicsStructure, AbsurdSizesAreRefusedBeforeAnythingIsAllocated)
{
  constexpr hsize_t many = hsize_t{1} << 40;
  for (const char* axis : {"/ligaments/fibre", "/ligaments/wrapping", "/equilibrium/forces/force"}) {
    SCOPED_TRACE(axis);
    expect_first(findings_after([&](hid_t file) { promise(file, axis, many); }), axis, "[1099511627776]",
                 "at most 2147483647");
  }
  // 16 GB of texts, and 96 GB a surface of the fibres, of which the file stores none.
  constexpr hsize_t n = 1000000000;
  const hid_t text = H5Tcopy(H5T_C_S1);
  H5Tset_size(text, H5T_VARIABLE);
  H5Tset_cset(text, H5T_CSET_UTF8);
  const std::vector<Finding> names = findings_after([&](hid_t file) {
    promise(file, "/ligaments/fibre", n);
    replace(file, {"/ligaments/name", {n}, text});
  });
  H5Tclose(text);
  expect_first(names, "/ligaments/name", "too large for the 0 bytes stored", "can be read");
  const std::vector<Finding> forces = findings_after([&](hid_t file) {
    promise(file, "/equilibrium/forces/force", n);
    replace(file, {"/equilibrium/forces/point", {n, 3}});
  });
  expect_first(forces, "/equilibrium/forces/point", "too large for the 0 bytes stored", "can be read");
}

}  // namespace vrda::mechanics_structure_test
