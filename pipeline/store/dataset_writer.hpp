/// From the members of a struct to the datasets of a layout.
#pragma once

#include <Eigen/Core>
#include <map>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "store/h5_writer.hpp"
#include "store/layout.hpp"

namespace vrda {

/// Writes each dataset it is shown, and the dimensions that the dataset is the first to use.
class DatasetWriter {
 public:
  DatasetWriter(H5Writer& writer, const FileLayout& layout, const FileShape& shape = {})
      : writer_(writer), layout_(layout), shape_(shape)
  {
    for (const DatasetSpec& spec : layout.datasets) specs_[spec.path] = &spec;
  }

  template <typename Scalar>
  void operator()(const std::string& path, const std::vector<Scalar>& values)
  {
    write(path, std::span<const Scalar>(values));
  }

  void operator()(const std::string& path, const std::string& value)
  {
    write(path, std::span<const std::string>(&value, 1));
  }

  template <typename Derived>
  void operator()(const std::string& path, const Eigen::PlainObjectBase<Derived>& values)
  {
    static_assert(Derived::IsRowMajor, "arrays go to the file as they lie in memory");
    write(path,
          std::span<const typename Derived::Scalar>(values.data(), static_cast<std::size_t>(values.size())));
  }

 private:
  template <typename Scalar>
  void write(const std::string& path, std::span<const Scalar> values)
  {
    const auto found = specs_.find(path);
    check(found != specs_.end(), "every dataset that is written stands in the layout");
    const DatasetSpec& spec = *found->second;
    std::vector<std::int64_t> sizes;
    for (const std::string& dimension : spec.dimensions) {
      sizes.push_back(dimension_size(layout_, shape_, dimension));
      const bool is_new = existing_.insert(dimension).second;
      if (is_new && dimension != path) writer_.create_dimension({dimension, sizes.back()});
    }
    writer_.write(spec, sizes, values);
  }

  H5Writer& writer_;
  const FileLayout& layout_;
  FileShape shape_;
  std::map<std::string, const DatasetSpec*> specs_;
  std::set<std::string> existing_;
};

}  // namespace vrda
