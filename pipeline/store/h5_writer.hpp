/// Makes one HDF5 file in the manner of netCDF-4 and so that equal calls give equal bytes.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "store/dataset.hpp"
#include "store/h5_handle.hpp"

namespace vrda {

/// In memory: HDF5 1.10 loses its footing when a disk fills up under it, so that no disk is left to it.
/// Every member throws InputError naming the file and the object when memory runs out.
/// Objects carry no times and keep the order of creation; the format is that of HDF5 1.8, which MATLAB
/// and the netCDF library read.
class H5Writer {
 public:
  /// `path` is the file's name in messages; nothing is created there.
  explicit H5Writer(const std::string& path);
  ~H5Writer();
  H5Writer(const H5Writer&) = delete;
  H5Writer& operator=(const H5Writer&) = delete;

  void create_group(const std::string& path);
  /// A dimension without a coordinate variable, the way the netCDF library writes one.
  void create_dimension(const std::string& path, std::int64_t size);

  /// Write a dataset with its attributes; `shape` has one size for each of its dimensions, whose scales
  /// exist already. A dataset that is its own dimension becomes a scale. NaNs are written with one bit
  /// pattern.
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

  /// Ends the dimension scales and gives the file's bytes. Nothing else may be called afterwards.
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

  H5Place place(const std::string& object) const { return {file_name_, object}; }
  H5Handle open(const std::string& object) const;
  void write_values(const Dataset& dataset, const std::vector<std::int64_t>& shape, const Values& values);
  void write_number_attribute(const std::string& object, const std::string& name, const Values& values);
  void write_raw(const Dataset& dataset, const std::vector<std::int64_t>& shape, const Raw& memory);
  void write_raw_attribute(const std::string& object, const std::string& name, const Raw& memory);
  void make_scale(const std::string& path, const std::string& name);
  void attach_scales(const Dataset& dataset);
  void write_reference_list(const std::string& scale, const std::vector<Use>& uses);

  std::string file_name_;
  int memory_;  ///< descriptor of a file in memory
  H5Handle file_;
  std::vector<std::string> scales_;                ///< in order of creation
  std::map<std::string, std::vector<Use>> users_;  ///< of each scale
};

}  // namespace vrda
