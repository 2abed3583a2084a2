/// Visitors of a registry's rows.
#pragma once

#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "core/error.hpp"
#include "store/dataset.hpp"
#include "store/derived.hpp"
#include "store/trace.hpp"

namespace vrda::store {

/// CF 1.9 is the first to allow 64-bit integers (row_start).
inline constexpr const char* conventions = "CF-1.9";

/// Base of registry visitors, with empty defaults. A visitor also has `void operator()(const Dataset&,
/// Member&)`, called once per dataset; attributes, lists and datasets may be templates over the member.
class RegistryVisitor {
 public:
  void group(const std::string&) {}
  /// Whether an optional object exists: in the model (`is_there`), or in the file being read.
  bool has(const std::string&, bool is_there) { return is_there; }
  void dimension(const std::string& path, const DimensionSize& count) { sizes_.push_back({path, count.n}); }
  template <typename Member>
  void attribute(const std::string&, const std::string&, Member&, const Unit&)
  {
  }
  /// An attribute that repeats a value stored elsewhere in the model.
  template <typename Value>
  void derived_attribute(const std::string&, const std::string&, const Value&)
  {
  }
  /// A list with one group per element below `group`; a reader fills the list.
  template <typename List>
  void list(const std::string&, List&)
  {
  }

  /// Size of a dimension that was visited before.
  std::int64_t size(const std::string& path) const
  {
    for (const auto& [known, n] : sizes_)
      if (known == path) return n;
    throw InternalError("a dataset uses a dimension that is not in the registry");
  }
  std::vector<std::int64_t> shape_of(const Dataset& dataset) const
  {
    std::vector<std::int64_t> shape;
    for (const std::string& dimension : dataset.dimensions) shape.push_back(size(dimension));
    return shape;
  }

 private:
  std::vector<std::pair<std::string, std::int64_t>> sizes_;
};

/// What the rows call, so that they are compiled once for all visitors.
class RowVisitor {
 public:
  using Member =
      std::variant<std::string*, std::vector<std::string>*, std::vector<double>*, std::vector<float>*,
                   std::vector<std::int8_t>*, std::vector<std::int32_t>*, std::vector<std::int64_t>*, GridD*,
                   GridB*, GridI*, Exponents*, Points*, Points32*, Triangles*>;
  using Attribute = std::variant<std::string*, bool*, double*, std::int32_t*, Eigen::Vector3d*>;
  using Value = std::variant<double, std::int32_t>;
  using List = std::variant<std::vector<SmoothedSet>*, std::vector<AuditSet>*>;

  virtual ~RowVisitor() = default;
  /// Whether the members may be changed.
  virtual bool may_change() const = 0;
  virtual void group(const std::string& path) = 0;
  virtual bool has(const std::string& path, bool is_there) = 0;
  virtual void dimension(const std::string& path, const DimensionSize& count) = 0;
  virtual std::int64_t size(const std::string& path) const = 0;
  virtual void derived_attribute(const std::string& object, const std::string& name, const Value& value) = 0;

  template <typename Type>
  void attribute(const std::string& object, const std::string& name, Type& value,
                 const Unit& units = unit::none)
  {
    visit_attribute(object, name, &value, units);
  }
  template <typename Type>
  void list(const std::string& group, Type& elements)
  {
    visit_list(group, &elements);
  }
  template <typename Type>
  void operator()(const Dataset& dataset, Type& member)
  {
    visit_dataset(dataset, &member);
  }

 private:
  virtual void visit_attribute(const std::string& object, const std::string& name, Attribute value,
                               const Unit& units) = 0;
  virtual void visit_list(const std::string& group, List elements) = 0;
  virtual void visit_dataset(const Dataset& dataset, Member member) = 0;
};

/// Calls a RegistryVisitor, with const members if `is_const`.
template <typename Visitor, bool is_const>
class RowVisitorOf final : public RowVisitor {
 public:
  explicit RowVisitorOf(Visitor& visitor) : visitor_(visitor) {}

  bool may_change() const override { return !is_const; }
  void group(const std::string& path) override { visitor_.group(path); }
  bool has(const std::string& path, bool is_there) override { return visitor_.has(path, is_there); }
  void dimension(const std::string& path, const DimensionSize& count) override
  {
    visitor_.dimension(path, count);
  }
  std::int64_t size(const std::string& path) const override { return visitor_.size(path); }
  void derived_attribute(const std::string& object, const std::string& name, const Value& value) override
  {
    std::visit([&](const auto& one) { visitor_.derived_attribute(object, name, one); }, value);
  }

 private:
  template <typename Type>
  using Seen = std::conditional_t<is_const, const Type, Type>;

  void visit_attribute(const std::string& object, const std::string& name, Attribute value,
                       const Unit& units) override
  {
    std::visit([&]<typename Type>(
                   Type* one) { visitor_.attribute(object, name, static_cast<Seen<Type>&>(*one), units); },
               value);
  }
  void visit_list(const std::string& group, List elements) override
  {
    std::visit([&]<typename Type>(Type* all) { visitor_.list(group, static_cast<Seen<Type>&>(*all)); },
               elements);
  }
  void visit_dataset(const Dataset& dataset, Member member) override
  {
    std::visit([&]<typename Type>(Type* all) { visitor_(dataset, static_cast<Seen<Type>&>(*all)); }, member);
  }

  Visitor& visitor_;
};

}  // namespace vrda::store
