#include "store/h5_file.hpp"

#include <hdf5.h>
#include <hdf5_hl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <limits>
#include <memory>
#include <new>
#include <string_view>
#include <type_traits>

namespace vrda::store {
namespace {

static_assert(std::is_same_v<hid_t, H5Id>, "HDF5 1.10 identifiers are 64-bit integers");

herr_t keep_innermost(unsigned depth, const H5E_error2_t* error, void* reason)
{
  if (depth == 0 && error->desc != nullptr) *static_cast<std::string*>(reason) = error->desc;
  return 0;
}

}  // namespace

NumberTypes number_types(ValueKind kind)
{
  switch (kind) {
    case ValueKind::float64:
      return {H5T_NATIVE_DOUBLE, H5T_IEEE_F64LE};
    case ValueKind::float32:
      return {H5T_NATIVE_FLOAT, H5T_IEEE_F32LE};
    case ValueKind::int64:
      return {H5T_NATIVE_INT64, H5T_STD_I64LE};
    case ValueKind::int32:
      return {H5T_NATIVE_INT32, H5T_STD_I32LE};
    case ValueKind::int8:
      return {H5T_NATIVE_INT8, H5T_STD_I8LE};
    case ValueKind::text:
      break;
  }
  throw InternalError("text is not a number");
}

H5Handle& H5Handle::operator=(H5Handle&& other) noexcept
{
  std::swap(id_, other.id_);
  return *this;
}

void H5Handle::reset() noexcept
{
  if (id_ >= 0) H5Idec_ref(id_);
  id_ = -1;
}

H5Id H5Location::check(H5Id code) const
{
  if (code >= 0) return code;
  std::string reason = "no reason given";
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, keep_innermost, &reason);
  H5Eclear2(H5E_DEFAULT);
  throw InputError({file, object, "an HDF5 error (" + reason + ")", wanted});
}

