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
  void write(const Dataset& dataset, const std::vector<std::int64_t>& shape, std::span<Number> values)
  {
    write_values(dataset, shape, {value_kind<std::remove_const_t<Number>>(), values.data(), values.size()});
  }
  void write(const Dataset& dataset, const std::vector<std::int64_t>& shape, std::span<std::string> values);

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
  Hdf5WriteVisitor(H5Writer& writer, Pass pass) : writer_(writer), pass_(pass) {}

  void group(const std::string& path) override
  {
    if (pass_ == Pass::groups) writer_.create_group(path);
  }
  /// Ends a visit: attributes of groups are written in a fixed order of version 1 of the format.
  void finish();

 private:
  void visit_attribute(const std::string& object, const std::string& name, Attribute value,
                       const Unit&) override;
  void visit_derived(const std::string& object, const std::string& name, Attribute value) override
  {
    visit_attribute(object, name, value, unit::none);
  }
  /// Writes a dataset, and the dimensions that it uses first.
  void visit_dataset(const Dataset& dataset, Member member) override;
  void note_coordinates(const Dataset& dataset);

  H5Writer& writer_;
  Pass pass_;
  std::set<std::string> existing_;            ///< datasets and dimensions
  std::map<std::string, std::string> links_;  ///< link -> target
  std::vector<std::pair<std::string, std::function<void()>>> later_;
};

/// The bytes of a file with all rows of `content`, a motion model or a trace. `path` is for messages.
struct FormatName {
  const char *name, *version;
};
void write_format(H5Writer& writer, const FormatName& format);
template <typename Content>
std::string hdf5_bytes(const std::string& path, const FormatName& format, const Content& content)
{
  using Pass = Hdf5WriteVisitor::Pass;
  H5Writer writer(path);
  write_format(writer, format);
  for (const Pass pass : {Pass::root_attributes, Pass::groups, Pass::datasets, Pass::attributes}) {
    Hdf5WriteVisitor visitor(writer, pass);
    visit_registry(content, visitor);
    visitor.finish();
  }
  return writer.bytes();
}

/// Reads the datasets of a file into the content returned by its structure check.
class Hdf5ReadVisitor : public RegistryVisitor {
 public:
  using Sizes = std::vector<std::pair<std::string, std::int64_t>>;
  Hdf5ReadVisitor(const H5Reader& reader, const Sizes& counted) : reader_(reader), counted_(counted) {}

  bool may_change() const override { return true; }
  bool has(const std::string& path, bool) override { return reader_.objects().count(path) > 0; }
  void dimension(const std::string& path, const DimensionSize& count) override;

 private:
  void visit_dataset(const Dataset& dataset, Member member) override
  {
    const std::vector<std::int64_t> shape = shape_of(dataset);
    std::visit([&](auto* all) { resize(*all, shape); }, member);
    with_values(member, [&](auto values) { reader_.read(dataset.path, values); });
  }

  const H5Reader& reader_;
  const Sizes& counted_;
};

}  // namespace vrda::store
