#include "tables/osim_model.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <pugixml.hpp>
#include <sstream>

#include "core/units.hpp"
#include "store/sample_model.hpp"
#include "support/models.hpp"
#include "support/refusal.hpp"

namespace vrda::tables::osim_model_test {

using pugi::xml_node;

const OsimOptions knee{"knee.h5", "knee_flex_r", "knee"};

std::vector<double> numbers(const xml_node& node, const char* name)
{
  std::istringstream text(node.child(name).text().get());
  std::vector<double> values;
  for (double value = 0.0; text >> value;) values.push_back(value);
  return values;
}

FlexionMotion motion_of(const store::MotionModel& model)
{
  FlexionPlan plan;
  plan.set = "raw";
  return flexion_motion(model, "knee.h5", plan);
}

pugi::xml_document parsed(const store::MotionModel& model)
{
  pugi::xml_document document;
  EXPECT_TRUE(document.load_string(osim_model(model, motion_of(model), knee).xml.c_str()));
  return document;
}

// Closed form: the translations are those of the rotation centre, wherever the meshes have their origin.
TEST(OsimModel, TranslationsAreThoseOfTheRotationCentre)
{
  test::ModelPlan plan;
  plan.rotation_centre_mm = {400, -900, 80};
  plan.motion = [](double flexion_deg, double) {
    return store::PoseCoordinates{0.0, -3.0, 0.0, 0.2 * flexion_deg};
  };
  const store::MotionModel model = test::model_of(plan);
  const pugi::xml_document document = parsed(model);
  const xml_node joint = document.select_node("//CustomJoint").node();
  for (const pugi::xpath_node& frame : joint.select_nodes("frames/PhysicalOffsetFrame"))
    EXPECT_THAT(numbers(frame.node(), "translation"), testing::ElementsAre(0.4, -0.9, 0.08));
  double longest_m = 0.0;
  for (const pugi::xpath_node& axis : joint.select_nodes("SpatialTransform/TransformAxis/SimmSpline")) {
    if (std::string(axis.node().parent().attribute("name").value()).find("translation") != 0) continue;
    for (const double m : numbers(axis.node(), "y")) longest_m = std::max(longest_m, std::abs(m));
  }
  // 3 mm along Delta; the solver's rounding at coordinates of 1 m.
  EXPECT_NEAR(longest_m, 0.003, 1e-12);
}

TEST(OsimModel, WrapsHaveTheirAnglesRadiiAndBodies)
{
  test::SampleOptions options;
  options.has_failed_cell = false;
  options.is_equilibrium = true;
  options.n_fibres = 4;
  options.n_wraps = 2;
  const store::MotionModel model = test::sample_model(options);
  const pugi::xml_document document = parsed(model);
  const store::LigamentRows& ligaments = *model.ligaments;
  const std::vector<std::string> paths{"//Body[1]//WrapCylinder", "//Body[2]//WrapEllipsoid"};
  for (std::size_t row = 0; row < paths.size(); ++row) {
    const xml_node wrap = document.select_node(paths[row].c_str()).node();
    ASSERT_TRUE(wrap) << paths[row];
    const Pose X = store::pose_in(ligaments.X_body_wrap, row);
    const std::vector<double> angles = numbers(wrap, "xyz_body_rotation");
    ASSERT_EQ(angles.size(), 3u);
    const Eigen::Matrix3d R = (Eigen::AngleAxisd(angles[0], Eigen::Vector3d::UnitX()) *
                               Eigen::AngleAxisd(angles[1], Eigen::Vector3d::UnitY()) *
                               Eigen::AngleAxisd(angles[2], Eigen::Vector3d::UnitZ()))
                                  .toRotationMatrix();
    EXPECT_LT((R - X.linear()).norm(), 1e-12) << "rounding";
    const std::vector<double> at_m = numbers(wrap, "translation");
    for (int k = 0; k < 3; ++k)
      EXPECT_DOUBLE_EQ(at_m[static_cast<std::size_t>(k)], 1e-3 * X.translation()[k]);
  }
  EXPECT_THAT(numbers(document.select_node(paths[0].c_str()).node(), "radius"), testing::ElementsAre(0.02));
  EXPECT_THAT(numbers(document.select_node(paths[0].c_str()).node(), "length"), testing::ElementsAre(0.06));
  EXPECT_THAT(numbers(document.select_node(paths[1].c_str()).node(), "dimensions"),
              testing::ElementsAre(0.02, 0.02, 0.03));
  // Blanks are no part of OpenSim's names.
  EXPECT_STREQ(document.select_node("//PathWrap/wrap_object").node().text().get(), "condyle_1");
}

// The splines are of flexion, whatever numbers the frames.
TEST(OsimModel, ASequenceWhoseFlexionRisesIsTheJointOfItsFlexions)
{
  const store::MotionModel model = test::model_of({});
  FlexionMotion motion = motion_of(model);
  const std::string joint = osim_joint(model, motion, knee);
  motion.key_name = "time_s";
  EXPECT_EQ(osim_joint(model, motion, knee), joint);
}

TEST(OsimModel, FlexionMustRise)
{
  const store::MotionModel model = test::model_of({});
  FlexionMotion motion = motion_of(model);
  motion.frames[1].clinical.flexion_rad = motion.frames[0].clinical.flexion_rad;
  EXPECT_THAT(test::input_error([&] { osim_joint(model, motion, knee); }),
              test::refuses({.file = "knee.h5", .field = "flexion"}));
  motion.frames.resize(1);
  EXPECT_THAT(test::input_error([&] { osim_joint(model, motion, knee); }),
              test::refuses({.file = "knee.h5", .field = "flexion"}));
}

}  // namespace vrda::tables::osim_model_test
