#include "store/motion_model.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "core/text.hpp"
#include "store/registry.hpp"
#include "store/sample_model.hpp"

namespace vrda::scaled_model_test {

using test::whole_model;

struct Numbers {
  std::string unit;
  bool is_pose = false;
  std::vector<double> values;
};

/// All lengths, angles and other numbers of a model by name.
class AllNumbers : public store::RegistryVisitor {
 public:
  std::map<std::string, Numbers> numbers;

  template <typename Member>
  void attribute(const std::string& object, const std::string& name, const Member& member,
                 const core::Unit& units = core::unit::none)
  {
    Numbers& found = numbers[object + "@" + name];
    found.unit = units.name;
    if constexpr (std::is_same_v<Member, double>) found.values = {member};
    if constexpr (std::is_same_v<Member, Eigen::Vector3d>) found.values.assign(member.begin(), member.end());
  }
  template <typename Member>
  void operator()(const store::Dataset& dataset, const Member& member)
  {
    if constexpr (store::member_kind<Member>() == store::ValueKind::float64) {
      const auto values = store::values_of(member);
      numbers[dataset.path] = {
          dataset.units.name, dataset.path.find("/X_") != std::string::npos, {values.begin(), values.end()}};
    }
  }
};

std::map<std::string, Numbers> numbers_of(const store::MotionModel& model)
{
  AllNumbers all;
  store::visit_motion_model(model, all);
  return all.numbers;
}

/// Whether entry k of row-major poses is a translation.
bool is_shift(std::size_t k)
{
  return k % 4 == 3 && k % 16 != 15;
}

// Lengths, energies and moments are found by their units, so none is missed. Powers of two are exact.
TEST(ScaledModel, WhateverHasALengthIsTwiceAsLong)
{
  const store::MotionModel model = whole_model();
  const std::map<std::string, Numbers> small = numbers_of(model),
                                       large = numbers_of(store::scaled_model(model, 2.0));
  int n_lengths = 0, n_others = 0;
  for (const auto& [name, before] : small) {
    SCOPED_TRACE(name);
    // The landmarks are input to the scaling.
    const bool has_length =
        (before.unit == "mm" || before.unit == "N mm") && name.rfind("/job/scaling", 0) != 0;
    ++(has_length ? n_lengths : n_others);
    const std::vector<double>& after = large.at(name).values;
    for (std::size_t k = 0; k < before.values.size(); ++k) {
      const double factor = has_length && (!before.is_pose || is_shift(k)) ? 2.0 : 1.0;
      const double wanted = factor * before.values[k];
      EXPECT_TRUE(after[k] == wanted || (std::isnan(wanted) && std::isnan(after[k])))
          << k << ": " << before.values[k] << " became " << after[k];
    }
  }
  EXPECT_GT(n_lengths, 60);
  EXPECT_GT(n_others, 40);
  for (const char* name : {"/@rotation_centre_mm", "/@contact_resolution_mm", "/push@point_mm",
                           "/equilibrium@band_moment_nmm", "/smoothed/degree_1/tx@rms"})
    EXPECT_EQ(small.at(name).unit.substr(small.at(name).unit.size() - 2), "mm") << name;
}

TEST(ScaledModel, BackAgainIsTheSame)
{
  const store::MotionModel model = whole_model();
  test::expect_equal(store::scaled_model(store::scaled_model(model, 0.5), 2.0), model);
  test::expect_equal(store::scaled_model(model, 1.0), model);
}

TEST(ScaledModel, AZeroScaleThrowsInternalError)
{
  EXPECT_THROW(store::scaled_model(whole_model(), 0.0), InternalError);
}

}  // namespace vrda::scaled_model_test
