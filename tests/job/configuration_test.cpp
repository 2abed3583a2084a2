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

// The text of the thesis with one line replaced, and the expected refusal.
struct BadLine {
  std::string from;
  std::string to;
  const char* line;
  test::Values found = {};
  test::Values wanted = {};
};

void expect_refused(const BadLine& row)
{
  SCOPED_TRACE(row.from + " -> " + row.to);
  std::string text = knee;
  const std::size_t at = text.find(row.from);
  ASSERT_NE(at, std::string::npos);
  text.replace(at, row.from.size(), row.to);
  EXPECT_THAT(test::input_error([&] {
                job::parse_configuration({"knee.cfg", text});
              }),
              test::refuses({"knee.cfg", row.line, row.found, row.wanted}));
}

TEST(ConfigurationErrors, Keywords)
{
  expect_refused({"ZOOM 5", "ZOMO 5", "line 10", "\"ZOMO\"", "\"ZOOM\""});
  expect_refused({"ZOOM 5", "zoom 5", "line 10", "\"zoom\""});
  expect_refused({"ZOOM 5", "ZOOM", "line 10", "ZOOM", "ZOOM"});
  expect_refused({"ZOOM 5", "ZOOM 5 6", "line 10", {"ZOOM", "2"}, "ZOOM"});
  expect_refused({"ZOOM 5", "ZOOM five", "line 10", "\"five\"", "0"});
  expect_refused({"ZOOM 5", "ZOOM 0", "line 10", "0", "0"});
  expect_refused({"0 -0.02 0", "0 -0.02", "line 4", "3", "INITIAL_POSITION"});
  expect_refused({"ANGLE_RANGE 0 0 90", "ANGLE_RANGE 0 0", "line 13", "2"});
  expect_refused({"ZOOM 5", "DISPLAY 1 1", "line 10", {"DISPLAY", "9"}});
  expect_refused({"RENDER fill", "ANGLE_RANGE 0 0 1", "line 15", {"ANGLE_RANGE", "0"}});
}

TEST(ConfigurationErrors, Models)
{
  expect_refused({"MODEL 1 tibmen", "", "line 15", "1", {"MODEL", "1"}});
  expect_refused({"MODEL 0 femur", "", "line 15", "0", {"MODEL", "0"}});
  expect_refused({"MODEL 1 tibmen", "MODEL 2 tibmen", "line 3", "2", {"0", "1"}});
  expect_refused({"MODEL 1 tibmen", "MODEL x tibmen", "line 3", "\"x\"", {"0", "1"}});
  expect_refused({"MODEL 1 tibmen", "MODEL 1 ../tibmen", "line 3", "\"../tibmen\""});
  expect_refused({"MODEL 1 tibmen", "MODEL 0 femur", "line 3", {"MODEL", "0"}});
  expect_refused({"POSITION 1 0", "POSITION 0 0", "line 4", "0", "1"});
}

TEST(ConfigurationErrors, Values)
{
  expect_refused({"1 0 0.005 0", "1 0 0 0", "line 5", "0", "0"});
  expect_refused({"1 0 0.005 0", "1 0 5 0", "line 5", "5000", "1000"});
  expect_refused({"0 -0.02 0", "0 -2e9 0", "line 4", "-2e+12", "1e+06"});
  expect_refused({"0 -0.02 0", "0 inf 0", "line 4", "\"inf\""});
  expect_refused({"ORIENTATION 1 0 0 0", "ORIENTATION 1 5 0 0", "line 6", {"5", "0"}});
  expect_refused({"ORIENTATION 1 0 0 0", "ORIENTATION 1 0 270 0", "line 6", "270", {"-180", "180"}});
  expect_refused({"SHIFT_MODEL 0", "SHIFT_MODEL 100", "line 7", "100", {"0", "99"}});
  expect_refused({"DISPLAY 1280 1024", "DISPLAY 1280 0", "line 9", "0", "1"});
  expect_refused({"RESOLUTION 0.0001", "RESOLUTION 0", "line 11", "0", "0"});
  expect_refused({"RESOLUTION 0.0001", "RESOLUTION 0.002", "line 12", "2", "1"});
  expect_refused({"ZOOM 5", "ORIENTATION_STEP 0.05", "line 10", "0.1", "0.05"});
  expect_refused({"ZOOM 5", "ORIENTATION_RESOLUTION 91", "line 10", "91", "90"});
  expect_refused({"RANGE 0 0 90", "RANGE 2 0 90", "line 13", "2", {"0", "1"}});
  expect_refused({"RANGE 0 0 90", "RANGE 0 0 -90", "line 13", "-90", "-30"});
  expect_refused({"RANGE 1 -15 15", "RANGE 1 -15 99", "line 14", "99", "-85"});
  expect_refused({"RANGE 1 -15 15", "RANGE 1 -15 15 -1", "line 14", "-1", {"-15", "15"}});
  expect_refused({"RANGE 1 -15 15", "RANGE 1 -15 15 0", "line 14", "0", {"-15", "15"}});
  expect_refused({"RANGE 1 -15 15", "RANGE 1 -15 15 1e-9", "line 14", "", "1000000"});
  expect_refused({"RENDER fill", "RENDER full", "line 15", "\"full\""});
}

}  // namespace vrda::configuration_test