void silence_h5()
{
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

namespace {

constexpr int deepest_nesting = 8;
/// A motion model has about a hundred objects.
constexpr std::size_t most_objects = 10000;
/// HDF5's look-up of a link by index takes time proportional to the number of links.
constexpr std::uint64_t most_links = 2000;
/// Enough to diagnose a file.
constexpr std::size_t most_refused = 100;
constexpr std::int64_t largest_attribute = 4096;
/// Per dataset; a job's text takes some kilobytes. Variable-length values may share the same bytes of the
/// file, so the file size is no bound.
constexpr std::size_t most_text_bytes = std::size_t{64} << 20;
/// zlib's maximum compression factor (zlib technical details, "Maximum Compression Factor").
constexpr std::uint64_t largest_deflate_ratio = 1032;

std::optional<ValueKind> kind_of(H5Id type)
{
  const H5T_class_t type_class = H5Tget_class(type);
  const std::size_t bytes = H5Tget_size(type);
  if (type_class == H5T_FLOAT && bytes == 8) return ValueKind::float64;
  if (type_class == H5T_FLOAT && bytes == 4) return ValueKind::float32;
  if (type_class == H5T_STRING && H5Tis_variable_str(type) > 0 && H5Tget_cset(type) == H5T_CSET_UTF8) {
    return ValueKind::text;
  }
  if (type_class != H5T_INTEGER || H5Tget_sign(type) != H5T_SGN_2) return std::nullopt;
  if (bytes == 8) return ValueKind::int64;
  if (bytes == 4) return ValueKind::int32;
  if (bytes == 1) return ValueKind::int8;
  return std::nullopt;
}

std::vector<std::int64_t> shape_of(H5Id space)
{
  if (H5Sget_simple_extent_type(space) == H5S_NULL) return {0};
  const int rank = H5Sget_simple_extent_ndims(space);
  if (rank <= 0) return {};
  std::vector<hsize_t> sizes(static_cast<std::size_t>(rank));
  H5Sget_simple_extent_dims(space, sizes.data(), nullptr);
  return {sizes.begin(), sizes.end()};
}

/// Number of elements; empty when it exceeds `limit`.
std::optional<std::uint64_t> count_within(const std::vector<std::int64_t>& shape, std::uint64_t limit)
{
  std::uint64_t count = 1;
  for (const std::int64_t size : shape) {
    if (size < 0) return std::nullopt;
    if (__builtin_mul_overflow(count, static_cast<std::uint64_t>(size), &count)) return std::nullopt;
  }
  if (count > limit) return std::nullopt;
  return count;
}

/// Memory of the texts that HDF5 reads. Released on destruction, also after a failed read.
class TextMemory {
 public:
  /// For H5Pset_vlen_mem_manager: null when the limit is reached.
  static void* allocate(std::size_t size, void* memory)
  {
    return static_cast<TextMemory*>(memory)->allocate(size);
  }
  static void release(void*, void*) {}

 private:
  void* allocate(std::size_t size)
  {
    if (size > left_) return nullptr;
    try {
      blocks_.push_back(std::make_unique<char[]>(size));
    } catch (const std::bad_alloc&) {
      return nullptr;
    }
    left_ -= size;
    return blocks_.back().get();
  }

  std::size_t left_ = most_text_bytes;
  std::vector<std::unique_ptr<char[]>> blocks_;
};

/// Copies the texts, checked for UTF-8 and control characters; the caller keeps ownership of `texts`.
std::vector<std::string> copies(const std::vector<char*>& texts, const H5Location& place)
{
  std::vector<std::string> result;
  result.reserve(texts.size());
  for (const char* text : texts) {
    result.emplace_back(text == nullptr ? "" : text);
    if (!is_utf8(result.back()))
      throw InputError({place.file, place.object, "\"" + result.back() + "\"", "text in UTF-8"});
    if (has_control_characters(result.back(), "\t\n\r"))
      throw InputError(
          {place.file, place.object, "control characters in a text", "text without control characters"});
  }
  return result;
}

/// The first filter that a motion model does not use; empty if none exists.
std::string filter_problem(H5Id creation)
{
  const int n_filters = H5Pget_nfilters(creation);
  for (int i = 0; i < n_filters; ++i) {
    unsigned flags = 0;
    std::size_t n_values = 0;
    unsigned config = 0;
    const H5Z_filter_t filter =
        H5Pget_filter2(creation, static_cast<unsigned>(i), &flags, &n_values, nullptr, 0, nullptr, &config);
    if (filter != H5Z_FILTER_DEFLATE && filter != H5Z_FILTER_SHUFFLE && filter != H5Z_FILTER_FLETCHER32) {
      return "filter number " + std::to_string(filter);
    }
  }
  return {};
}

/// Description of storage outside this file; empty if the values are in this file.
std::string storage_elsewhere(H5Id creation)
{
  if (H5Pget_external_count(creation) != 0) return "values stored in another file";
  const H5D_layout_t layout = H5Pget_layout(creation);
  const bool is_here = layout == H5D_CHUNKED || layout == H5D_CONTIGUOUS || layout == H5D_COMPACT;
  return is_here ? "" : "a virtual dataset";
}

bool has_chunks_within(H5Id creation, const std::vector<std::int64_t>& shape)
{
  std::vector<hsize_t> chunk(shape.size());
  const int rank = H5Pget_chunk(creation, static_cast<int>(chunk.size()), chunk.data());
  if (rank != static_cast<int>(shape.size())) return false;
  for (std::size_t axis = 0; axis < shape.size(); ++axis) {
    if (chunk[axis] > static_cast<hsize_t>(std::max<std::int64_t>(shape[axis], 1))) return false;
  }
  return true;
}

/// Stops the iteration, by returning 1, at the scale with the address `wanted`.
herr_t has_address(hid_t, unsigned, hid_t scale, void* wanted)
{
  H5O_info_t info = {};
  if (H5Oget_info2(scale, &info, H5O_INFO_BASIC) < 0) return -1;
  return info.addr == *static_cast<const haddr_t*>(wanted) ? 1 : 0;
}

}  // namespace

H5Reader::H5Reader(const Hdf5Content& content) : file_name_(content.file), file_bytes_(content.bytes.size())
{
  silence_h5();
  // For an unknown filter HDF5 would search for a plugin library to load.
  place("").check(H5PLset_loading_state(0));
  const H5Handle access = place("").own(H5Pcreate(H5P_FILE_ACCESS));
  // HDF5 parses the bytes whose seal was checked, not a file.
  place("").check(H5Pset_fapl_core(access.id(), content.bytes.size(), false));
  // HDF5 copies the bytes and does not change them.
  place("").check(
      H5Pset_file_image(access.id(), const_cast<char*>(content.bytes.data()), content.bytes.size()));
  // Every dataset is read once and whole, so no chunk cache, which would last as long as the dataset is open.
  place("").check(H5Pset_cache(access.id(), 0, 0, 0, 0.0));
  // HDF5 requires a name and identifies open files by it: unique, and not the name of a real file.
  const std::string name = "/dev/null/" + content.file;
  file_ = place("").own(H5Fopen(name.c_str(), H5F_ACC_RDONLY, access.id()));
  objects_["/"] = ObjectKind::group;
  walk("/", 0);
}

H5Handle H5Reader::open(const std::string& object) const
{
  return place(object).own(H5Oopen(file_.id(), object.c_str(), H5P_DEFAULT));
}

H5Id H5Reader::kept_open(const std::string& object) const
{
  const auto found = open_.find(object);
  if (found != open_.end()) return found->second.id();
  return open_.emplace(object, open(object)).first->second.id();
}

bool H5Reader::is_full() const
{
  return objects_.size() >= most_objects || refused_.size() >= most_refused;
}

void H5Reader::walk(const std::string& group, int depth)
{
  const H5Handle here = open(group);
  H5G_info_t info = {};
  place(group).check(H5Gget_info(here.id(), &info));
  if (info.nlinks > most_links) {
    refused_.push_back(
        {group, std::to_string(info.nlinks) + " links in a group", "at most " + std::to_string(most_links)});
    return;
  }
  for (hsize_t i = 0; i < info.nlinks && !is_full(); ++i) {
    char name[256];
    const H5Id length = place(group).check(
        H5Lget_name_by_idx(here.id(), ".", H5_INDEX_NAME, H5_ITER_INC, i, name, sizeof name, H5P_DEFAULT));
    const std::string path = (group == "/" ? "/" : group + "/") + name;
    if (static_cast<std::size_t>(length) >= sizeof name) {
      refused_.push_back({path, "a name of " + std::to_string(length) + " bytes", "at most 255"});
      continue;
    }
    add_link(here.id(), path, depth + 1);
  }
}

void H5Reader::add_link(H5Id group, const std::string& path, int depth)
{
  H5L_info_t link = {};
  const std::string name = path.substr(path.rfind('/') + 1);
  place(path).check(H5Lget_info(group, name.c_str(), &link, H5P_DEFAULT));
  if (link.type == H5L_TYPE_HARD) {
    add_object(path, depth);
    return;
  }
  refused_.push_back({path, link.type == H5L_TYPE_EXTERNAL ? "a link into another file" : "a symbolic link",
                      "the object itself"});
}

void H5Reader::add_object(const std::string& path, int depth)
{
  H5O_info_t info = {};
  place(path).check(H5Oget_info_by_name2(file_.id(), path.c_str(), &info, H5O_INFO_BASIC, H5P_DEFAULT));
  if (info.type == H5O_TYPE_DATASET) {
    objects_[path] = ObjectKind::dataset;
  } else if (info.type != H5O_TYPE_GROUP) {
    refused_.push_back({path, "neither a group nor a dataset", "a group or a dataset"});
  } else if (depth > deepest_nesting) {
    refused_.push_back(
        {path, "groups nested more than " + std::to_string(deepest_nesting) + " deep", "fewer"});
  } else {
    objects_[path] = ObjectKind::group;
    walk(path, depth);
  }
  if (objects_.size() == most_objects) {
    refused_.push_back({"/", "more than " + std::to_string(most_objects) + " objects", "fewer"});
  }
}

bool H5Reader::is_group(const std::string& path) const
{
  const auto found = objects_.find(path);
  return found != objects_.end() && found->second == ObjectKind::group;
}

bool H5Reader::is_dataset(const std::string& path) const
{
  const auto found = objects_.find(path);
  return found != objects_.end() && found->second == ObjectKind::dataset;
}

DatasetInfo H5Reader::dataset_info(const std::string& dataset) const
{
  const H5Id object = kept_open(dataset);
  const H5Handle creation = place(dataset).own(H5Dget_create_plist(object));
  const H5Handle type = place(dataset).own(H5Dget_type(object));
  DatasetInfo facts;
  facts.kind = kind_of(type.id());
  // Checked first: for the shape of a virtual dataset, HDF5 opens its source files.
  facts.external_storage = storage_elsewhere(creation.id());
  if (!facts.external_storage.empty()) return facts;
  const H5Handle space = place(dataset).own(H5Dget_space(object));
  facts.shape = shape_of(space.id());
  if (H5DSis_scale(object) > 0) {
    char name[256] = {};
    if (H5DSget_scale_name(object, name, sizeof name) > 0) facts.scale_name = name;
  }
  facts.storage_problem = storage_problem({object, creation.id(), type.id()}, facts);
  H5Eclear2(H5E_DEFAULT);
  return facts;
}

std::string H5Reader::storage_problem(const DatasetIds& ids, const DatasetInfo& facts) const
{
  std::string filter = filter_problem(ids.creation);
  if (!filter.empty()) return filter;

  const bool is_chunked = H5Pget_layout(ids.creation) == H5D_CHUNKED;
  const std::uint64_t element_bytes = std::max<std::uint64_t>(1, H5Tget_size(ids.type));
  const std::uint64_t stored = H5Dget_storage_size(ids.dataset);
  const std::uint64_t factor = is_chunked ? largest_deflate_ratio : 1;
  if (stored > file_bytes_) return std::to_string(stored) + " bytes of values, more than the file has";
  if (!count_within(facts.shape, stored * factor / element_bytes)) {
    return "a shape too large for the " + std::to_string(stored) + " bytes stored";
  }
  if (is_chunked && !has_chunks_within(ids.creation, facts.shape)) return "chunks larger than the dataset";
  return {};
}

bool H5Reader::is_attached(const std::string& dataset, std::size_t axis, const std::string& scale) const
{
  if (!is_dataset(scale)) return false;
  const H5Id object = kept_open(dataset);
  H5O_info_t info = {};
  place(scale).check(H5Oget_info2(kept_open(scale), &info, H5O_INFO_BASIC));
  // Not H5DSis_attached, which fails for all datasets of the scale's REFERENCE_LIST when one is missing.
  const bool attached =
      H5DSiterate_scales(object, static_cast<unsigned>(axis), nullptr, has_address, &info.addr) > 0;
  H5Eclear2(H5E_DEFAULT);
  return attached;
}

std::optional<AttributeValue> H5Reader::attribute(const std::string& object, const std::string& name) const
{
  const H5Location here = place(object + "@" + name);
  const H5Id owner = kept_open(object);
  if (here.check(H5Aexists(owner, name.c_str())) == 0) return std::nullopt;
  const H5Handle attribute = here.own(H5Aopen(owner, name.c_str(), H5P_DEFAULT));
  const H5Handle type = here.own(H5Aget_type(attribute.id()));
  const H5Handle space = here.own(H5Aget_space(attribute.id()));
  const std::vector<std::int64_t> shape = shape_of(space.id());
  AttributeValue value;
  if (shape.size() != 1 || shape[0] > largest_attribute) return value;
  value.kind = kind_of(type.id());
  // No attribute of these formats has several texts; reading them here would have no memory bound.
  if (value.kind == ValueKind::text && shape[0] > 1) value.kind.reset();
  if (!value.kind) return value;
  const std::size_t size = static_cast<std::size_t>(shape[0]);
  if (size == 0) return value;
  if (*value.kind == ValueKind::text) {
    std::vector<char*> texts(size, nullptr);
    here.check(H5Aread(attribute.id(), type.id(), texts.data()));
    value.texts = copies(texts, here);
    H5Dvlen_reclaim(type.id(), space.id(), H5P_DEFAULT, texts.data());
  } else {
    value.numbers.resize(size);
    here.check(H5Aread(attribute.id(), H5T_NATIVE_DOUBLE, value.numbers.data()));
  }
  return value;
}

void H5Reader::read_raw(const std::string& dataset, H5Id memory_type, std::size_t size, void* values,
                        H5Id transfer) const
{
  const H5Id object = kept_open(dataset);
  const H5Handle space = place(dataset).own(H5Dget_space(object));
  const std::optional<std::uint64_t> count = count_within(shape_of(space.id()), size);
  check(count.has_value() && *count == size, "a dataset is read only when its shape is known");
  if (size == 0) return;
  place(dataset).check(H5Dread(object, memory_type, H5S_ALL, H5S_ALL, transfer, values));
}

void H5Reader::read_values(const std::string& dataset, ValueKind kind, std::size_t size, void* values) const
{
  read_raw(dataset, number_types(kind).memory, size, values, H5P_DEFAULT);
}

void H5Reader::read(const std::string& dataset, std::span<std::string> values) const
{
  if (values.empty()) return;
  const H5Id object = kept_open(dataset);
  const H5Handle type = place(dataset).own(H5Dget_type(object));
  const H5Handle transfer = place(dataset).own(H5Pcreate(H5P_DATASET_XFER));
  TextMemory memory;
  place(dataset).check(
      H5Pset_vlen_mem_manager(transfer.id(), TextMemory::allocate, &memory, TextMemory::release, &memory));
  std::vector<char*> texts(values.size(), nullptr);
  read_raw(dataset, type.id(), texts.size(), texts.data(), transfer.id());
  std::vector<std::string> taken = copies(texts, place(dataset));
  std::move(taken.begin(), taken.end(), values.begin());
}

namespace {

/// Smaller datasets stay contiguous: a chunk index alone takes about this many bytes.
constexpr std::size_t smallest_compressed_bytes = 4096;
/// Chunks of at most this size fit the reader's cache (1 MiB by default).
constexpr std::size_t largest_chunk_bytes = std::size_t{1} << 20;
/// Two thirds of the time of zlib's default, for files 1 % larger.
constexpr unsigned deflate_level = 4;

H5Handle text_type(const H5Location& place)
{
  H5Handle type = place.own(H5Tcopy(H5T_C_S1));
  place.check(H5Tset_size(type.id(), H5T_VARIABLE));
  place.check(H5Tset_cset(type.id(), H5T_CSET_UTF8));
  return type;
}

H5Handle extent(const std::vector<std::int64_t>& shape, const H5Location& place)
{
  if (shape.empty()) return place.own(H5Screate(H5S_SCALAR));
  const std::vector<hsize_t> sizes(shape.begin(), shape.end());
  return place.own(H5Screate_simple(static_cast<int>(sizes.size()), sizes.data(), nullptr));
}

void disable_times_and_order_attributes(H5Id properties, const H5Location& place)
{
  place.check(H5Pset_obj_track_times(properties, false));
  place.check(H5Pset_attr_creation_order(properties, H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED));
}

void order_links(H5Id properties, const H5Location& place)
{
  place.check(H5Pset_link_creation_order(properties, H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED));
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
  place.check(H5Pset_chunk(properties, static_cast<int>(chunk.size()), chunk.data()));
  place.check(H5Pset_shuffle(properties));
  place.check(H5Pset_deflate(properties, deflate_level));
  place.check(H5Pset_fletcher32(properties));
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
  const H5Handle access = place("").own(H5Pcreate(H5P_FILE_ACCESS));
  // The default driver resolves the real path of a link, which an unnamed file does not have.
  place("").check(H5Pset_fapl_stdio(access.id()));
  // Of this process alone, so HDF5 needs no lock, which some systems do not have.
  place("").check(H5Pset_file_locking(access.id(), false, true));
  place("").check(H5Pset_libver_bounds(access.id(), H5F_LIBVER_V18, H5F_LIBVER_V18));
  const H5Handle creation = place("").own(H5Pcreate(H5P_FILE_CREATE));
  disable_times_and_order_attributes(creation.id(), place(""));
  order_links(creation.id(), place(""));
  const std::string name = "/proc/self/fd/" + std::to_string(memory_);
  file_ = place("").own(H5Fcreate(name.c_str(), H5F_ACC_TRUNC, creation.id(), access.id()));
}

H5Writer::~H5Writer()
{
  file_.reset();
  ::close(memory_);
}

H5Handle H5Writer::open(const std::string& object) const
{
  return place(object).own(H5Oopen(file_.id(), object.c_str(), H5P_DEFAULT));
}

void H5Writer::create_group(const std::string& path)
{
  const H5Handle creation = place(path).own(H5Pcreate(H5P_GROUP_CREATE));
  disable_times_and_order_attributes(creation.id(), place(path));
  order_links(creation.id(), place(path));
  place(path).own(H5Gcreate2(file_.id(), path.c_str(), H5P_DEFAULT, creation.id(), H5P_DEFAULT));
}

void H5Writer::create_dimension(const std::string& path, std::int64_t size)
{
  const H5Location here = place(path);
  {
    const H5Handle creation = here.own(H5Pcreate(H5P_DATASET_CREATE));
    disable_times_and_order_attributes(creation.id(), here);
    const H5Handle space = extent({size}, here);
    here.own(H5Dcreate2(file_.id(), path.c_str(), H5T_IEEE_F32BE, space.id(), H5P_DEFAULT, creation.id(),
                        H5P_DEFAULT));
  }
  // Name by which the netCDF library recognises a dimension without a variable.
  char name[80];
  std::snprintf(name, sizeof name, "This is a netCDF dimension but not a netCDF variable.%10lld",
                static_cast<long long>(size));
  make_scale(path, name);
}

void H5Writer::link(const std::string& target, const std::string& path)
{
  place(path).check(
      H5Lcreate_hard(file_.id(), target.c_str(), file_.id(), path.c_str(), H5P_DEFAULT, H5P_DEFAULT));
}

void H5Writer::make_scale(const std::string& path, const std::string& name)
{
  const H5Handle object = open(path);
  place(path).check(H5DSset_scale(object.id(), name.c_str()));
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
    here.check(H5Rcreate(&references[axis], file_.id(), scale.c_str(), H5R_OBJECT, -1));
    lists[axis] = {1, &references[axis]};
    users_[scale].push_back({dataset.path, static_cast<std::int32_t>(axis)});
  }
  const H5Handle type = here.own(H5Tvlen_create(H5T_STD_REF_OBJ));
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
    here.check(H5Rcreate(&entry.dataset, file_.id(), use.dataset.c_str(), H5R_OBJECT, -1));
    entries.push_back(entry);
  }
  const H5Handle type = here.own(H5Tcreate(H5T_COMPOUND, sizeof(Entry)));
  here.check(H5Tinsert(type.id(), "dataset", HOFFSET(Entry, dataset), H5T_STD_REF_OBJ));
  here.check(H5Tinsert(type.id(), "dimension", HOFFSET(Entry, axis), H5T_STD_I32LE));
  write_raw_attribute(scale, "REFERENCE_LIST", {{}, type.id(), entries.data(), entries.size()});
}

