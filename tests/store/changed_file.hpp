/// Motion models changed with HDF5, as by another program.
#pragma once

#include <hdf5.h>

#include <functional>
#include <string>
#include <vector>

#include "store/dataset.hpp"
#include "store/motion_model.hpp"

namespace vrda::test {

/// Opens the file, changes it, and closes it in any case.
void change(const std::string& path, const std::function<void(hid_t)>& action);

void remove(hid_t file, const char* path);

struct NewDataset {
  const char* path;
  std::vector<hsize_t> shape;
  hid_t type = H5T_IEEE_F64LE;
  hid_t creation = H5P_DEFAULT;
};

/// Replaces a dataset by an unwritten one.
void replace(hid_t file, const NewDataset& wanted);

/// Sets the text of an attribute.
void set_text(hid_t file, const char* object, const char* name, const char* value);

void make_group(hid_t file, const std::string& path);

/// The findings of `model`'s changed file; expects some, and that reading names the first.
std::vector<store::Finding> findings_after(const store::MotionModel& model,
                                           const std::function<void(hid_t)>& action);

void expect_first(const std::vector<store::Finding>& findings, const char* where, const char* found,
                  const char* wanted);

/// Damage to a model's values and the expected finding.
struct Damage {
  const char* where;
  const char* found;
  const char* wanted;
  std::function<void(store::MotionModel&)> act;
};

/// Writes `model` damaged, and expects exactly one finding and the same InputError from reading.
void expect_finding(store::MotionModel model, const Damage& damage);

}  // namespace vrda::test
