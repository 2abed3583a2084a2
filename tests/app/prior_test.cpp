// A job with a prior from job file to statement: both motions, their shares, and what does not depend on it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "app/scenes.hpp"
#include "store/motion.hpp"
#include "store/motion_model.hpp"

namespace vrda::prior_test {

namespace fs = std::filesystem;
using testing::HasSubstr;

class Prior : public testing::Test {
 protected:
  store::MotionModel model_of(const std::string& more, const std::vector<std::string>& settings = {})
  {
    const fs::path job =
        scratch_.write("knee_" + std::to_string(n_++) + ".toml", test::coarse_knee_text + more);
    return test::solved(job, settings);
  }

  test::Scratch scratch_;
  int n_ = 0;
};

TEST_F(Prior, BothMotionsAreStored)
{
  const store::MotionModel with = model_of(test::prior_and_its_spread), without = model_of("");
  ASSERT_TRUE(with.prior);
  EXPECT_FALSE(without.prior);
  // The same equilibria as without the key, to the last bit.
  EXPECT_EQ(with.prior->bones_alone.theta_deg, without.equilibrium->spine.theta_deg);
  EXPECT_EQ(with.prior->bones_alone.ty_mm, without.equilibrium->spine.ty_mm);
  const store::Motion alone(with, store::bones_alone_name);
  const double flexion_rad = rad_from_deg(20.0);
  EXPECT_NEAR(deg_from_rad(alone.at({flexion_rad, 0.0}).theta_rad), with.prior->bones_alone.theta_deg[2],
              1e-9);
  for (std::size_t i = 0; i < with.flexion_deg.size(); ++i) {
    const store::PriorTermRows& internal = with.prior->terms.front();
    EXPECT_NEAR(internal.value[i], with.clinical[JointCoordinate::internal](static_cast<Eigen::Index>(i), 0),
                0.05)
        << "the cell is solved from the pose of the spine";
    EXPECT_NEAR(internal.force[i],
                -internal.stiffness[i] * rad_from_deg(internal.value[i] - internal.curve[i]), 1e-6);
    EXPECT_NEAR(with.prior->rotation_share[i],
                internal.stiffness[i] / (internal.stiffness[i] + with.prior->own_stiffness[i]), 1e-12);
  }
  ASSERT_TRUE(with.uncertainty);
  EXPECT_THAT(with.prior->statement, testing::AllOf(HasSubstr("A model"), HasSubstr("walker-1988"),
                                                    HasSubstr(" % of the rotation")));
}

TEST_F(Prior, AStiffSpringIsFollowed)
{
  const store::MotionModel model = model_of(R"(
[[prior]]
coordinate = "internal"
shape = { flexion_deg = [0, 30], value = [0, 3] }
stiffness = 1e7
level = 1
)");
  for (std::size_t i = 0; i < model.flexion_deg.size(); ++i)
    EXPECT_NEAR(model.prior->terms.front().value[i], 1.0 + 0.1 * model.flexion_deg[i], 0.02)
        << "moments of 2000 N mm over the stiffness";
}

TEST_F(Prior, ALeftKneeHasTheNumbersOfItsMirrorImage)
{
  const store::MotionModel right = model_of(test::prior_and_its_spread),
                           left = model_of(test::prior_and_its_spread, {"side=\"left\""});
  EXPECT_EQ(left.side, "left");
  EXPECT_TRUE((left.clinical[JointCoordinate::internal] == right.clinical[JointCoordinate::internal]).all());
  EXPECT_TRUE((left.clinical[JointCoordinate::anterior] == right.clinical[JointCoordinate::anterior]).all());
  EXPECT_EQ(left.prior->terms.front().level, right.prior->terms.front().level);
}

TEST_F(Prior, AScaledKneeIsSolvedAtItsSize)
{
  const store::MotionModel model = model_of(test::prior_and_its_spread, {"scaling.factor=1.2"});
  ASSERT_TRUE(model.job.scaling);
  EXPECT_FALSE(model.job.scaling->keeps_steps);
}

}  // namespace vrda::prior_test
