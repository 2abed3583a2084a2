// Motion models changed by another HDF5 program, and damaged files.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <hdf5.h>
#include <hdf5_hl.h>

#include <filesystem>
#include <functional>

#include "core/text.hpp"
#include "store/changed_file.hpp"
#include "store/motion_model.hpp"
#include "store/read_separately.hpp"
#include "store/sample_model.hpp"
#include "support/refusal.hpp"
#include "support/scratch.hpp"

namespace vrda::structure_test {

using test::change;
using test::expect_first;
using test::make_group;
using test::remove;
using test::replace;
using test::set_text;
using ::testing::HasSubstr;

std::vector<store::Finding> findings_after(const std::function<void(hid_t)>& action)
{
  return test::findings_after(test::sample_model(), action);
}

std::vector<store::Finding> findings_after_whole(const std::function<void(hid_t)>& action)
{
  return test::findings_after(test::whole_model(), action);
}

/// Changes the number of a one-element attribute, keeping its type.
void set_number(hid_t file, const char* object, const char* name, double value)
{
  const hid_t old = H5Aopen_by_name(file, object, name, H5P_DEFAULT, H5P_DEFAULT);
  const hid_t type = H5Aget_type(old), space = H5Aget_space(old);
  H5Aclose(old);
  ASSERT_GE(H5Adelete_by_name(file, object, name, H5P_DEFAULT), 0);
  const hid_t attribute =
      H5Acreate_by_name(file, object, name, type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  ASSERT_GE(H5Awrite(attribute, H5T_NATIVE_DOUBLE, &value), 0);
  H5Aclose(attribute);
  H5Sclose(space);
  H5Tclose(type);
}

TEST(Structure, AnUnchangedFileReopenedForWritingStaysValid)
{
  const test::Scratch scratch;
  const std::string path = scratch.path() / "knee.h5";
  store::write_motion_model(path, test::sample_model());
  change(path, [](hid_t file) { set_text(file, "/", "title", "renamed"); });
  EXPECT_TRUE(store::validate_hdf5(path).empty());
  EXPECT_EQ(store::read_motion_model(path).title, "renamed");
}

TEST(Structure, UnknownObjectsOfALaterMinorVersionAreIgnored)
{
  const test::Scratch scratch;
  const std::string path = scratch.path() / "knee.h5";
  store::write_motion_model(path, test::sample_model());
  change(path, [](hid_t file) {
    make_group(file, "/later");
    set_text(file, "/", "format_version", "1.999");
  });
  EXPECT_TRUE(store::validate_hdf5(path).empty());
}

TEST(Structure, FormatAndVersion)
{
  expect_first(findings_after([](hid_t file) { H5Adelete(file, "format"); }), "/@format", "nothing",
               "vrda motion model");
  expect_first(findings_after([](hid_t file) { set_text(file, "/", "format", "other"); }), "/@format",
               "\"other\"", "vrda motion model");
  for (const char* version : {"2.0", "1.", "1.3", "1.x", "1.1x", "1.-1", "1.99999999999"}) {
    SCOPED_TRACE(version);
    expect_first(findings_after([&](hid_t file) { set_text(file, "/", "format_version", version); }),
                 "/@format_version", version, "\"1.\"");
  }
  for (const char* version : {"2.0", "2", "10.3"}) {
    SCOPED_TRACE(version);
    expect_first(findings_after([&](hid_t file) { set_text(file, "/", "format_version", version); }),
                 "/@format_version", "a newer format", "this program reads");
  }
}

TEST(Structure, MissingObjects)
{
  expect_first(findings_after([](hid_t file) { remove(file, "/tx"); }), "/tx", "nothing",
               "translation along X");
  expect_first(findings_after([](hid_t file) { remove(file, "/flexion"); }), "/flexion", "nothing",
               "dimension scale");
  expect_first(findings_after([](hid_t file) { remove(file, "/contacts"); }), "/contacts", "nothing",
               "a group");
  expect_first(findings_after([](hid_t file) { remove(file, "/clinical"); }), "/clinical", "nothing",
               "a group");
  expect_first(findings_after([](hid_t file) { H5Adelete(file, "has_compartments"); }), "/@has_compartments",
               "nothing", "int8");
  expect_first(findings_after([](hid_t file) { H5Adelete(file, "delta"); }), "/@delta", "nothing",
               "3 of float64");
  expect_first(findings_after([](hid_t file) {
                 remove(file, "/tx");
                 make_group(file, "/tx");
               }),
               "/tx", "a group", "a dataset");
}

TEST(Structure, TypesAndShapes)
{
  expect_first(findings_after([](hid_t file) {
                 replace(file, {"/tx", {4, 3}, H5T_STD_I32LE});
               }),
               "/tx", "int32", "float64");
  expect_first(findings_after([](hid_t file) {
                 replace(file, {"/status", {4, 3}, H5T_STD_U8LE});
               }),
               "/status", "another type", "int8");
  expect_first(findings_after([](hid_t file) { replace(file, {"/tx", {3, 4}}); }), "/tx", "[3, 4]", "[4, 3]");
  expect_first(findings_after([](hid_t file) { replace(file, {"/tx", {12}}); }), "/tx", "[12]", "[4, 3]");
}

TEST(Structure, DimensionScales)
{
  expect_first(
      findings_after([](hid_t file) { H5Adelete_by_name(file, "/ty", "DIMENSION_LIST", H5P_DEFAULT); }),
      "/ty", "axis 0 without its scale", "/flexion attached");
  expect_first(findings_after([](hid_t file) { H5Adelete_by_name(file, "/varus", "CLASS", H5P_DEFAULT); }),
               "/varus", "no dimension scale", "a dimension scale");
}

TEST(Structure, Attributes)
{
  expect_first(findings_after([](hid_t file) { set_text(file, "/ty", "units", "m"); }), "/ty@units", "\"m\"",
               "\"mm\"");
  expect_first(findings_after([](hid_t file) { H5Adelete_by_name(file, "/tx", "units", H5P_DEFAULT); }),
               "/tx@units", "nothing", "\"mm\"");
  expect_first(findings_after([](hid_t file) { set_text(file, "/status", "flag_meanings", "good bad"); }),
               "/status@flag_meanings", "good bad", "pending stable");
  expect_first(
      findings_after([](hid_t file) { H5Adelete_by_name(file, "/status", "flag_values", H5P_DEFAULT); }),
      "/status@flag_values", "nothing", "int8");
  expect_first(findings_after([](hid_t file) { H5Adelete_by_name(file, "/tx", "_FillValue", H5P_DEFAULT); }),
               "/tx@_FillValue", "nothing", "NaN");
}

TEST(Structure, SmoothedGroups)
{
  expect_first(findings_after([](hid_t file) { make_group(file, "/smoothed/degree_six"); }),
               "/smoothed/degree_six", "another name", "integer");
  expect_first(findings_after([](hid_t file) { remove(file, "/smoothed/degree_1/coefficients_ty"); }),
               "/smoothed/degree_1/coefficients_ty", "nothing", "a dataset");
  expect_first(findings_after([](hid_t file) {
                 H5Lmove(file, "/smoothed/degree_1", file, "/smoothed/degree_2", H5P_DEFAULT, H5P_DEFAULT);
               }),
               "/smoothed/degree_2@degree", "1", "2, the value from");
}

TEST(Structure, LinksOutOfTheFileAreRefused)
{
  expect_first(findings_after([](hid_t file) {
                 remove(file, "/tx");
                 H5Lcreate_external("/etc/passwd", "/tx", file, "/tx", H5P_DEFAULT, H5P_DEFAULT);
               }),
               "/tx", "another file", "itself");
  expect_first(findings_after([](hid_t file) {
                 H5Lcreate_soft("/ty", file, "/clinical/alias", H5P_DEFAULT, H5P_DEFAULT);
               }),
               "/clinical/alias", "symbolic link", "itself");
}

TEST(Structure, StorageOutOfTheOrdinaryIsRefused)
{
  expect_first(findings_after([](hid_t file) {
                 const hid_t creation = H5Pcreate(H5P_DATASET_CREATE);
                 H5Pset_external(creation, "/etc/passwd", 0, H5F_UNLIMITED);
                 replace(file, {"/tx", {4, 3}, H5T_IEEE_F64LE, creation});
                 H5Pclose(creation);
               }),
               "/tx", "another file", "gzip");
  expect_first(findings_after([](hid_t file) {
                 const hid_t creation = H5Pcreate(H5P_DATASET_CREATE);
                 const hsize_t chunk[] = {4, 3};
                 H5Pset_chunk(creation, 2, chunk);
                 H5Pset_nbit(creation);
                 replace(file, {"/tx", {4, 3}, H5T_IEEE_F64LE, creation});
                 H5Pclose(creation);
               }),
               "/tx", "filter number 5", "gzip");
}

TEST(Structure, AbsurdSizesAreRefusedBeforeAnythingIsAllocated)
{
  // 24 GB of vertices, none of them stored in the file.
  const std::vector<store::Finding> findings = findings_after([](hid_t file) {
    constexpr hsize_t n = 1000000000;
    replace(file, {"/bodies/reference/vertex", {n}, H5T_IEEE_F32BE});
    const hid_t scale = H5Dopen2(file, "/bodies/reference/vertex", H5P_DEFAULT);
    H5DSset_scale(scale, "vertex");
    H5Dclose(scale);
    replace(file, {"/bodies/reference/vertices", {n, 3}});
    replace(file, {"/bodies/reference/normals", {n, 3}});
  });
  expect_first(findings, "/bodies/reference/vertices", "too large for the 0 bytes stored", "can be read");
  expect_first(findings_after([](hid_t file) {
                 replace(file, {"/contacts/contact", {hsize_t{1} << 40}, H5T_IEEE_F32BE});
                 const hid_t scale = H5Dopen2(file, "/contacts/contact", H5P_DEFAULT);
                 H5DSset_scale(scale, "contact");
                 H5Dclose(scale);
               }),
               "/contacts/contact", "[1099511627776]", "at most 2147483647");
}

TEST(Structure, WhatIsDerivedMayBeAbsent)
{
  const test::Scratch scratch;
  const std::string path = scratch.path() / "knee.h5";
  store::write_motion_model(path, test::whole_model());
  change(path, [](hid_t file) {
    for (const char* object : {"/zero_varus", "/audit/raw", "/job/scaling", "/ligaments"})
      remove(file, object);
  });
  EXPECT_TRUE(store::validate_hdf5(path).empty());
  const store::MotionModel read = store::read_motion_model(path);
  EXPECT_FALSE(read.zero_varus || read.job.scaling || read.ligaments);
  EXPECT_EQ(read.audits.size(), 3u);
}

TEST(Structure, FlagsAre0Or1)
{
  expect_first(
      findings_after_whole([&](hid_t file) { set_number(file, "/smoothed/degree_1", "is_robust", 2.0); }),
      "/smoothed/degree_1@is_robust", "another value", "0 or 1");
}

TEST(Structure, AnAuditHasAGridOfItsOwn)
{
  expect_first(findings_after_whole([](hid_t file) {
                 replace(file, {"/audit/raw/flexion", {0}});
                 const hid_t scale = H5Dopen2(file, "/audit/raw/flexion", H5P_DEFAULT);
                 H5DSset_scale(scale, "flexion");
                 H5Dclose(scale);
               }),
               "/audit/raw/flexion", "no values", "at least one");
  expect_first(findings_after_whole([](hid_t file) {
                 replace(file, {"/audit/raw/state", {4, 3}, H5T_STD_I8LE});
               }),
               "/audit/raw/state", "[4, 3]", "[7, 3]");
}

/// An axis of `n` entries without stored values.
void promise(hid_t file, const char* axis, hsize_t n)
{
  replace(file, {axis, {n}, H5T_IEEE_F32BE});
  const hid_t scale = H5Dopen2(file, axis, H5P_DEFAULT);
  ASSERT_GE(H5DSset_scale(scale, "axis"), 0);
  H5Dclose(scale);
}

TEST(Structure, AbsurdSizesOfMechanicsAreRefused)
{
  constexpr hsize_t many = hsize_t{1} << 40;
  for (const char* axis : {"/ligaments/fibre", "/ligaments/wrapping", "/equilibrium/forces/force"}) {
    SCOPED_TRACE(axis);
    expect_first(findings_after_whole([&](hid_t file) { promise(file, axis, many); }), axis,
                 "[1099511627776]", "at most 2147483647");
  }
  // 16 GB of texts and 96 GB per surface of the fibres, none of them stored in the file.
  constexpr hsize_t n = 1000000000;
  const hid_t text = H5Tcopy(H5T_C_S1);
  H5Tset_size(text, H5T_VARIABLE);
  H5Tset_cset(text, H5T_CSET_UTF8);
  const std::vector<store::Finding> names = findings_after_whole([&](hid_t file) {
    promise(file, "/ligaments/fibre", n);
    replace(file, {"/ligaments/name", {n}, text});
  });
  H5Tclose(text);
  expect_first(names, "/ligaments/name", "too large for the 0 bytes stored", "can be read");
  const std::vector<store::Finding> forces = findings_after_whole([&](hid_t file) {
    promise(file, "/equilibrium/forces/force", n);
    replace(file, {"/equilibrium/forces/point", {n, 3}});
  });
  expect_first(forces, "/equilibrium/forces/point", "too large for the 0 bytes stored", "can be read");
}

TEST(Structure, AnAuditHasTheNameOfAMotion)
{
  for (const char* name : {"smooth", "degree_", "degree_06", "degree_21", "degree_6_", "degree_-1"}) {
    SCOPED_TRACE(name);
    const std::string path = std::string("/audit/") + name;
    expect_first(findings_after_whole([&](hid_t file) { make_group(file, path); }), path.c_str(),
                 "another name", "degree_N_recontacted");
  }
  // A later minor version may have more of them.
  const test::Scratch scratch;
  const std::string path = scratch.path() / "knee.h5";
  const store::MotionModel model = test::whole_model();
  store::write_motion_model(path, model);
  change(path, [](hid_t file) {
    make_group(file, "/audit/living");
    set_text(file, "/", "format_version", "1.999");
  });
  EXPECT_EQ(store::read_motion_model(path).audits.size(), model.audits.size());
}

TEST(Structure, TheLargestValuesAreThoseOfTheAudit)
{
  expect_first(
      findings_after_whole([](hid_t file) { set_number(file, "/audit/raw", "largest_penetration", 0.0); }),
      "/audit/raw@largest_penetration", "0", "1, the value from");
  expect_first(findings_after_whole([](hid_t file) {
                 set_number(file, "/audit/raw", "largest_gap", std::numeric_limits<double>::quiet_NaN());
               }),
               "/audit/raw@largest_gap", "nan", "0.5, the value from");
}

TEST(Structure, NestingWithoutEndIsRefused)
{
  const std::vector<store::Finding> findings = findings_after([](hid_t file) {
    make_group(file, "/loop");
    H5Lcreate_hard(file, "/loop", file, "/loop/loop", H5P_DEFAULT, H5P_DEFAULT);
  });
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_EQ(findings[0].where, "/loop/loop/loop/loop/loop/loop/loop/loop/loop");
  EXPECT_TRUE(test::names_value(findings[0].found, "8")) << findings[0].found;
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

TEST(DamagedFile, IsRefusedWhereverTheDamageIs)
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

TEST(DamagedFile, ACompleteFileWithoutSealIsReadOnRequest)
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

TEST(DamagedFile, ACorruptChunkUnderARightSealIsAFinding)
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

}  // namespace vrda::structure_test
