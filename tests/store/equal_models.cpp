// Exact comparison of motion models and of traces.
#include "store/sample_model.hpp"

#include <gtest/gtest.h>

#include <map>

#include "store/registry.hpp"

namespace vrda::test {
namespace {

/// Content of a motion model as text by path, to name differences.
class Listing : public store::RegistryVisitor {
 public:
  std::map<std::string, std::vector<std::string>> entries;

  bool has(const std::string& path, bool is_there)
  {
    if (is_there) entries[path + " is there"];
    return is_there;
  }
  void dimension(const std::string& path, const store::DimensionSize& count)
  {
    store::RegistryVisitor::dimension(path, count);
    entries[path + " size"] = {std::to_string(count.n)};
  }
  template <typename Member>
  void attribute(const std::string& object, const std::string& name, const Member& member,
                 const core::Unit& = core::unit::none)
  {
    std::vector<std::string>& values = entries[object + "@" + name];
    if constexpr (std::is_same_v<Member, Eigen::Vector3d>) {
      for (const double x : member) values.push_back(text(x));
    } else {
      values.push_back(text(member));
    }
  }
  template <typename List>
  void list(const std::string& group, const List& list)
  {
    for (const auto& element : list) entries[group].push_back(store::group_name(element));
  }
  template <typename Member>
  void operator()(const store::Dataset& dataset, const Member& member)
  {
    for (const auto& value : store::values_of(member)) entries[dataset.path].push_back(text(value));
  }

 private:
  static std::string text(const std::string& value) { return value; }
  template <typename Number>
  static std::string text(Number value)
  {
    // Exact, but all NaNs are equal.
    char exact[40];
    std::snprintf(exact, sizeof exact, "%a", static_cast<double>(value));
    return value != value ? "nan" : exact;
  }
};

template <typename Visit>
void expect_equal_listings(const Visit& visit_a, const Visit& visit_b)
{
  Listing of_a, of_b;
  visit_a(of_a);
  visit_b(of_b);
  for (const auto& [path, values] : of_a.entries) {
    const auto found = of_b.entries.find(path);
    if (found == of_b.entries.end()) {
      ADD_FAILURE() << path << " in the first only";
    } else {
      EXPECT_TRUE(values == found->second) << path;
    }
  }
  for (const auto& [path, values] : of_b.entries)
    EXPECT_TRUE(of_a.entries.count(path)) << path << " in the second only";
}

}  // namespace

void expect_equal(const store::MotionModel& a, const store::MotionModel& b)
{
  const auto visit_of = [](const store::MotionModel& model) {
    return [&model](Listing& listing) { store::visit_motion_model(model, listing); };
  };
  expect_equal_listings(visit_of(a), visit_of(b));
}

void expect_equal(const store::Trace& a, const store::Trace& b)
{
  const auto visit_of = [](const store::Trace& trace) {
    return [&trace](Listing& listing) { store::visit_trace(trace, listing); };
  };
  expect_equal_listings(visit_of(a), visit_of(b));
}

}  // namespace vrda::test
