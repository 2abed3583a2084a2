/// HDF5 handles (RAII) and a check of return codes; reader and writer of one file, and the registry's
/// visitors for both. No header includes hdf5.h, hence the integer.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/text.hpp"
#include "store/dataset.hpp"
#include "store/read_separately.hpp"
#include "store/registry.hpp"

namespace vrda::store {

using H5Id = std::int64_t;

/// What writing a file in memory needs.
inline constexpr const char* wanted_memory = "sufficient memory";

/// Owns one HDF5 identifier of any kind and releases it on destruction.
class H5Handle {
 public:
  H5Handle() = default;
  explicit H5Handle(H5Id id) : id_(id) {}
  H5Handle(H5Handle&& other) noexcept : id_(other.id_) { other.id_ = -1; }
  H5Handle& operator=(H5Handle&& other) noexcept;
  ~H5Handle() { reset(); }

  H5Id id() const { return id_; }
  void reset() noexcept;

 private:
  H5Id id_ = -1;
};

/// Where a call of HDF5 works, and what it needs there: file, field and wanted of its InputError.
struct H5Location {
  const std::string& file;
  std::string object;  ///< path inside the file; may be empty
  const char* wanted;

  /// Returns `code` when it is not negative; otherwise throws InputError with HDF5's error text.
  H5Id check(H5Id code) const;
  /// The same for calls that return an identifier to own.
  H5Handle own(H5Id id) const { return H5Handle(check(id)); }
};

/// HDF5's types of a kind of numbers, in memory and in files.
struct NumberTypes {
  H5Id memory, file;
};
NumberTypes number_types(ValueKind kind);

/// Disables HDF5's printing of its error stack; H5Location::check reports errors.
void silence_h5();

// Reader of one untrusted HDF5 file: metadata first, values once the metadata has been checked.

enum class ObjectKind { group, dataset };

struct DatasetInfo {
  std::optional<ValueKind> kind;  ///< empty: a type that motion models do not use
  std::string external_storage;  ///< description of storage outside this file; if not empty, no shape is read
  std::vector<std::int64_t> shape;
  std::string scale_name;       ///< of a dimension scale; empty otherwise
  std::string storage_problem;  ///< why its values must not be read; empty: no problem
};

/// A one-dimensional attribute. Integers are stored as doubles, exact up to 32 bits.
struct AttributeValue {
  std::optional<ValueKind> kind;  ///< empty: another type or rank, or too large; then no values
  std::vector<double> numbers;
  std::vector<std::string> texts;
};

class H5Reader {
 public:
  /// Throws InputError naming the file when HDF5 cannot open its content. Disables HDF5's plugin loading in
  /// this process.
  explicit H5Reader(const Hdf5Content& content);

  const std::string& file_name() const { return file_name_; }
  /// Every group and dataset by its path, including "/".
  const std::map<std::string, ObjectKind>& objects() const { return objects_; }
  bool is_group(const std::string& path) const;
  bool is_dataset(const std::string& path) const;
  /// Links out of the file, too deep nesting, and other objects that were rejected while listing the file.
  const std::vector<Finding>& rejected() const { return refused_; }

  DatasetInfo dataset_info(const std::string& dataset) const;
  bool is_attached(const std::string& dataset, std::size_t axis, const std::string& scale) const;
  std::optional<AttributeValue> attribute(const std::string& object, const std::string& name) const;

  /// Fill `values`, whose size must be that of the dataset. Throw InputError naming file and dataset.
  template <typename Number>
  void read(const std::string& dataset, std::span<Number> values) const
  {
    read_values(dataset, value_kind<Number>(), values.size(), values.data());
  }
  void read(const std::string& dataset, std::span<std::string> values) const;

 private:
  struct DatasetIds {
    H5Id dataset, creation, type;
  };

  H5Location place(const std::string& object) const { return {file_name_, object, intact_file}; }
  H5Handle open(const std::string& object) const;
  /// Like open(), but the handle stays open: repeated opening took a third of the reading time.
  H5Id kept_open(const std::string& object) const;
  void walk(const std::string& group, int depth);
  void add_link(H5Id group, const std::string& path, int depth);
  void add_object(const std::string& path, int depth);
  bool is_full() const;
  std::string storage_problem(const DatasetIds& ids, const DatasetInfo& facts) const;
  void read_values(const std::string& dataset, ValueKind kind, std::size_t size, void* values) const;
  void read_raw(const std::string& dataset, H5Id memory_type, std::size_t size, void* values,
                H5Id transfer) const;

