// Motion models and traces as HDF5 files, changed in their bytes and through HDF5.
#include "fuzz/changed_content.hpp"

#include <hdf5.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <limits>
#include <string_view>

#include "fuzz/small_models.hpp"
#include "store/h5_file.hpp"
#include "store/motion_model.hpp"
#include "store/read_separately.hpp"
#include "store/trace.hpp"

/// HDF5's internal function, exported by its library.
extern "C" std::uint32_t H5_checksum_metadata(const void* data, std::size_t size, std::uint32_t seed);

namespace vrda::test {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN(),
                 infinity = std::numeric_limits<double>::infinity();
// Special numbers that may break readers.
constexpr std::array<double, 14> odd_reals = {0.0,  -0.0, 1.0,  -1.0, 1e-300, 1e300, -1e300,
                                              1e18, 1e9,  -1e9, 0.5,  90.0,   nan,   infinity};
constexpr std::array<std::uint64_t, 14> odd_integers = {0,
                                                        1,
                                                        2,
                                                        3,
                                                        0x7f,
                                                        0xff,
                                                        0x7fff,
                                                        0xffff,
                                                        0x7fffffff,
                                                        0xffffffff,
                                                        0x100000000,
                                                        0x7fffffffffffffff,
                                                        0xffffffffffffffff,
                                                        0x1000};

constexpr std::size_t change_bytes = 8;

std::uint32_t u32_at(const std::string& bytes, std::size_t at)
{
  std::uint32_t value = 0;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

/// One change of a recipe.
struct Change {
  std::uint8_t kind = 0;
  std::uint32_t place = 0;
  std::uint8_t a = 0, b = 0, c = 0;
};

Change change_at(const std::uint8_t* data)
{
  Change change{data[0], 0, data[5], data[6], data[7]};
  std::memcpy(&change.place, data + 1, sizeof change.place);
  return change;
}

void put(std::string& bytes, std::size_t at, const void* value, std::size_t size)
{
  if (at < bytes.size()) std::memcpy(bytes.data() + at, value, std::min(size, bytes.size() - at));
}

/// An offset in the metadata, in a dataset's values, or anywhere.
std::size_t place_of(const Change& change, const BaseContent& base, const std::string& bytes)
{
  if (bytes.empty()) return 0;
  const std::size_t offset = change.place >> 8;
  if (change.b % 3 == 0 && !base.checksummed.empty()) {
    const ChecksummedBlock& block = base.checksummed[(change.place & 0xffU) % base.checksummed.size()];
    return block.first + offset % block.size;
  }
  if (change.b % 3 == 1 && !base.values.empty())
    return base.values[(change.place & 0xffU) % base.values.size()] + offset % 256;
  return change.place % bytes.size();
}

void apply(std::string& bytes, const Change& change, const BaseContent& base, const BaseContent& other)
{
  const std::size_t at = place_of(change, base, bytes);
  if (at >= bytes.size()) return;
  switch (change.kind % 8) {
    case 0:
      bytes[at] = static_cast<char>(bytes[at] ^ (1 << change.a % 8));
      return;
    case 1:
      bytes[at] = static_cast<char>(change.a);
      return;
    case 2:
      put(bytes, at, &odd_integers[change.a % odd_integers.size()], std::size_t{1} << change.c % 4);
      return;
    case 3:
      put(bytes, at - at % 4, &odd_reals[change.a % odd_reals.size()], sizeof(double));
      return;
    case 4: {  // copy one part over another
      const std::size_t from = (change.place * std::size_t{2654435761}) % bytes.size();
      const std::string part = bytes.substr(from, 1 + change.a);
      put(bytes, at, part.data(), part.size());
      return;
    }
    case 5: {
      const std::string zeros(1 + change.a, change.c % 2 == 0 ? '\0' : '\xff');
      put(bytes, at, zeros.data(), zeros.size());
      return;
    }
    case 6:  // a splice; sometimes a truncation
      if (change.c % 8 == 0) {
        bytes.resize(at);
      } else {
        const std::string part =
            other.bytes.substr(std::min(at, other.bytes.size()), change.a * std::size_t{16});
        put(bytes, at, part.data(), part.size());
      }
      return;
    default:  // a slightly changed length or address
      bytes[at] = static_cast<char>(bytes[at] + (change.a % 2 == 0 ? 1 : -1) * (1 + change.a / 64));
  }
}

void mend_sums(std::string& bytes, const std::vector<ChecksummedBlock>& summed)
{
  for (const ChecksummedBlock& block : summed) {
    if (block.first + block.size + 4 > bytes.size()) continue;
    const std::uint32_t sum = H5_checksum_metadata(bytes.data() + block.first, block.size, 0);
    std::memcpy(bytes.data() + block.first + block.size, &sum, sizeof sum);
  }
}

/// Layout of the HDF5 file `bytes`: blocks with checksums and the datasets' values.
BaseContent base_of_hdf5(const std::string& bytes, const std::vector<std::size_t>& values)
{
  constexpr std::size_t longest = 2048;
  constexpr std::size_t superblock_bytes = 44;
  BaseContent base{bytes, {{0, superblock_bytes}}, values};
  for (const std::string_view signature : {"OHDR", "OCHK", "FRHP", "BTHD", "BTIN", "BTLF", "FSHD", "SMTB"}) {
    for (std::size_t at = bytes.find(signature); at != std::string::npos;
         at = bytes.find(signature, at + 1)) {
      // Their lengths are in other blocks; the end is found by the checksum.
      for (std::size_t size = 8; size < longest && at + size + 4 <= bytes.size(); ++size) {
        if (H5_checksum_metadata(bytes.data() + at, size, 0) != u32_at(bytes, at + size)) continue;
        base.checksummed.push_back({at, size});
        break;
      }
    }
  }
  return base;
}

}  // namespace

std::string changed(const std::vector<BaseContent>& bases, const std::uint8_t* recipe, std::size_t size)
{
  if (size < 2) return bases.front().bytes;
  const BaseContent& base = bases[recipe[0] % bases.size()];
  const BaseContent& other = bases[(recipe[0] / 16U) % bases.size()];
  std::string bytes = base.bytes;
  for (std::size_t at = 2; at + change_bytes <= size; at += change_bytes)
    apply(bytes, change_at(recipe + at), base, other);
  if (base.checksummed.empty()) return bytes;  // no file
  if (recipe[1] % 8 != 1) mend_sums(bytes, base.checksummed);
  return recipe[1] % 16 == 2 ? bytes : bytes + store::seal_of(bytes);
}

// Changes through HDF5.

namespace {

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

void apply_to_objects(store::H5Id file, const ObjectChange& change)
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

/// Paths of all groups and datasets in the HDF5 file `bytes`, except the root.
std::vector<std::string> object_paths(const std::string& bytes)
{
  std::vector<std::string> paths;
  const store::H5Handle file = opened(bytes);
  H5Ovisit2(file.id(), H5_INDEX_NAME, H5_ITER_INC, add_path, &paths, H5O_INFO_BASIC);
  return paths;
}

/// `bytes`, an HDF5 file with objects at `paths`, after the changes in `recipe` of eight bytes each. The
/// first byte selects removed, moved, symbolic, external or cyclic links, datasets of other shapes, types,
/// layouts and filters, other attributes or other values. Changes that HDF5 rejects are skipped. No seal.
std::string with_changed_objects(const std::string& bytes, const std::vector<std::string>& paths,
                                 const std::uint8_t* recipe, std::size_t size)
{
  const store::H5Handle file = opened(bytes);
  if (file.id() < 0) return bytes;
  for (std::size_t at = 0; at + change_bytes <= size; at += change_bytes) {
    std::array<std::uint16_t, 2> objects{};
    std::memcpy(objects.data(), recipe + at + 1, sizeof objects);
    apply_to_objects(file.id(),
                     {recipe[at], paths[objects[0] % paths.size()], paths[objects[1] % paths.size()],
                      recipe[at + 5], recipe[at + 6], recipe[at + 7]});
  }
  return image_of(file);
}

// Files.

struct Bases {
  std::vector<BaseContent> contents;
  std::vector<std::vector<std::string>> paths;  ///< of the objects of each
};

/// Offsets of the values of every contiguous dataset.
herr_t add_offset(hid_t group, const char* name, const H5O_info_t* info, void* offsets)
{
  if (info->type != H5O_TYPE_DATASET) return 0;
  const hid_t dataset = H5Dopen2(group, name, H5P_DEFAULT);
  const haddr_t offset = H5Dget_offset(dataset);
  if (offset != HADDR_UNDEF) static_cast<std::vector<std::size_t>*>(offsets)->push_back(offset);
  H5Dclose(dataset);
  return 0;
}

void add_base(Bases& bases, const std::string& path)
{
  constexpr std::size_t seal_bytes = 16;
  std::ifstream stream(path, std::ios::binary);
  std::string bytes(std::istreambuf_iterator<char>(stream), {});
  bytes.resize(bytes.size() - seal_bytes);
  std::vector<std::size_t> offsets;
  const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  H5Ovisit2(file, H5_INDEX_NAME, H5_ITER_INC, add_offset, &offsets, H5O_INFO_BASIC);
  H5Fclose(file);
  bases.contents.push_back(base_of_hdf5(bytes, offsets));
  bases.paths.push_back(object_paths(bytes));
}

/// The small models, and a trace at the end.
Bases made_bases()
{
  const std::string path = "/dev/shm/vrda-fuzz-base-" + std::to_string(getpid());
  Bases bases;
  for (const store::MotionModel& model : small_models()) {
    store::write_motion_model(path, model);
    add_base(bases, path);
  }
  store::write_trace(path, small_trace());
  add_base(bases, path);
  std::remove(path.c_str());
  return bases;
}

/// A batch uses all of them; the two large ones, which take four times as long, only occasionally.
constexpr std::array<std::size_t, 32> order{5, 0, 6, 5, 0, 4, 5, 2, 5, 0, 6, 5, 0, 4, 5, 3,
                                            5, 0, 6, 5, 0, 4, 5, 2, 5, 0, 6, 5, 0, 4, 5, 1};

}  // namespace

ChangedFile changed_file(const std::uint8_t* recipe, std::size_t size, std::size_t k)
{
  static const Bases bases = made_bases();
  constexpr std::size_t head_bytes = 2;
  std::vector<std::uint8_t> own(recipe, recipe + size);
  own.resize(std::max(size, head_bytes));
  for (std::size_t at = head_bytes; at < size; ++at) {
    if ((at * 7 + k) % 3 == 0) own[at] = static_cast<std::uint8_t>(own[at] + 37 * k);
  }
  const std::size_t base = order[(own[0] + k) % order.size()];
  const bool is_trace = base + 1 == bases.contents.size();
  own[0] = static_cast<std::uint8_t>(base + 16 * (own[0] / 16U % bases.contents.size()));
  // Every third file is changed through HDF5, which gives valid files with other content.
  if ((own[1] / 16U + k) % 3 != 0) return {changed(bases.contents, own.data(), own.size()), is_trace};
  const std::string bytes = with_changed_objects(bases.contents[base].bytes, bases.paths[base],
                                                 own.data() + head_bytes, own.size() - head_bytes);
  return {bytes + store::seal_of(bytes), is_trace};
}

}  // namespace vrda::test
