/// A visitor of a motion model's numbers with virtual functions: one compiled pass over the registry for all
/// that change numbers in place.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <variant>
#include <vector>

#include "store/motion_model.hpp"
#include "store/registry_rows.hpp"

namespace vrda::store {

class MemberVisitor : public RegistryVisitor {
 public:
  using Values = std::variant<std::span<double>, std::span<std::int8_t>, std::span<std::int32_t>,
                              std::span<std::int64_t>>;
  /// Resizes the dataset's member to a shape and returns its values.
  using Resize = std::function<Values(const std::vector<std::int64_t>&)>;

  virtual ~MemberVisitor() = default;

  template <typename Member>
  void attribute(const std::string&, const std::string&, Member& member, const Unit& units = unit::none)
  {
    if constexpr (std::is_same_v<Member, double>) change_attribute({&member, 1}, units);
    if constexpr (std::is_same_v<Member, Eigen::Vector3d>) change_attribute({member.data(), 3}, units);
  }

  template <typename Member>
  void operator()(const Dataset& dataset, Member& member)
  {
    if constexpr (member_kind<Member>() != ValueKind::text) {
      change(dataset, values_of(member), [&member](const std::vector<std::int64_t>& shape) -> Values {
        resize(member, shape);
        return values_of(member);
      });
    }
  }

 protected:
  virtual void change_attribute(std::span<double>, const Unit&) {}
  virtual void change(const Dataset& dataset, const Values& values, const Resize& resized) = 0;
};

void visit_members(MotionModel& model, MemberVisitor& visitor);

}  // namespace vrda::store