  std::string file_name_;
  std::uint64_t file_bytes_ = 0;
  H5Handle file_;
  std::map<std::string, ObjectKind> objects_;
  std::vector<Finding> refused_;
  mutable std::map<std::string, H5Handle> open_;  ///< declared after file_, so closed before it
};

// Writer of one HDF5 file that is also a netCDF-4 file. Equal calls give equal bytes.

/// The file is built in memory, since HDF5 1.10 fails badly on a full disk.
/// Every member throws InputError naming the file and the object when memory runs out.
/// Objects have no times and keep the order of creation; the format is that of HDF5 1.8, which MATLAB
/// and the netCDF library read.
class H5Writer {
 public:
  /// `path` is the file name used in messages; no file is created.
  explicit H5Writer(const std::string& path);
  ~H5Writer();
  H5Writer(const H5Writer&) = delete;
  H5Writer& operator=(const H5Writer&) = delete;

  void create_group(const std::string& path);
  /// A dimension without a coordinate variable, as the netCDF library writes it.
  void create_dimension(const std::string& path, std::int64_t size);
  /// A hard link `path` to the existing object `target`.
  void link(const std::string& target, const std::string& path);

  /// Write a dataset with its attributes; `shape` has one size per dimension, whose scales must exist. A
  /// dataset that is its own dimension becomes a scale. NaNs are written with one bit pattern.
  template <typename Number>
  void write(const Dataset& dataset, const std::vector<std::int64_t>& shape, std::span<const Number> values)
  {
    write_values(dataset, shape, {value_kind<Number>(), values.data(), values.size()});
  }
  void write(const Dataset& dataset, const std::vector<std::int64_t>& shape,
             std::span<const std::string> values);

  /// One-dimensional attributes of a group or dataset.
  void write_attribute(const std::string& object, const std::string& name, const std::string& value);
  template <typename Number>
  void write_attribute(const std::string& object, const std::string& name, std::span<const Number> values)
  {
    write_number_attribute(object, name, {value_kind<Number>(), values.data(), values.size()});
  }

  /// Completes the dimension scales and returns the file's bytes. No other member may be called afterwards.
  std::string bytes();

 private:
  struct Use {
    std::string dataset;
    std::int32_t axis = 0;
  };
  struct Values {
    ValueKind kind;
    const void* data;
    std::size_t size;
  };
  struct Raw {
    ValueKind kind = {};
    H5Id type = -1;
    const void* data = nullptr;
    std::size_t size = 0;
  };

  H5Location place(const std::string& object) const { return {file_name_, object, wanted_memory}; }
  H5Handle open(const std::string& object) const;
  void write_values(const Dataset& dataset, const std::vector<std::int64_t>& shape, const Values& values);
  void write_number_attribute(const std::string& object, const std::string& name, const Values& values);
  void write_raw(const Dataset& dataset, const std::vector<std::int64_t>& shape, const Raw& memory);
  void write_raw_attribute(const std::string& object, const std::string& name, const Raw& memory);
  void make_scale(const std::string& path, const std::string& name);
  void attach_scales(const Dataset& dataset);
  void write_reference_list(const std::string& scale, const std::vector<Use>& uses);

  std::string file_name_;
  int memory_;  ///< descriptor of the file in memory
  H5Handle file_;
  std::vector<std::string> scales_;                ///< in order of creation
  std::map<std::string, std::vector<Use>> users_;  ///< of each scale
};

// Registry visitors that write datasets and attributes to an HDF5 file and read them.

/// Writes one class of objects per visit: the bytes of an HDF5 file depend on the order of writing.
class Hdf5WriteVisitor : public RegistryVisitor {
 public:
  enum class Pass { root_attributes, groups, datasets, attributes };
  Hdf5WriteVisitor(H5Writer& writer, Pass sort) : writer_(writer), sort_(sort) {}

  void group(const std::string& path)
  {
    if (sort_ == Pass::groups) writer_.create_group(path);
  }

  template <typename Member>
  void attribute(const std::string& object, const std::string& name, const Member& member, const Unit&)
  {
    if (sort_ == Pass::root_attributes && object == "/") write(object, name, member);
    if (sort_ == Pass::attributes && object != "/")
      later_.push_back({object, [this, object, name, member] { write(object, name, member); }});
  }

  template <typename Value>
  void derived_attribute(const std::string& object, const std::string& name, const Value& value)
  {
    attribute(object, name, value, unit::none);
  }

