/// From the datasets and attributes of a file whose structure has been checked to the members of a struct.
#pragma once

#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "store/h5_reader.hpp"
#include "store/structure.hpp"

namespace vrda {

/// Shapes each member it is shown like its dataset and fills it by source.read(path, span). That the source
/// has so much has been checked.
template <typename Source>
class DatasetReader {
 public:
  DatasetReader(Source& source, const FileLayout& layout, const FileShape& shape)
      : source_(source), layout_(layout), shape_(shape)
  {
    for (const DatasetSpec& spec : layout.datasets) specs_[spec.path] = &spec;
  }

  template <typename Scalar>
  void operator()(const std::string& path, std::vector<Scalar>& values)
  {
    std::int64_t count = 1;
    for (const std::int64_t size : shape_of(path)) count *= size;
    values.resize(static_cast<std::size_t>(count));
    source_.read(path, std::span<Scalar>(values));
  }

  void operator()(const std::string& path, std::string& value)
  {
    source_.read(path, std::span<std::string>(&value, 1));
  }

  template <typename Derived>
  void operator()(const std::string& path, Eigen::PlainObjectBase<Derived>& values)
  {
    static_assert(Derived::IsRowMajor, "arrays lie in memory as in the file");
    const std::vector<std::int64_t> shape = shape_of(path);
    check(shape.size() == 2, "an array has two axes");
    values.resize(shape[0], shape[1]);
    source_.read(path,
                 std::span<typename Derived::Scalar>(values.data(), static_cast<std::size_t>(values.size())));
  }

 private:
  std::vector<std::int64_t> shape_of(const std::string& path) const
  {
    const auto found = specs_.find(path);
    check(found != specs_.end(), "every dataset that is read stands in the layout");
    std::vector<std::int64_t> shape;
    for (const std::string& dimension : found->second->dimensions) {
      shape.push_back(dimension_size(layout_, shape_, dimension));
    }
    return shape;
  }

  Source& source_;
  const FileLayout& layout_;
  const FileShape& shape_;
  std::map<std::string, const DatasetSpec*> specs_;
};

inline AttributeValue attribute(const H5Reader& reader, const std::string& object, const std::string& name)
{
  const std::optional<AttributeValue> value = reader.attribute(object, name);
  check(value.has_value(), "an attribute is read only when the structure has been checked");
  return *value;
}

inline std::string text(const H5Reader& reader, const std::string& object, const std::string& name)
{
  return attribute(reader, object, name).texts.at(0);
}

inline double number(const H5Reader& reader, const std::string& object, const std::string& name)
{
  return attribute(reader, object, name).numbers.at(0);
}

}  // namespace vrda
