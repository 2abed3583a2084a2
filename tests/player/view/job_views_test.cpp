#include "view/player_state.hpp"

#include <gtest/gtest.h>

namespace vrda::view::job_views_test {

TEST(JobViews, AreThoseOfTheJob)
{
  const JobViews job = job_views(
      "title = \"a\"\nzoom = 9\n\n[player]\ndisplay_px = [1280, 1024]\nzoom = 2.5\nrender = \"wire\"\n\n"
      "[[player.view]]\nnumber = 2\nshift_mm = [-50, 0, 1.5e1]\norientation_deg = [0, 90, -0.5]\n\n"
      "[[player.view]]\nnumber = 0\n\n[limits]\nunsolved_fraction = 0\nzoom = 7\n");
  EXPECT_EQ(job.zoom, 2.5);
  EXPECT_EQ(job.render, "wire");
  EXPECT_EQ(job.width_px, 1280);
  EXPECT_EQ(job.height_px, 1024);
  ASSERT_EQ(job.views.size(), 2u);
  EXPECT_EQ(job.views[0].number, 2);
  EXPECT_EQ(job.views[0].shift_mm, Eigen::Vector3d(-50, 0, 15));
  EXPECT_EQ(job.views[0].orientation_deg, Eigen::Vector3d(0, 90, -0.5));
  EXPECT_EQ(job.views[1].number, 0);
  EXPECT_EQ(job.views[1].shift_mm, Eigen::Vector3d::Zero());
}

TEST(JobViews, MalformedJob)
{
  for (const char* text :
       {"", "[player]", "[player]\nzoom = -1\nrender = \n", "[player]\ndisplay_px = [nan, inf]\nzoom = nan",
        "[player]\ndisplay_px = [1280]\nzoom = \"x\"\nrender = 1", "[[player.view", "zoom = 3", "player = 3",
        "[player]\nview = 3\ndisplay_px = [1, \"2\"]"}) {
    SCOPED_TRACE(text);
    const JobViews job = job_views(text);
    EXPECT_EQ(job.zoom, 1.0);
    EXPECT_EQ(job.render, "");
    EXPECT_EQ(job.width_px, 0);
    EXPECT_TRUE(job.views.empty());
  }
  const JobViews job = job_views("[[player.view]]\nshift_mm = [1, 2]\norientation_deg = \"nothing\"\n");
  ASSERT_EQ(job.views.size(), 1u);
  EXPECT_EQ(job.views[0].shift_mm, Eigen::Vector3d::Zero());
  EXPECT_EQ(job.views[0].orientation_deg, Eigen::Vector3d::Zero());
}

}  // namespace vrda::view::job_views_test
