/// Reader of one untrusted HDF5 file: metadata first, values once the metadata has been checked.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "store/dataset.hpp"
#include "store/h5_handle.hpp"
#include "store/seal.hpp"

namespace vrda::store {

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

  H5Location place(const std::string& object) const { return {file_name_, object}; }
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

}  // namespace vrda::store