void H5Writer::write_raw(const Dataset& dataset, const std::vector<std::int64_t>& shape, const Raw& memory)
{
  check(shape.size() == dataset.dimensions.size(), "a dataset's shape must have one size per dimension");
  check(memory.size == count_of(shape), "the number of values must match the dataset's shape");
  const H5Location here = place(dataset.path);
  const bool is_text = memory.kind == ValueKind::text;
  const H5Handle creation = here.own(H5Pcreate(H5P_DATASET_CREATE));
  disable_times_and_order_attributes(creation.id(), here);
  const std::size_t element_bytes = H5Tget_size(memory.type);
  if (!is_text && memory.size * element_bytes >= smallest_compressed_bytes) {
    compress(creation.id(), shape, element_bytes, here);
  }
  if (may_be_nan(dataset, memory.kind)) {
    here.check(H5Pset_fill_value(creation.id(), H5T_NATIVE_DOUBLE, &the_nan));
  }
  {
    const H5Handle space = extent(shape, here);
    const H5Handle made = here.own(H5Dcreate2(file_.id(), dataset.path.c_str(),
                                              is_text ? memory.type : number_types(memory.kind).file,
                                              space.id(), H5P_DEFAULT, creation.id(), H5P_DEFAULT));
    if (memory.size > 0) {
      here.check(H5Dwrite(made.id(), memory.type, H5S_ALL, H5S_ALL, H5P_DEFAULT, memory.data));
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
  const H5Id type = number_types(values.kind).memory;
  if (values.kind != ValueKind::float64)
    return write_raw(dataset, shape, {values.kind, type, values.data, values.size});
  const auto* first = static_cast<const double*>(values.data);
  std::vector<double> plain(first, first + values.size);
  std::replace_if(
      plain.begin(), plain.end(), [](double value) { return std::isnan(value); }, the_nan);
  write_raw(dataset, shape, {values.kind, type, plain.data(), plain.size()});
}

void H5Writer::write(const Dataset& dataset, const std::vector<std::int64_t>& shape,
                     std::span<std::string> values)
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
      here.own(H5Acreate2(owner.id(), name.c_str(), memory.type, space.id(), H5P_DEFAULT, H5P_DEFAULT));
  here.check(H5Awrite(attribute.id(), memory.type, memory.data));
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
  write_raw_attribute(object, name, {values.kind, number_types(values.kind).file, values.data, values.size});
}

std::string H5Writer::bytes()
{
  for (const std::string& scale : scales_) {
    const auto found = users_.find(scale);
    if (found != users_.end()) write_reference_list(scale, found->second);
  }
  place("").check(H5Fflush(file_.id(), H5F_SCOPE_GLOBAL));
  file_.reset();
  return bytes_of_file(memory_, file_name_);
}

void Hdf5WriteVisitor::visit_attribute(const std::string& object, const std::string& name, Attribute value,
                                       const Unit&)
{
  if (pass_ != (object == "/" ? Pass::root_attributes : Pass::attributes)) return;
  const auto write = [this, object, name](const auto& one) {
    using Value = std::decay_t<decltype(one)>;
    if constexpr (std::is_same_v<Value, std::string>) {
      writer_.write_attribute(object, name, one);
    } else if constexpr (std::is_same_v<Value, bool>) {
      const std::int8_t code = one ? 1 : 0;
      writer_.write_attribute(object, name, std::span<const std::int8_t>(&code, 1));
    } else if constexpr (std::is_same_v<Value, Eigen::Vector3d>) {
      writer_.write_attribute(object, name, std::span<const double>(one.data(), 3));
    } else {
      writer_.write_attribute(object, name, std::span<const Value>(&one, 1));
    }
  };
  std::visit(
      [&](const auto* one) {
        if (object == "/") return write(*one);
        later_.push_back({object, [write, copy = *one] { write(copy); }});
      },
      value);
}

void Hdf5WriteVisitor::visit_dataset(const Dataset& dataset, Member member)
{
  if (pass_ != Pass::datasets) return;
  const std::vector<std::int64_t> shape = shape_of(dataset);
  for (std::size_t axis = 0; axis < shape.size(); ++axis) {
    const std::string& dimension = dataset.dimensions[axis];
    const bool is_new = existing_.insert(dimension).second;
    if (is_new && dimension != dataset.path) writer_.create_dimension(dimension, shape[axis]);
  }
  with_values(member, [&](auto values) { writer_.write(dataset, shape, values); });
  note_coordinates(dataset);
}

// A group with tables over the grid gets links to its coordinate variables: readers of one group look there.
void Hdf5WriteVisitor::note_coordinates(const Dataset& dataset)
{
  existing_.insert(dataset.path);
  const std::string group = dataset.path.substr(0, dataset.path.rfind('/'));
  for (const char* axis : {"/flexion", "/varus"}) {
    if (!group.empty() && std::ranges::find(dataset.dimensions, axis) != dataset.dimensions.end())
      links_.emplace(group + axis, axis);
  }
}

void Hdf5WriteVisitor::finish()
{
  const auto rank = [](const std::string& object) {
    constexpr const char* first[] = {"/bodies", "/push", "/equilibrium", "/ligaments", "/smoothed"};
    return std::ranges::find_if(first, [&](const char* group) { return object.starts_with(group); }) - first;
  };
  std::ranges::stable_sort(later_,
                           [&](const auto& a, const auto& b) { return rank(a.first) < rank(b.first); });
  for (const auto& [object, write] : later_) write();
  for (const auto& [link, target] : links_)
    if (existing_.count(link) == 0) writer_.link(target, link);
}

void write_format(H5Writer& writer, const FormatName& format)
{
  writer.write_attribute("/", "format", std::string(format.name));
  writer.write_attribute("/", "format_version", std::string(format.version));
  writer.write_attribute("/", "Conventions", std::string(conventions));
}

void Hdf5ReadVisitor::dimension(const std::string& path, const DimensionSize& count)
{
  const auto found = std::ranges::find(counted_, path, &Sizes::value_type::first);
  RegistryVisitor::dimension(path, found == counted_.end() ? count : DimensionSize::fixed(found->second));
}

}  // namespace vrda::store
