#include "exports/opensim_table.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <sstream>

#include "core/units.hpp"
#include "motion/support/models.hpp"

namespace vrda::opensim_table_test {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

constexpr double pose_rounding = 1e-12;  // of angles and sums of a hundred mm, in radians and metres

struct Table {
  std::string name;
  std::map<std::string, std::string> keys;
  std::vector<std::string> columns;
  std::vector<std::vector<double>> rows;
};

/// By the rules of OpenSim's reader: a name, key=value lines and text up to endheader, tabs between.
Table parsed(const std::string& text)
{
  Table table;
  std::istringstream in(text);
  std::string line;
  std::getline(in, table.name);
  while (std::getline(in, line) && line != "endheader") {
    const std::size_t equals = line.find('=');
    if (equals != std::string::npos) table.keys[line.substr(0, equals)] = line.substr(equals + 1);
  }
  std::getline(in, line);
  std::istringstream names(line);
  for (std::string name; std::getline(names, name, '\t');) table.columns.push_back(name);
  while (std::getline(in, line)) {
    std::istringstream fields(line);
    table.rows.emplace_back();
    for (std::string field; std::getline(fields, field, '\t');) table.rows.back().push_back(std::stod(field));
  }
  return table;
}

FlexionMotion turning_motion(const std::string& side)
{
  test::ModelPlan plan;
  plan.side = side;
  plan.rotation_centre_mm = {5, -70, 30};
  plan.motion = [](double flexion_deg, double varus_deg) {
    return PoseNumbers{0.05 * flexion_deg, -3.0, 1.0 + 0.5 * varus_deg, 0.2 * flexion_deg - varus_deg};
  };
  FlexionPlan flexion;
  flexion.varus = VarusRule::given;
  flexion.varus_deg = 2.0;
  return flexion_motion(test::model_of(plan), "knee.h5", flexion);
}

/// The axes of schemas/exports.md.
Pose pose_of_coordinates(const std::vector<double>& row, double radians, Side side)
{
  const double other = side == Side::left ? -1.0 : 1.0;
  Pose X = Pose::Identity();
  X.linear() = rotation_z(-radians * row[1]) * rotation_x(other * radians * row[2]) *
               rotation_y(other * radians * row[3]);
  X.translation() = Eigen::Vector3d(row[4], row[5], row[6]);
  return X;
}

TEST(OpenSimTable, TheColumnsPutThePoseTogetherOnBothSides)
{
  for (const Side side : {Side::right, Side::left}) {
    for (const bool in_degrees : {false, true}) {
      SCOPED_TRACE(side == Side::left ? "left" : "right");
      const FlexionMotion motion = turning_motion(side == Side::left ? "left" : "right");
      const Table table = parsed(opensim_table(motion, {opensim_columns(side), in_degrees, 45.0}));
      ASSERT_EQ(table.rows.size(), motion.frames.size());
      for (std::size_t i = 0; i < table.rows.size(); ++i) {
        Pose expected = motion.frames[i].pose.X_reference_moving;
        expected.translation() *= 1e-3;
        const Pose found = pose_of_coordinates(table.rows[i], in_degrees ? rad_from_deg(1.0) : 1.0, side);
        EXPECT_LT((found.matrix() - expected.matrix()).cwiseAbs().maxCoeff(), pose_rounding);
        EXPECT_NEAR(table.rows[i][0], motion.frames[i].flexion_deg / 45.0, 1e-15);
      }
    }
  }
}

TEST(OpenSimTable, TheHeaderIsTrue)
{
  const FlexionMotion motion = turning_motion("right");
  const Table table = parsed(opensim_table(motion, {opensim_columns(Side::right), true, 30.0}));
  EXPECT_EQ(table.keys.at("version"), "1");
  EXPECT_EQ(table.keys.at("nRows"), std::to_string(table.rows.size()));
  EXPECT_EQ(table.keys.at("nColumns"), std::to_string(table.columns.size()));
  EXPECT_EQ(table.keys.at("inDegrees"), "yes");
  EXPECT_THAT(table.columns, ElementsAre("time", "knee_flex_r", "knee_add_r", "knee_rot_r", "knee_tx_r",
                                         "knee_ty_r", "knee_tz_r"));
  for (const std::vector<double>& row : table.rows) EXPECT_EQ(row.size(), table.columns.size());
  EXPECT_THAT(opensim_columns(Side::left), testing::Each(testing::EndsWith("_l")));
}

TEST(OpenSimTable, ATitleCannotBreakTheHeader)
{
  FlexionMotion motion = turning_motion("right");
  motion.title = "a=b\nendheader\tc";
  const Table table = parsed(opensim_table(motion, {opensim_columns(Side::right), false, 30.0}));
  EXPECT_THAT(table.name, Not(HasSubstr("endheader")));
  EXPECT_THAT(table.name, Not(HasSubstr("=")));
  EXPECT_EQ(table.keys.size(), 4U);
  EXPECT_EQ(table.rows.size(), motion.frames.size());
}

}  // namespace vrda::opensim_table_test
