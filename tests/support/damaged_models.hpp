/// Motion models with one damage each: the one list for the tests of the reader, of the commands and of the
/// player.
#pragma once

#include <hdf5.h>

#include <filesystem>
#include <functional>
#include <string>
#include <variant>
#include <vector>

#include "store/dataset.hpp"
#include "store/motion_model.hpp"

namespace vrda::test {

/// What is damaged: a small model, one with every dataset, a sequence of frames, one scaled unevenly.
enum class Intact { small, whole, frames, stretched };
store::MotionModel model_of(Intact intact);

/// To the values before they are written, or with HDF5 to the file, as by another program.
using ValueDamage = std::function<void(store::MotionModel&)>;
using FileDamage = std::function<void(hid_t)>;

struct Damage {
  const char* name;
  Intact intact;
  const char *where, *found, *wanted;  ///< of the first finding, as in a Refusal; of values the only one
  std::variant<ValueDamage, FileDamage> act;
};
const std::vector<Damage>& damages();

/// A copy of the model `whole` in `folder` with the damage to a file of that name; returns its path.
std::string damaged_copy(const std::filesystem::path& whole, const std::filesystem::path& folder,
                         const std::string& name);

/// Changes a file and seals it again.
void change(const std::string& path, const FileDamage& act);

// Parts of damages, also for tests that visit every dataset.

void remove(hid_t file, const char* path);
void make_group(hid_t file, const std::string& path);
void set_text(hid_t file, const char* object, const char* name, const char* value);

struct NewDataset {
  const char* path;
  std::vector<hsize_t> shape;
  hid_t type = H5T_IEEE_F64LE;
  hid_t creation = H5P_DEFAULT;
};
/// Replaces a dataset by one without values.
void replace(hid_t file, const NewDataset& wanted);

/// Replaces the axis of `n` entries, a dimension scale, and the arrays [n, 3] over it.
void promise(hid_t file, const char* axis, hsize_t n, const std::vector<const char*>& arrays = {},
             hid_t creation = H5P_DEFAULT);

void expect_first(const std::vector<store::Finding>& findings, const std::string& where,
                  const std::string& found, const std::string& wanted);

/// The findings of `model`'s changed file; expects some, and that reading names the first.
std::vector<store::Finding> findings_after(const store::MotionModel& model, const FileDamage& act);

}  // namespace vrda::test
