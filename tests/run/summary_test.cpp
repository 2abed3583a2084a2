#include "run/run_output.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace vrda::summary_test {

// Stable poses at every 5 degrees from -20 to 40, at one varus.
store::MotionModel model_with_border(const std::vector<double>& at_border_deg)
{
  store::MotionModel model;
  for (int i = -4; i <= 8; ++i) model.flexion_deg.push_back(5.0 * i);
  const auto n = static_cast<Eigen::Index>(model.flexion_deg.size());
  model.status = store::GridB::Constant(n, 1, status_stable);
  model.plausibility = store::GridB::Zero(n, 1);
  for (Eigen::Index i = 0; i < n; ++i) {
    if (std::ranges::count(at_border_deg, model.flexion_deg[static_cast<std::size_t>(i)]) > 0)
      model.plausibility(i, 0) = static_cast<std::int8_t>(Plausibility::border_contact);
  }
  return model;
}

TEST(UnsolvedFraction, CountsContactsFarPastTheFirstAtABorder)
{
  struct Row {
    std::vector<double> at_border_deg;
    int n_past;
  };
  for (const Row& row : {Row{{}, 0}, Row{{20, 25, 30}, 0}, Row{{20, 35}, 1}, Row{{20, 25, 30, 35, 40}, 2},
                         Row{{-20, 40}, 0}, Row{{-5, -20, 40}, 1}, Row{{0, 10, 15, -10, -15}, 2}}) {
    SCOPED_TRACE(testing::PrintToString(row.at_border_deg));
    const store::MotionModel model = model_with_border(row.at_border_deg);
    EXPECT_EQ((run::is_past_border(model) == 1).count(), row.n_past);
    EXPECT_NEAR(run::unsolved_fraction(model), row.n_past / 13.0, 1e-12);
  }
  store::MotionModel model = model_with_border({20, 35});
  model.status(0, 0) = static_cast<std::int8_t>(StepStatus::no_contact);
  EXPECT_NEAR(run::unsolved_fraction(model), 2.0 / 13.0, 1e-12);
}

}  // namespace vrda::summary_test
