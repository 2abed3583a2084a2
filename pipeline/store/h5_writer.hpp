/// Writer of one HDF5 file that is also a netCDF-4 file. Equal calls give equal bytes.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "store/dataset.hpp"
#include "store/h5_handle.hpp"

namespace vrda::store {

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

  H5Location place(const std::string& object) const { return {file_name_, object}; }
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

}  // namespace vrda::store
