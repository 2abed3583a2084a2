#include "store/changed_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "core/text.hpp"
#include "store/motion_model.hpp"
#include "store/read_separately.hpp"
#include "support/refusal.hpp"
#include "support/scratch.hpp"

namespace vrda::test {

void change(const std::string& path, const std::function<void(hid_t)>& action)
{
  const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
  ASSERT_GE(file, 0);
  action(file);
  ASSERT_GE(H5Fclose(file), 0);
  // HDF5 has truncated the seal.
  const std::string bytes = read_bytes(path);
  std::ofstream(path, std::ios::binary | std::ios::app) << store::seal_of(bytes);
}

void remove(hid_t file, const char* path)
{
  ASSERT_GE(H5Ldelete(file, path, H5P_DEFAULT), 0);
}

void replace(hid_t file, const NewDataset& wanted)
{
  remove(file, wanted.path);
  const hid_t space = H5Screate_simple(static_cast<int>(wanted.shape.size()), wanted.shape.data(), nullptr);
  const hid_t dataset =
      H5Dcreate2(file, wanted.path, wanted.type, space, H5P_DEFAULT, wanted.creation, H5P_DEFAULT);
  ASSERT_GE(dataset, 0);
  H5Dclose(dataset);
  H5Sclose(space);
}

void set_text(hid_t file, const char* object, const char* name, const char* value)
{
  ASSERT_GE(H5Adelete_by_name(file, object, name, H5P_DEFAULT), 0);
  const hid_t type = H5Tcopy(H5T_C_S1);
  H5Tset_size(type, H5T_VARIABLE);
  H5Tset_cset(type, H5T_CSET_UTF8);
  const hsize_t one = 1;
  const hid_t space = H5Screate_simple(1, &one, nullptr);
  const hid_t attribute =
      H5Acreate_by_name(file, object, name, type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  ASSERT_GE(H5Awrite(attribute, type, &value), 0);
  H5Aclose(attribute);
  H5Sclose(space);
  H5Tclose(type);
}

void make_group(hid_t file, const std::string& path)
{
  const hid_t group = H5Gcreate2(file, path.c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  ASSERT_GE(group, 0);
  H5Gclose(group);
}

std::vector<store::Finding> findings_after(const store::MotionModel& model,
                                           const std::function<void(hid_t)>& action)
{
  const Scratch scratch;
  const std::string path = scratch.path() / "knee.h5";
  store::write_motion_model(path, model);
  change(path, action);
  std::vector<store::Finding> findings = store::validate_hdf5(path);
  EXPECT_FALSE(findings.empty());
  EXPECT_THAT(input_error([&] { store::read_motion_model(path); }),
              refuses({path, findings.empty() ? "" : findings[0].where}));
  return findings;
}

void expect_first(const std::vector<store::Finding>& findings, const char* where, const char* found,
                  const char* wanted)
{
  ASSERT_FALSE(findings.empty());
  const InputError::Facts first{"", findings[0].where, findings[0].found, findings[0].wanted};
  EXPECT_THAT(first, refuses({"", where, found, wanted}));
}

void expect_finding(store::MotionModel model, const Damage& damage)
{
  SCOPED_TRACE(damage.where);
  const Scratch scratch;
  const std::string path = scratch.path() / "knee.h5";
  damage.act(model);
  store::write_motion_model(path, model);
  const std::vector<store::Finding> findings = store::validate_hdf5(path);
  ASSERT_EQ(findings.size(), 1u);
  expect_first(findings, damage.where, damage.found, damage.wanted);
  EXPECT_THAT(input_error([&] { store::read_motion_model(path); }), refuses({path, damage.where}));
}

}  // namespace vrda::test
