// The warning of a joint's kind that contradicts the shape of its surfaces.
#include "job/auto_frame.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/real_knees.hpp"

namespace vrda::joint_shape_test {

using testing::Contains;
using testing::HasSubstr;
using testing::Not;

job::Case shipped(const std::string& name, const std::vector<std::string>& overrides)
{
  return job::load_case((test::source_directory() / "jobs" / name).string(), {"", overrides});
}

TEST(JointShape, head_of_a_hip)
{
  const std::optional<job::BallFit> fit = job::ball_fit(shipped("hip-generic.toml", {}));
  ASSERT_TRUE(fit);
  EXPECT_TRUE(fit->is_ball);
  // Vertices lie on the sphere; some of the fillet of the neck are within the band.
  EXPECT_NEAR(fit->sphere.radius_mm, 24.0, 0.1);
  EXPECT_LT(fit->sphere.centre_mm.norm(), 0.1);
}

TEST(JointShape, no_balls)
{
  for (const char* name : {"knee-generic.toml", "ankle-generic.toml"}) {
    SCOPED_TRACE(name);
    const std::optional<job::BallFit> fit = job::ball_fit(shipped(name, {}));
    ASSERT_TRUE(fit);
    EXPECT_FALSE(fit->is_ball) << fit->sphere.radius_mm << " " << fit->rms_mm;
  }
}

TEST(JointShape, wrong_kind)
{
  const std::string of_knee = "joint: \"hip\", but", of_ball = "write joint = \"hip\"";
  EXPECT_THAT(shipped("knee-generic.toml", {"joint=hip", "push.frame=world"}).warnings,
              Contains(HasSubstr(of_knee)));
  EXPECT_THAT(shipped("ankle-generic.toml", {"joint=hip", "push.frame=world"}).warnings,
              Contains(HasSubstr(of_knee)));
  for (const char* kind : {"joint=knee", "joint=ankle", "joint=subtalar"})
    EXPECT_THAT(shipped("hip-generic.toml", {kind}).warnings, Contains(HasSubstr(of_ball))) << kind;
  EXPECT_THAT(shipped("hip-generic.toml", {"joint=other"}).warnings, Not(Contains(HasSubstr("joint: "))));
}

}  // namespace vrda::joint_shape_test
