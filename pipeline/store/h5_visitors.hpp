/// Registry visitors that write datasets and attributes to an HDF5 file and read them.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "store/h5_reader.hpp"
#include "store/h5_writer.hpp"
#include "store/registry_visitor.hpp"
#include "store/value_findings.hpp"

namespace vrda::store {

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
  void attribute(const std::string& object, const std::string& name, const Member& member,
                 const Unit&)
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
