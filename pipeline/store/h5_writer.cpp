#include "store/h5_writer.hpp"

#include <hdf5.h>
#include <hdf5_hl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <limits>

#include "core/error.hpp"

namespace vrda::store {
namespace {

constexpr const char* wanted_memory = "sufficient memory";

/// Smaller datasets stay contiguous: a chunk index alone takes about this many bytes.
constexpr std::size_t smallest_compressed_bytes = 4096;
/// Chunks of at most this size fit the reader's cache (1 MiB by default).
constexpr std::size_t largest_chunk_bytes = std::size_t{1} << 20;
/// Two thirds of the time of zlib's default, for files 1 % larger.
constexpr unsigned deflate_level = 4;

H5Id file_type(ValueKind kind)
{
  switch (kind) {
    case ValueKind::float64:
      return H5T_IEEE_F64LE;
    case ValueKind::float32:
      return H5T_IEEE_F32LE;
    case ValueKind::int64:
      return H5T_STD_I64LE;
    case ValueKind::int32:
      return H5T_STD_I32LE;
    case ValueKind::int8:
      return H5T_STD_I8LE;
    case ValueKind::text:
      break;
  }
  throw InternalError("text has no fixed file type");
}

H5Handle text_type(const H5Location& place)
{
  H5Handle type = own_h5(H5Tcopy(H5T_C_S1), place, wanted_memory);
  check_h5(H5Tset_size(type.id(), H5T_VARIABLE), place, wanted_memory);
  check_h5(H5Tset_cset(type.id(), H5T_CSET_UTF8), place, wanted_memory);
  return type;
}

H5Handle extent(const std::vector<std::int64_t>& shape, const H5Location& place)
{
  if (shape.empty()) return own_h5(H5Screate(H5S_SCALAR), place, wanted_memory);
  const std::vector<hsize_t> sizes(shape.begin(), shape.end());
  return own_h5(H5Screate_simple(static_cast<int>(sizes.size()), sizes.data(), nullptr), place,
                wanted_memory);
}

void disable_times_and_order_attributes(H5Id properties, const H5Location& place)
{
  check_h5(H5Pset_obj_track_times(properties, false), place, wanted_memory);
  check_h5(H5Pset_attr_creation_order(properties, H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED), place,
           wanted_memory);
}

void order_links(H5Id properties, const H5Location& place)
{
  check_h5(H5Pset_link_creation_order(properties, H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED), place,
           wanted_memory);
}

std::size_t count_of(const std::vector<std::int64_t>& shape)
{
  std::size_t count = 1;
  for (const std::int64_t size : shape) count *= static_cast<std::size_t>(size);
  return count;
}

/// Chunks of whole rows, compressed and with a checksum, so that a damaged one fails to read.
void compress(H5Id properties, const std::vector<std::int64_t>& shape, std::size_t element_bytes,
              const H5Location& place)
{
  const std::size_t row_bytes = count_of(shape) / static_cast<std::size_t>(shape[0]) * element_bytes;
  const std::size_t n_rows = std::max<std::size_t>(1, largest_chunk_bytes / row_bytes);
  std::vector<hsize_t> chunk(shape.begin(), shape.end());
  chunk[0] = std::min<hsize_t>(chunk[0], n_rows);
  check_h5(H5Pset_chunk(properties, static_cast<int>(chunk.size()), chunk.data()), place, wanted_memory);
  check_h5(H5Pset_shuffle(properties), place, wanted_memory);
  check_h5(H5Pset_deflate(properties, deflate_level), place, wanted_memory);
  check_h5(H5Pset_fletcher32(properties), place, wanted_memory);
}

std::string last_name(const std::string& path)
{
  return path.substr(path.rfind('/') + 1);
}

constexpr double the_nan = std::numeric_limits<double>::quiet_NaN();

/// An unnamed file in memory. HDF5's core driver was tried: version 1.10.8 returns a superblock whose
/// checksum does not match.
int memory_file(const std::string& path)
{
  const int descriptor = memfd_create("vrda", MFD_CLOEXEC);
  if (descriptor < 0) throw InputError({path, "", std::strerror(errno), wanted_memory});
  return descriptor;
}

std::string bytes_of_file(int descriptor, const std::string& path)
{
  struct stat facts {};
  const bool is_known = fstat(descriptor, &facts) == 0;
  std::string bytes(is_known ? static_cast<std::size_t>(facts.st_size) : 0, '\0');
  std::size_t n_read = 0;
  while (n_read < bytes.size()) {
    const ssize_t n =
        pread(descriptor, bytes.data() + n_read, bytes.size() - n_read, static_cast<off_t>(n_read));
    if (n <= 0) break;
    n_read += static_cast<std::size_t>(n);
  }
  if (!is_known || n_read < bytes.size()) throw InputError({path, "", std::strerror(errno), wanted_memory});
  return bytes;
}

}  // namespace

H5Writer::H5Writer(const std::string& path) : file_name_(path), memory_(memory_file(path))
{
  silence_h5();
  const H5Handle access = own_h5(H5Pcreate(H5P_FILE_ACCESS), place(""), wanted_memory);
  // The default driver resolves the real path of a link, which an unnamed file does not have.
  check_h5(H5Pset_fapl_stdio(access.id()), place(""), wanted_memory);
  check_h5(H5Pset_libver_bounds(access.id(), H5F_LIBVER_V18, H5F_LIBVER_V18), place(""), wanted_memory);
  const H5Handle creation = own_h5(H5Pcreate(H5P_FILE_CREATE), place(""), wanted_memory);
  disable_times_and_order_attributes(creation.id(), place(""));
  order_links(creation.id(), place(""));
  const std::string name = "/proc/self/fd/" + std::to_string(memory_);
  file_ =
      own_h5(H5Fcreate(name.c_str(), H5F_ACC_TRUNC, creation.id(), access.id()), place(""), wanted_memory);
}

H5Writer::~H5Writer()
{
  file_.reset();
  ::close(memory_);
}

H5Handle H5Writer::open(const std::string& object) const
{
  return own_h5(H5Oopen(file_.id(), object.c_str(), H5P_DEFAULT), place(object), wanted_memory);
}

void H5Writer::create_group(const std::string& path)
{
  const H5Handle creation = own_h5(H5Pcreate(H5P_GROUP_CREATE), place(path), wanted_memory);
  disable_times_and_order_attributes(creation.id(), place(path));
  order_links(creation.id(), place(path));
  own_h5(H5Gcreate2(file_.id(), path.c_str(), H5P_DEFAULT, creation.id(), H5P_DEFAULT), place(path),
         wanted_memory);
}

void H5Writer::create_dimension(const std::string& path, std::int64_t size)
{
  const H5Location here = place(path);
  {
    const H5Handle creation = own_h5(H5Pcreate(H5P_DATASET_CREATE), here, wanted_memory);
    disable_times_and_order_attributes(creation.id(), here);
    const H5Handle space = extent({size}, here);
    own_h5(H5Dcreate2(file_.id(), path.c_str(), H5T_IEEE_F32BE, space.id(), H5P_DEFAULT, creation.id(),
                      H5P_DEFAULT),
           here, wanted_memory);
  }
  // Name by which the netCDF library recognises a dimension without a variable.
  char name[80];
  std::snprintf(name, sizeof name, "This is a netCDF dimension but not a netCDF variable.%10lld",
                static_cast<long long>(size));
  make_scale(path, name);
}

void H5Writer::link(const std::string& target, const std::string& path)
{
  check_h5(H5Lcreate_hard(file_.id(), target.c_str(), file_.id(), path.c_str(), H5P_DEFAULT, H5P_DEFAULT),
           place(path), wanted_memory);
}

void H5Writer::make_scale(const std::string& path, const std::string& name)
{
  const H5Handle object = open(path);
  check_h5(H5DSset_scale(object.id(), name.c_str()), place(path), wanted_memory);
  scales_.push_back(path);
}

// H5DSattach_scale rewrites the scale's REFERENCE_LIST at every call, with uninitialised padding. So each
// DIMENSION_LIST is written with its dataset, and each REFERENCE_LIST once, at the end.
// Source: HDF5 Dimension Scale Specification, section 4.
void H5Writer::attach_scales(const Dataset& dataset)
{
  const H5Location here = place(dataset.path);
  std::vector<hobj_ref_t> references(dataset.dimensions.size());
  std::vector<hvl_t> lists(dataset.dimensions.size());
  for (std::size_t axis = 0; axis < dataset.dimensions.size(); ++axis) {
    const std::string& scale = dataset.dimensions[axis];
    check_h5(H5Rcreate(&references[axis], file_.id(), scale.c_str(), H5R_OBJECT, -1), here, wanted_memory);
    lists[axis] = {1, &references[axis]};
    users_[scale].push_back({dataset.path, static_cast<std::int32_t>(axis)});
  }
  const H5Handle type = own_h5(H5Tvlen_create(H5T_STD_REF_OBJ), here, wanted_memory);
  write_raw_attribute(dataset.path, "DIMENSION_LIST", {{}, type.id(), lists.data(), lists.size()});
}

void H5Writer::write_reference_list(const std::string& scale, const std::vector<Use>& uses)
{
  struct Entry {
    hobj_ref_t dataset;
    std::int32_t axis;
    std::int32_t padding;
  };
  const H5Location here = place(scale);
  std::vector<Entry> entries;
  for (const Use& use : uses) {
    Entry entry{0, use.axis, 0};
    check_h5(H5Rcreate(&entry.dataset, file_.id(), use.dataset.c_str(), H5R_OBJECT, -1), here, wanted_memory);
    entries.push_back(entry);
  }
  const H5Handle type = own_h5(H5Tcreate(H5T_COMPOUND, sizeof(Entry)), here, wanted_memory);
  check_h5(H5Tinsert(type.id(), "dataset", HOFFSET(Entry, dataset), H5T_STD_REF_OBJ), here, wanted_memory);
  check_h5(H5Tinsert(type.id(), "dimension", HOFFSET(Entry, axis), H5T_STD_I32LE), here, wanted_memory);
  write_raw_attribute(scale, "REFERENCE_LIST", {{}, type.id(), entries.data(), entries.size()});
}

void H5Writer::write_raw(const Dataset& dataset, const std::vector<std::int64_t>& shape, const Raw& memory)
{
  check(shape.size() == dataset.dimensions.size(), "a dataset's shape must have one size per dimension");
  check(memory.size == count_of(shape), "the number of values must match the dataset's shape");
  const H5Location here = place(dataset.path);
  const bool is_text = memory.kind == ValueKind::text;
  const H5Handle creation = own_h5(H5Pcreate(H5P_DATASET_CREATE), here, wanted_memory);
  disable_times_and_order_attributes(creation.id(), here);
  const std::size_t element_bytes = H5Tget_size(memory.type);
  if (!is_text && memory.size * element_bytes >= smallest_compressed_bytes) {
    compress(creation.id(), shape, element_bytes, here);
  }
  if (may_be_nan(dataset, memory.kind)) {
    check_h5(H5Pset_fill_value(creation.id(), H5T_NATIVE_DOUBLE, &the_nan), here, wanted_memory);
  }
  {
    const H5Handle space = extent(shape, here);
    const H5Handle made =
        own_h5(H5Dcreate2(file_.id(), dataset.path.c_str(), is_text ? memory.type : file_type(memory.kind),
                          space.id(), H5P_DEFAULT, creation.id(), H5P_DEFAULT),
               here, wanted_memory);
    if (memory.size > 0) {
      check_h5(H5Dwrite(made.id(), memory.type, H5S_ALL, H5S_ALL, H5P_DEFAULT, memory.data), here,
               wanted_memory);
    }
  }
  if (dataset.dimensions.size() == 1 && dataset.dimensions[0] == dataset.path) {
    make_scale(dataset.path, last_name(dataset.path));
  } else if (!dataset.dimensions.empty()) {
    attach_scales(dataset);
  }
  if (*dataset.units.name) write_attribute(dataset.path, "units", std::string(dataset.units.name));
  write_attribute(dataset.path, "long_name", std::string(dataset.long_name));
  if (may_be_nan(dataset, memory.kind))
    write_attribute(dataset.path, "_FillValue", std::span<const double>(&the_nan, 1));
  if (dataset.flags() != FlagSet::none) {
    const FlagTable table = flag_table(dataset.flags());
    write_attribute(dataset.path, "flag_values", std::span<const std::int8_t>(table.values));
    write_attribute(dataset.path, "flag_meanings", table.meanings);
  }
}

void H5Writer::write_values(const Dataset& dataset, const std::vector<std::int64_t>& shape,
                            const Values& values)
{
  if (values.kind != ValueKind::float64) {
    write_raw(dataset, shape, {values.kind, native_type(values.kind), values.data, values.size});
    return;
  }
  const auto* first = static_cast<const double*>(values.data);
  std::vector<double> plain(first, first + values.size);
  std::replace_if(
      plain.begin(), plain.end(), [](double value) { return std::isnan(value); }, the_nan);
  write_raw(dataset, shape, {values.kind, native_type(values.kind), plain.data(), plain.size()});
}

void H5Writer::write(const Dataset& dataset, const std::vector<std::int64_t>& shape,
                     std::span<const std::string> values)
{
  std::vector<const char*> texts;
  for (const std::string& value : values) {
    check(value.find('\0') == std::string::npos, "a text of the motion model must not contain a zero byte");
    texts.push_back(value.c_str());
  }
  const H5Handle type = text_type(place(dataset.path));
  write_raw(dataset, shape, {ValueKind::text, type.id(), texts.data(), texts.size()});
}

void H5Writer::write_raw_attribute(const std::string& object, const std::string& name, const Raw& memory)
{
  const H5Location here = place(object + "@" + name);
  const H5Handle owner = open(object);
  const H5Handle space = extent({static_cast<std::int64_t>(memory.size)}, here);
  const H5Handle attribute =
      own_h5(H5Acreate2(owner.id(), name.c_str(), memory.type, space.id(), H5P_DEFAULT, H5P_DEFAULT), here,
             wanted_memory);
  check_h5(H5Awrite(attribute.id(), memory.type, memory.data), here, wanted_memory);
}

void H5Writer::write_attribute(const std::string& object, const std::string& name, const std::string& value)
{
  check(value.find('\0') == std::string::npos, "a text of the motion model must not contain a zero byte");
  const char* text = value.c_str();
  const H5Handle type = text_type(place(object));
  write_raw_attribute(object, name, {ValueKind::text, type.id(), &text, 1});
}

void H5Writer::write_number_attribute(const std::string& object, const std::string& name,
                                      const Values& values)
{
  write_raw_attribute(object, name, {values.kind, file_type(values.kind), values.data, values.size});
}

std::string H5Writer::bytes()
{
  for (const std::string& scale : scales_) {
    const auto found = users_.find(scale);
    if (found != users_.end()) write_reference_list(scale, found->second);
  }
  check_h5(H5Fflush(file_.id(), H5F_SCOPE_GLOBAL), place(""), wanted_memory);
  file_.reset();
  return bytes_of_file(memory_, file_name_);
}

}  // namespace vrda::store