  /// Writes a dataset, and the dimensions that it uses first.
  template <typename Member>
  void operator()(const Dataset& dataset, const Member& member)
  {
    if (sort_ != Pass::datasets) return;
    const std::vector<std::int64_t> shape = shape_of(dataset);
    for (std::size_t axis = 0; axis < shape.size(); ++axis) {
      const std::string& dimension = dataset.dimensions[axis];
      const bool is_new = existing_.insert(dimension).second;
      if (is_new && dimension != dataset.path) writer_.create_dimension(dimension, shape[axis]);
    }
    writer_.write(dataset, shape, values_of(member));
    note_coordinates(dataset);
  }

  /// Ends a visit: attributes of groups are written in a fixed order of version 1 of the format.
  void finish()
  {
    const auto rank = [](const std::string& object) {
      constexpr const char* first[] = {"/bodies", "/push", "/equilibrium", "/ligaments", "/smoothed"};
      const auto* found = std::find_if(std::begin(first), std::end(first),
                                       [&](const char* group) { return object.rfind(group, 0) == 0; });
      return found - std::begin(first);
    };
    std::stable_sort(later_.begin(), later_.end(),
                     [&](const auto& a, const auto& b) { return rank(a.first) < rank(b.first); });
    for (const auto& [object, write] : later_) write();
    for (const auto& [link, target] : links_)
      if (existing_.count(link) == 0) writer_.link(target, link);
  }

 private:
  // A group with tables over the grid gets links to its coordinate variables: readers of one group look
  // there.
  void note_coordinates(const Dataset& dataset)
  {
    existing_.insert(dataset.path);
    const std::string group = dataset.path.substr(0, dataset.path.rfind('/'));
    for (const char* axis : {"/flexion", "/varus"}) {
      const bool is_over =
          std::find(dataset.dimensions.begin(), dataset.dimensions.end(), axis) != dataset.dimensions.end();
      if (is_over && !group.empty()) links_.emplace(group + axis, axis);
    }
  }

  void write(const std::string& object, const std::string& name, const std::string& text)
  {
    writer_.write_attribute(object, name, text);
  }
  void write(const std::string& object, const std::string& name, bool flag)
  {
    const std::int8_t code = flag ? 1 : 0;
    writer_.write_attribute(object, name, std::span<const std::int8_t>(&code, 1));
  }
  void write(const std::string& object, const std::string& name, const Eigen::Vector3d& v)
  {
    writer_.write_attribute(object, name, std::span<const double>(v.data(), 3));
  }
  template <typename Number>
  void write(const std::string& object, const std::string& name, const Number& number)
  {
    writer_.write_attribute(object, name, std::span<const Number>(&number, 1));
  }

  H5Writer& writer_;
  Pass sort_;
  std::set<std::string> existing_;            ///< datasets and dimensions
  std::map<std::string, std::string> links_;  ///< link -> target
  std::vector<std::pair<std::string, std::function<void()>>> later_;
};

inline void write_format(H5Writer& writer, const char* name, const char* version)
{
  writer.write_attribute("/", "format", std::string(name));
  writer.write_attribute("/", "format_version", std::string(version));
  writer.write_attribute("/", "Conventions", std::string(conventions));
}

/// `visit(visitor)` visits the registry of the content to write.
template <typename Visit>
void write_hdf5(H5Writer& writer, const Visit& visit)
{
  using Sort = Hdf5WriteVisitor::Pass;
  for (const Sort sort : {Sort::root_attributes, Sort::groups, Sort::datasets, Sort::attributes}) {
    Hdf5WriteVisitor visitor(writer, sort);
    visit(visitor);
    visitor.finish();
  }
}

/// Reads the datasets of a file into the content returned by its structure check.
class Hdf5ReadVisitor : public RegistryVisitor {
 public:
  using Sizes = std::vector<std::pair<std::string, std::int64_t>>;
  Hdf5ReadVisitor(const H5Reader& reader, const Sizes& counted) : reader_(reader), counted_(counted) {}

  bool has(const std::string& path, bool) { return reader_.objects().count(path) > 0; }

  void dimension(const std::string& path, const DimensionSize& count)
  {
    const auto found = std::find_if(counted_.begin(), counted_.end(),
                                    [&](const auto& known) { return known.first == path; });
    RegistryVisitor::dimension(path, found == counted_.end() ? count : DimensionSize::fixed(found->second));
  }

  template <typename Member>
  void operator()(const Dataset& dataset, Member& member)
  {
    resize(member, shape_of(dataset));
    reader_.read(dataset.path, values_of(member));
  }

 private:
  const H5Reader& reader_;
  const Sizes& counted_;
};

}  // namespace vrda::store
