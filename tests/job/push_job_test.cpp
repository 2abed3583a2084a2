// [push]: loads, lines, and the lateral force across Delta.
#include "job/command_jobs.hpp"

#include <gmock/gmock.h>

#include <cmath>

#include "core/units.hpp"
#include "job/mesh_text.hpp"
#include "support/refusal.hpp"

namespace vrda::push_job_test {

using test::refuses;

job::Job job_of(const std::string& push)
{
  return job::parse_job("knee.toml", test::small_job("", push));
}

const char* const loads_and_lines = R"(
[[push.load]]
name = "drawer"
frame = "moving"
force_n = { flexion_deg = [0, 90], value = [[10, 0, 0], [30, 0, -4]] }
moment_nmm = [1, 2, 3]
point_mm = [4, 5, 6]
[[push.load]]
name = "weight"
moment_nmm = [0, 0, 7]
[[push.line]]
name = "quadriceps"
tension_n = { flexion_deg = [30, 60], value = [0, 300] }
reference_mm = [[1, 2, 3], [4, 5, 6]]
moving_mm = [[7, 8, 9]]
)";

TEST(PushJob, over_flexion)
{
  const job::PushJob push = job_of(loads_and_lines).push;
  ASSERT_EQ(push.loads.size(), 2U);
  EXPECT_EQ(push.loads[0].at.name, "drawer");
  EXPECT_EQ(push.loads[0].at.frame, LoadFrame::moving);
  EXPECT_EQ(push.loads[0].at.point_mm, Eigen::Vector3d(4, 5, 6));
  EXPECT_EQ(push.loads[1].at.frame, LoadFrame::world);
  ASSERT_EQ(push.lines.size(), 1U);
  EXPECT_EQ(push.lines[0].path.reference_mm.at(1), Eigen::Vector3d(4, 5, 6));
  EXPECT_EQ(push.lines[0].path.moving_mm.at(0), Eigen::Vector3d(7, 8, 9));
  const job::Push at = job::push_at(push, Eigen::Vector3d::UnitY(), rad_from_deg(45));
  EXPECT_LT((at.load_force_n.at(0) - Eigen::Vector3d(20, 0, -2)).norm(), 1e-12);
  EXPECT_EQ(at.load_moment_nmm.at(0), Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(at.load_force_n.at(1), Eigen::Vector3d(0, 0, 0));
  EXPECT_NEAR(at.line_tension_n.at(0), 150, 1e-12);
}

job::Push pushed(const Eigen::Vector3d& delta)
{
  static const job::PushJob push = job_of("[push]\nforce_n = 10\nlateral_force_n = [3, -4]\n").push;
  return job::push_at(push, delta, 0.0);
}

TEST(PushJob, lateral_force)
{
  EXPECT_EQ(pushed(Eigen::Vector3d::UnitY()).force_n, Eigen::Vector3d(3, 10, -4));
  for (const Eigen::Vector3d& given : {Eigen::Vector3d(-1, 0, 0), Eigen::Vector3d(1, 2, -3),
                                       Eigen::Vector3d(0, -1, 0), Eigen::Vector3d(0, 0, 1)}) {
    const Eigen::Vector3d delta = given.normalized();
    const Eigen::Vector3d force_n = pushed(delta).force_n;
    EXPECT_NEAR(force_n.dot(delta), 10, 1e-12);
    EXPECT_NEAR(force_n.norm(), std::sqrt(125.0), 1e-12);
  }
  // With Delta backwards the first axis is proximal.
  EXPECT_LT((pushed({-1, 0, 0}).force_n - Eigen::Vector3d(-10, 3, -4)).norm(), 1e-12);
}

TEST(PushJob, continuous_axes)
{
  Eigen::Vector3d before = pushed(Eigen::Vector3d::UnitY()).force_n;
  // Round to 170 degrees from +Y; only -Y itself is singular.
  for (double angle = 0.0; angle < rad_from_deg(170); angle += 1e-3) {
    const Eigen::Vector3d force_n =
        pushed({0.6 * std::sin(angle), std::cos(angle), 0.8 * std::sin(angle)}).force_n;
    EXPECT_LT((force_n - before).norm(), 20 * 1e-3);
    before = force_n;
  }
}

TEST(PushJob, left_joint)
{
  const Eigen::Vector3d delta = Eigen::Vector3d(0.2, 0.9, 0.4).normalized(), mirror(1, 1, -1);
  const job::PushJob right = job_of("[push]\nlateral_force_n = [3, -4]\n").push;
  const job::PushJob left = job_of("[push]\nlateral_force_n = [3, 4]\n").push;
  EXPECT_LT((job::push_at(right, delta, 0).force_n -
             mirror.cwiseProduct(job::push_at(left, mirror.cwiseProduct(delta), 0).force_n))
                .norm(),
            1e-12);
}

}  // namespace vrda::push_job_test
