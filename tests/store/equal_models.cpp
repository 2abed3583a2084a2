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

  bool has(const std::string& path, bool is_there) override
  {
    if (is_there) entries[path + " is there"];
    return is_there;
  }
  void dimension(const std::string& path, const store::DimensionSize& count) override
  {
    store::RegistryVisitor::dimension(path, count);
    entries[path + " size"] = {std::to_string(count.n)};
  }
  void visit_attribute(const std::string& object, const std::string& name, Attribute value,
                       const core::Unit&) override
  {
    std::vector<std::string>& values = entries[object + "@" + name];
    if (const auto* vector = std::get_if<Eigen::Vector3d*>(&value)) {
      for (const double x : **vector) values.push_back(text(x));
    } else {
      std::visit(
          [&]<typename Type>(const Type* one) {
            if constexpr (!std::is_same_v<Type, Eigen::Vector3d>) values.push_back(text(*one));
          },
          value);
    }
  }
  void visit_list(const std::string& group, List list) override
  {
    std::visit(
        [&](const auto* all) {
          for (const auto& element : *all) entries[group].push_back(store::group_name(element));
        },
        list);
  }
  void visit_dataset(const store::Dataset& dataset, Member member) override
  {
    store::with_values(member, [&](auto values) {
      for (const auto& value : values) entries[dataset.path].push_back(text(value));
    });
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

template <typename Content>
void expect_equal_rows(const Content& a, const Content& b)
{
  Listing of_a, of_b;
  store::visit_registry(a, of_a);
  store::visit_registry(b, of_b);
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
  expect_equal_rows(a, b);
}

void expect_equal(const store::Trace& a, const store::Trace& b)
{
  expect_equal_rows(a, b);
}

}  // namespace vrda::test
