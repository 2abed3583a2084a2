// Motion models changed through HDF5.
#include "fuzz/changed_content.hpp"

#include <hdf5.h>

#include <algorithm>
#include <array>
#include <cstring>

#include "fuzz/odd_values.hpp"
#include "store/h5_file.hpp"

/// HDF5's internal function, exported by its library.
extern "C" std::uint32_t H5_checksum_metadata(const void* data, std::size_t size, std::uint32_t seed);

namespace vrda::test {
namespace {

constexpr std::size_t object_change_bytes = 8;

/// The parameters of one change of a recipe.
struct ObjectChange {
  std::uint8_t kind = 0;
  std::string object, other;
  std::uint8_t a = 0, b = 0, c = 0;
};

/// The file `bytes` in memory, open for changes.
store::H5Handle opened(const std::string& bytes)
{
  store::silence_h5();
  const store::H5Handle access(H5Pcreate(H5P_FILE_ACCESS));
  constexpr std::size_t growth_bytes = std::size_t{1} << 16;
  H5Pset_fapl_core(access.id(), growth_bytes, 0);
  std::string image = bytes;  // HDF5 copies it, but does not guarantee that it is unchanged
  H5Pset_file_image(access.id(), image.data(), image.size());
  return store::H5Handle(H5Fopen("model in memory", H5F_ACC_RDWR, access.id()));
}

std::string image_of(const store::H5Handle& file)
{
  H5Fflush(file.id(), H5F_SCOPE_GLOBAL);
  const ssize_t size = H5Fget_file_image(file.id(), nullptr, 0);
  std::string bytes(static_cast<std::size_t>(std::max<ssize_t>(size, 0)), '\0');
  H5Fget_file_image(file.id(), bytes.data(), bytes.size());
  // HDF5 1.10 clears a flag in the image without updating the checksum.
  constexpr std::size_t superblock_bytes = 44;
  if (bytes.size() < superblock_bytes + sizeof(std::uint32_t)) return bytes;
  const std::uint32_t sum = H5_checksum_metadata(bytes.data(), superblock_bytes, 0);
  std::memcpy(bytes.data() + superblock_bytes, &sum, sizeof sum);
  return bytes;
}

void cut(store::H5Id file, const std::string& path)
{
  H5Ldelete(file, path.c_str(), H5P_DEFAULT);
}

hid_t type_number(std::uint8_t number)
{
  const std::array<hid_t, 8> types{H5T_IEEE_F64LE, H5T_IEEE_F32LE, H5T_STD_I32LE,  H5T_STD_I8LE,
                                   H5T_STD_I64LE,  H5T_STD_U16BE,  H5T_IEEE_F64BE, H5T_C_S1};
  return types[number % types.size()];
}

/// Chunks, filters, fill values and external files.
store::H5Handle creation_of(const ObjectChange& change, const std::vector<hsize_t>& shape)
{
  store::H5Handle creation(H5Pcreate(H5P_DATASET_CREATE));
  const hid_t id = creation.id();
  if (change.b % 4 == 0 && !shape.empty()) {
    std::vector<hsize_t> chunk(shape.size(), 1 + change.c);
    H5Pset_chunk(id, static_cast<int>(chunk.size()), chunk.data());
    if (change.c % 2 == 0) H5Pset_deflate(id, 9);
    if (change.c % 3 == 0) H5Pset_scaleoffset(id, H5Z_SO_INT, 0);
    if (change.c % 5 == 0) H5Pset_fletcher32(id);
    if (change.c % 7 == 0) H5Pset_filter(id, 32000 + change.c, H5Z_FLAG_OPTIONAL, 0, nullptr);
  }
  if (change.b % 4 == 1) H5Pset_layout(id, H5D_COMPACT);
  if (change.b % 16 == 2) H5Pset_external(id, "elsewhere", 0, H5F_UNLIMITED);
  const double fill = odd_reals[change.c % odd_reals.size()];
  if (change.b % 8 < 4) H5Pset_fill_value(id, H5T_NATIVE_DOUBLE, &fill);
  return creation;
}

/// Replaces the object by another dataset. Most have no values; some have extreme sizes.
void put_dataset(store::H5Id file, const ObjectChange& change)
{
  cut(file, change.object);
  std::vector<hsize_t> shape(change.a % 5);
  for (std::size_t axis = 0; axis < shape.size(); ++axis)
    shape[axis] = odd_integers[(change.b + 5 * axis) % odd_integers.size()];
  const store::H5Handle space(H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr));
  const store::H5Handle creation = creation_of(change, shape);
  const store::H5Handle dataset(H5Dcreate2(file, change.object.c_str(), type_number(change.c), space.id(),
                                           H5P_DEFAULT, creation.id(), H5P_DEFAULT));
}

/// A dataset of the same shape and another type, with values.
void put_type(store::H5Id file, const ObjectChange& change)
{
  const store::H5Handle old(H5Dopen2(file, change.object.c_str(), H5P_DEFAULT));
  const store::H5Handle space(H5Dget_space(old.id()));
  cut(file, change.object);
  const store::H5Handle dataset(H5Dcreate2(file, change.object.c_str(), type_number(change.c), space.id(),
                                           H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
}

/// Changes every value or one value, which bit flips cannot do in compressed datasets.
void put_value(store::H5Id file, const ObjectChange& change)
{
  const store::H5Handle dataset(H5Dopen2(file, change.object.c_str(), H5P_DEFAULT));
  const store::H5Handle space(H5Dget_space(dataset.id()));
  const hssize_t n = H5Sget_simple_extent_npoints(space.id());
  if (n <= 0 || n > 100'000) return;
  std::vector<double> values(static_cast<std::size_t>(n));
  if (H5Dread(dataset.id(), H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) < 0) return;
  const double value = change.b % 2 == 0 ? odd_reals[change.a % odd_reals.size()] : 0.25 * change.a - 32.0;
  if (change.b % 8 == 7) {
    std::fill(values.begin(), values.end(), value);
  } else {
    values[change.c % values.size()] = value;
  }
  H5Dwrite(dataset.id(), H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
}

void put_attribute(store::H5Id file, const ObjectChange& change)
{
  const store::H5Handle object(H5Oopen(file, change.object.c_str(), H5P_DEFAULT));
  char name[256] = {};
  constexpr hsize_t n_tried = 4;
  H5Aget_name_by_idx(object.id(), ".", H5_INDEX_NAME, H5_ITER_INC, change.a % n_tried, name, sizeof name,
                     H5P_DEFAULT);
  H5Adelete(object.id(), name);
  if (change.b % 4 == 0) return;
  hsize_t size = odd_integers[change.b % 6];
  const store::H5Handle space(change.b % 4 == 1 ? H5Screate(H5S_SCALAR)
                                                : H5Screate_simple(1, &size, nullptr));
  const store::H5Handle type(H5Tcopy(type_number(change.c)));
  if (H5Tget_class(type.id()) == H5T_STRING) {
    H5Tset_size(type.id(), change.b % 8 < 4 ? H5T_VARIABLE : 1 + change.a);
    H5Tset_cset(type.id(), H5T_CSET_UTF8);
  }
  const store::H5Handle attribute(
      H5Acreate2(object.id(), name, type.id(), space.id(), H5P_DEFAULT, H5P_DEFAULT));
  const std::vector<double> values(1024, odd_reals[change.a % odd_reals.size()]);
  if (H5Tget_class(type.id()) != H5T_STRING) H5Awrite(attribute.id(), H5T_NATIVE_DOUBLE, values.data());
}

void apply(store::H5Id file, const ObjectChange& change)
{
  const char* object = change.object.c_str();
  const char* other = change.other.c_str();
  switch (change.kind % 12) {
    case 0:
      return cut(file, change.object);
    case 1:
      cut(file, change.other);
      H5Lmove(file, object, file, other, H5P_DEFAULT, H5P_DEFAULT);
      return;
    case 2:  // a second link to an object; a cycle if that is a parent group
      cut(file, change.object);
      H5Lcreate_hard(file, other, file, object, H5P_DEFAULT, H5P_DEFAULT);
      return;
    case 3: {  // a group that contains a parent group
      const std::string above = change.other.substr(0, std::max<std::size_t>(1, change.other.rfind('/')));
      H5Lcreate_hard(file, above.c_str(), file, (above + "/again").c_str(), H5P_DEFAULT, H5P_DEFAULT);
      return;
    }
    case 4:
      cut(file, change.object);
      H5Lcreate_soft(other, file, object, H5P_DEFAULT, H5P_DEFAULT);
      return;
    case 5:
      cut(file, change.object);
      H5Lcreate_external("elsewhere.h5", other, file, object, H5P_DEFAULT, H5P_DEFAULT);
      return;
    case 6:
      return put_dataset(file, change);
    case 7:
      return put_type(file, change);
    case 8:
      return put_attribute(file, change);
    case 9: {  // a group instead of a dataset
      cut(file, change.object);
      const store::H5Handle group(H5Gcreate2(file, object, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
      return;
    }
    default:
      return put_value(file, change);
  }
}

herr_t add_path(hid_t, const char* name, const H5O_info_t* info, void* paths)
{
  const bool is_known = info->type == H5O_TYPE_GROUP || info->type == H5O_TYPE_DATASET;
  if (is_known && name[0] != '.')
    static_cast<std::vector<std::string>*>(paths)->push_back(std::string("/") + name);
  return 0;
}

}  // namespace

std::vector<std::string> object_paths(const std::string& bytes)
{
  std::vector<std::string> paths;
  const store::H5Handle file = opened(bytes);
  H5Ovisit2(file.id(), H5_INDEX_NAME, H5_ITER_INC, add_path, &paths, H5O_INFO_BASIC);
  return paths;
}

std::string with_changed_objects(const std::string& bytes, const std::vector<std::string>& paths,
                                 const std::uint8_t* recipe, std::size_t size)
{
  const store::H5Handle file = opened(bytes);
  if (file.id() < 0) return bytes;
  for (std::size_t at = 0; at + object_change_bytes <= size; at += object_change_bytes) {
    std::array<std::uint16_t, 2> objects{};
    std::memcpy(objects.data(), recipe + at + 1, sizeof objects);
    apply(file.id(), {recipe[at], paths[objects[0] % paths.size()], paths[objects[1] % paths.size()],
                      recipe[at + 5], recipe[at + 6], recipe[at + 7]});
  }
  return image_of(file);
}

}  // namespace vrda::test
