#include "job/thesis_files.hpp"

#include <gmock/gmock.h>

#include "support/refusal.hpp"

namespace vrda::configuration_test {

using testing::ElementsAre;

// Appendix B; keyword names that are illegible there are ours.
const std::string knee = R"(# the knee
MODEL 0 femur
MODEL 1 tibmen
INITIAL_POSITION 1 0 -0.02 0
INITIAL_MOTION 1 0 0.005 0
INITIAL_ORIENTATION 1 0 0 0
SHIFT_MODEL 0 -0.1 0 0
ORIENTATION_MODEL 1 0 90 0
DISPLAY 1280 1024
ZOOM 5
CONTACT_RESOLUTION 0.0001
MODELING_RESOLUTION 0.001
ANGLE_RANGE 0 0 90
ANGLE_RANGE 1 -15 15
RENDER fill
)";

TEST(Configuration, example_of_the_thesis)
{
  const job::KeywordConfiguration c = job::parse_configuration({"knee.cfg", knee});
  EXPECT_THAT(c.reference, ElementsAre("femur"));
  EXPECT_THAT(c.moving, ElementsAre("tibmen"));
  EXPECT_EQ(c.position_mm, Eigen::Vector3d(0, -20, 0));
  EXPECT_EQ(c.motion_mm, Eigen::Vector3d(0, 5, 0));
  EXPECT_EQ(c.turn_deg, 0.0);
  EXPECT_EQ(c.contact_resolution_mm, 0.1);
  EXPECT_EQ(c.modelling_step_mm, 1.0);
  EXPECT_EQ(c.orientation_resolution_deg, 0.1);
  EXPECT_EQ(c.orientation_step_deg, 1.0);
  EXPECT_EQ(c.flexion.to_deg, 90.0);
  EXPECT_EQ(c.varus.from_deg, -15.0);
  EXPECT_EQ(c.varus.step_deg, 1.0);
  ASSERT_EQ(c.views.size(), 2u);
  EXPECT_EQ(c.views.at(0).shift_mm, Eigen::Vector3d(-100, 0, 0));
  EXPECT_EQ(c.views.at(1).orientation_deg, Eigen::Vector3d(0, 90, 0));
  EXPECT_THAT(c.display_px.value(), ElementsAre(1280, 1024));
  EXPECT_EQ(c.zoom, 5.0);
  EXPECT_EQ(c.render, "fill");
}

TEST(Configuration, defaults)
{
  const job::KeywordConfiguration c = job::parse_configuration({"k.cfg", "MODEL 0 a\nMODEL 1 b\n"});
  EXPECT_EQ(c.position_mm, Eigen::Vector3d(0, 0, 0));
  EXPECT_EQ(c.contact_resolution_mm, 0.1);
  EXPECT_EQ(c.modelling_step_mm, 1.0);
  EXPECT_EQ(c.flexion.from_deg, 0.0);
  EXPECT_EQ(c.flexion.to_deg, 0.0);
  EXPECT_TRUE(c.views.empty());
  EXPECT_FALSE(c.display_px || c.zoom);
  EXPECT_EQ(c.render, "");
}

TEST(Configuration, units)
{
  const std::string text =
      "MODEL 0 a\nMODEL 1 b\nCONTACT_RESOLUTION 0.0003\nINITIAL_POSITION 1 0.07 -0.0201 1\n";
  const job::KeywordConfiguration metres = job::parse_configuration({"k.cfg", text}, 1000.0);
  EXPECT_EQ(metres.contact_resolution_mm, 0.3);
  EXPECT_EQ(metres.position_mm, Eigen::Vector3d(70, -20.1, 1000));
  const job::KeywordConfiguration millimetres = job::parse_configuration({"k.cfg", text}, 1.0);
  EXPECT_EQ(millimetres.contact_resolution_mm, 0.0003);
  EXPECT_EQ(millimetres.position_mm, Eigen::Vector3d(0.07, -0.0201, 1));
}

}  // namespace vrda::configuration_test
