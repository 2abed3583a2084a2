// The exported motion, and its tables.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <map>
#include <sstream>

#include "core/units.hpp"
#include "support/models.hpp"
#include "support/refusal.hpp"
#include "tables/formats.hpp"
#include "tables/tables.hpp"

namespace vrda::tables::tables_test {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

constexpr double angle_rounding_rad = 1e-12;  // degrees to radians and back

test::ModelPlan tilted_plan()
{
  test::ModelPlan plan;
  plan.motion = [](double flexion_deg, double varus_deg) {
    return store::PoseCoordinates{0.01 * flexion_deg, -20.0, 0.02 * varus_deg, 0.1 * flexion_deg + varus_deg};
  };
  return plan;
}

store::MotionModel with_zero_varus(store::MotionModel model, const std::vector<double>& varus_deg,
                                   std::size_t hole)
{
  store::ZeroVarus table;
  table.varus_deg = varus_deg;
  table.source.assign(varus_deg.size(), static_cast<std::int8_t>(store::ZeroVarusSource::both_touch));
  table.source[hole] = static_cast<std::int8_t>(store::ZeroVarusSource::none);
  table.varus_deg[hole] = nan;  // as in every file
  model.zero_varus = table;
  return model;
}

std::vector<double> flexions_left_out(const FlexionMotion& motion)
{
  std::vector<double> flexions;
  for (const OmittedFlexion& out : motion.omitted) flexions.push_back(out.flexion_deg);
  return flexions;
}

InputError::Facts refused(const store::MotionModel& model, const FlexionPlan& plan)
{
  return test::input_error([&] { flexion_motion(model, "knee.h5", plan); });
}

TEST(FlexionMotion, FollowsTheSpineAtTheFlexionsOfTheModel)
{
  const store::MotionModel model = test::model_of(tilted_plan());
  const FlexionMotion motion = flexion_motion(model, "knee.h5", {});
  ASSERT_EQ(motion.frames.size(), model.flexion_deg.size());
  EXPECT_EQ(motion.set, "raw");
  EXPECT_TRUE(motion.omitted.empty());
  const store::Motion poses(model, "raw");
  for (std::size_t i = 0; i < motion.frames.size(); ++i) {
    SCOPED_TRACE(i);
    const FlexionFrame& frame = motion.frames[i];
    EXPECT_EQ(frame.flexion_deg, model.flexion_deg[i]);
    const store::JointPose expected = poses.at({rad_from_deg(frame.flexion_deg), 0.0});
    EXPECT_TRUE(frame.pose.X_reference_moving.isApprox(expected.X_reference_moving, angle_rounding_rad));
    EXPECT_NEAR(frame.clinical.flexion_rad, rad_from_deg(frame.flexion_deg), angle_rounding_rad);
    EXPECT_NEAR(frame.clinical.internal_rotation_rad, rad_from_deg(0.1 * frame.flexion_deg),
                angle_rounding_rad);
    EXPECT_NEAR(time_s(motion, frame, 30.0), frame.flexion_deg / 30.0, 1e-15);
  }
}

TEST(FlexionMotion, NothingIsBridgedOrClamped)
{
  store::MotionModel model = test::model_of(tilted_plan());
  test::unsolve(model, 2, 2);  // 30 degrees, on the spine
  FlexionPlan plan;
  plan.flexion_deg = {-10, 0, 15, 20, 30, 40, 45, 90, 91};
  plan.varus = VarusRule::given;
  const FlexionMotion motion = flexion_motion(model, "knee.h5", plan);
  EXPECT_THAT(flexions_left_out(motion), ElementsAre(-10, 20, 30, 40, 91));
  EXPECT_EQ(motion.omitted[0].reason, "beyond the measured range");
  EXPECT_EQ(motion.omitted[1].reason, "unsolved_cell");
  EXPECT_EQ(motion.frames.size(), 4U);
}

TEST(FlexionMotion, ZeroVarusIsLinearBetweenTheFlexionsThatHaveOne)
{
  const store::MotionModel model = with_zero_varus(test::model_of(tilted_plan()), {0, 1, 2, 2, 0, -1, -2}, 4);
  EXPECT_EQ(default_varus(model, "zero_varus"), VarusRule::zero);
  EXPECT_EQ(default_varus(model, "raw"), VarusRule::spine) << "as it is shown";
  FlexionPlan plan;
  plan.flexion_deg = {7.5, 15, 40, 50, 60, 70, 75, 80};
  plan.varus = VarusRule::zero;
  const FlexionMotion motion = flexion_motion(model, "knee.h5", plan);
  EXPECT_THAT(flexions_left_out(motion), ElementsAre(50, 60, 70));
  EXPECT_EQ(motion.omitted[0].reason, "no zero-varus pose");
  std::vector<double> varus_deg;
  for (const FlexionFrame& frame : motion.frames)
    varus_deg.push_back(deg_from_rad(frame.pose.attitude.varus_rad));
  EXPECT_THAT(varus_deg, testing::Pointwise(testing::DoubleNear(1e-12), {0.5, 1.0, 2.0, -1.0, -4.0 / 3.0}));
}

TEST(FlexionMotion, ARuleThatCannotBeKeptIsRefused)
{
  const store::MotionModel model = test::model_of(tilted_plan());
  EXPECT_EQ(default_varus(model, "zero_varus"), VarusRule::spine);
  FlexionPlan plan;
  plan.varus = VarusRule::zero;
  EXPECT_THAT(refused(model, plan), test::refuses({.field = "--varus", .wanted = "vrda reduce"}));
  plan.varus = VarusRule::given;
  plan.varus_deg = 4.5;
  EXPECT_THAT(refused(model, plan),
              test::refuses({.field = "--varus", .found = "4.5", .wanted = {"-4", "4"}}));
  plan.varus_deg = 0.0;
  plan.set = "degree_7";
  EXPECT_EQ(refused(model, plan).field, "--set");
  EXPECT_EQ(refused(model, plan).wanted, "raw");
  test::ModelPlan free = tilted_plan();
  free.varus_deg = {0};
  free.free_varus_deg = [](double flexion_deg) { return 0.01 * flexion_deg; };
  plan.set = "raw";
  EXPECT_THAT(refused(test::model_of(free), plan), test::refuses({.field = "--varus", .wanted = "free"}));
}

using Rows = std::vector<std::map<std::string, std::string>>;

std::vector<std::string> fields_of(const std::string& line)
{
  std::vector<std::string> fields{""};
  for (const char c : line) {
    if (c == ',') {
      fields.emplace_back();
    } else {
      fields.back() += c;
    }
  }
  return fields;
}

Rows parsed(const std::string& text)
{
  std::istringstream in(text);
  std::string line;
  std::getline(in, line);
  const std::vector<std::string> names = fields_of(line);
  Rows rows;
  while (std::getline(in, line)) {
    const std::vector<std::string> fields = fields_of(line);
    EXPECT_EQ(fields.size(), names.size());
    rows.emplace_back();
    for (std::size_t k = 0; k < names.size(); ++k) rows.back()[names[k]] = fields[k];
    EXPECT_EQ(rows.back().size(), names.size()) << "two columns of the same name";
  }
  return rows;
}

test::ModelPlan plan_of(const std::string& side)
{
  test::ModelPlan plan;
  plan.side = side;
  // World W of a left joint is the mirror image of the right one's.
  const double mirror = side == "left" ? -1.0 : 1.0;
  plan.rotation_centre_mm = {10, -5, mirror * 40};
  plan.motion = [mirror](double flexion_deg, double varus_deg) {
    return store::PoseCoordinates{0.05 * flexion_deg, -3.0, mirror * (1.0 + 0.5 * varus_deg),
                                  0.2 * flexion_deg - varus_deg};
  };
  return plan;
}

TEST(CsvTables, AFlexionHasTheNumbersOfItsPose)
{
  const store::MotionModel model = test::model_of(plan_of("right"));
  const Rows rows = parsed(flexion_csv(flexion_motion(model, "knee.h5", {})));
  ASSERT_EQ(rows.size(), model.flexion_deg.size());
  constexpr double rounding = 1e-11;  // of mm and of degrees converted through radians
  for (std::size_t i = 0; i < rows.size(); ++i) {
    SCOPED_TRACE(i);
    const auto row = static_cast<Eigen::Index>(i);
    EXPECT_EQ(std::stod(rows[i].at("attitude_flexion_deg")), model.flexion_deg[i]);
    for (std::size_t k = 0; k < n_joint_coordinates; ++k)
      EXPECT_NEAR(std::stod(rows[i].at(std::string(joint_coordinate_names[k]) + unit_suffix(k))),
                  model.clinical[k](row, 2), rounding);
    EXPECT_NEAR(std::stod(rows[i].at("tx_mm")), model.tx_mm(row, 2), rounding);
    EXPECT_NEAR(std::stod(rows[i].at("theta_deg")), model.theta_deg(row, 2), rounding);
    EXPECT_EQ(rows[i].at("centre_x_mm"), "10");
    EXPECT_EQ(rows[i].at("centre_y_mm"), "-5");
    EXPECT_EQ(rows[i].at("centre_z_mm"), "40");
    for (const char* gone : {"ant_mm", "prox_mm", "lat_mm"}) EXPECT_EQ(rows[i].count(gone), 0U);
  }
}

TEST(CsvTables, EveryCellHasItsStatusAndEmptyFieldsWithoutAnAnswer)
{
  store::MotionModel model = test::model_of(plan_of("right"));
  test::unsolve(model, 1, 3);
  test::add_smoothed(model, 2, [](int i, int j) {
    return store::PoseCoordinates{1.0 + i, 0.0, 0.5 * j, 0.25};
  });
  const Rows rows = parsed(cells_csv(model));
  ASSERT_EQ(rows.size(), 35U);
  const std::map<std::string, std::string>& failed = rows[1 * 5 + 3];
  EXPECT_EQ(failed.at("status"), "no_contact");
  EXPECT_EQ(failed.at("flexion_deg"), "15");
  EXPECT_EQ(failed.at("varus_deg"), "2");
  EXPECT_EQ(failed.at("tx_mm"), "");
  EXPECT_EQ(failed.at("contact_medial"), "-1");
  EXPECT_EQ(std::stod(failed.at("degree_2_tx_mm")), model.smoothed[0].surfaces[0].values(1, 3));
  const std::map<std::string, std::string>& solved = rows[6 * 5 + 0];
  EXPECT_EQ(solved.at("status"), "stable");
  EXPECT_EQ(std::stod(solved.at("tx_mm")), model.tx_mm(6, 0));
  EXPECT_EQ(std::stod(solved.at("anterior_mm")), model.clinical[JointCoordinate::anterior](6, 0));
  EXPECT_EQ(solved.at("centre_y_mm"), "-5");
  EXPECT_EQ(std::stod(solved.at("degree_2_theta_deg")), model.smoothed[0].surfaces[3].values(6, 0));
}

constexpr double pose_rounding = 1e-12;  // of angles and sums of a hundred mm, in radians and metres

struct Table {
  std::string name;
  std::map<std::string, std::string> keys;
  std::vector<std::string> columns;
  std::vector<std::vector<double>> rows;
};

/// Parses as OpenSim does: a name, key=value lines and text up to endheader, then tab-separated columns.
Table parsed_table(const std::string& text)
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
    return store::PoseCoordinates{0.05 * flexion_deg, -3.0, 1.0 + 0.5 * varus_deg,
                                  0.2 * flexion_deg - varus_deg};
  };
  FlexionPlan flexion;
  flexion.varus = VarusRule::given;
  flexion.varus_deg = 2.0;
  return flexion_motion(test::model_of(plan), "knee.h5", flexion);
}

/// The axes of schemas/exports.md, the translations those of the point at `centre_m`.
Pose pose_of_coordinates(const std::vector<double>& row, double radians, Side side,
                         const Eigen::Vector3d& centre_m)
{
  const double other = side == Side::left ? -1.0 : 1.0;
  Pose X = Pose::Identity();
  X.linear() = rotation_z(-radians * row[1]) * rotation_x(other * radians * row[2]) *
               rotation_y(other * radians * row[3]);
  X.translation() = centre_m + Eigen::Vector3d(row[4], row[5], row[6]) - X.linear() * centre_m;
  return X;
}

TEST(OpenSimTable, TheColumnsPutThePoseTogetherOnBothSides)
{
  for (const Side side : {Side::right, Side::left}) {
    for (const bool is_plain : {false, true}) {
      SCOPED_TRACE(side == Side::left ? "left" : "right");
      const FlexionMotion motion = turning_motion(side == Side::left ? "left" : "right");
      // Angles in radians about the rotation centre, or in degrees of the mesh origin.
      const Table table =
          parsed_table(opensim_table(motion, {opensim_columns("knee", side), is_plain, 45.0, is_plain}));
      ASSERT_EQ(table.rows.size(), motion.frames.size());
      const Eigen::Vector3d centre_m = (is_plain ? 0.0 : 1e-3) * motion.rotation_centre_mm;
      for (std::size_t i = 0; i < table.rows.size(); ++i) {
        Pose expected = motion.frames[i].pose.X_reference_moving;
        expected.translation() *= 1e-3;
        const Pose found =
            pose_of_coordinates(table.rows[i], is_plain ? rad_from_deg(1.0) : 1.0, side, centre_m);
        EXPECT_LT((found.matrix() - expected.matrix()).cwiseAbs().maxCoeff(), pose_rounding);
        EXPECT_NEAR(table.rows[i][0], motion.frames[i].flexion_deg / 45.0, 1e-15);
      }
    }
  }
}

TEST(OpenSimTable, ColumnsAreNamedByJointAndSide)
{
  EXPECT_THAT(
      opensim_columns("knee", Side::left),
      testing::ElementsAre("knee_flex_l", "knee_add_l", "knee_rot_l", "knee_tx_l", "knee_ty_l", "knee_tz_l"));
  EXPECT_EQ(opensim_columns("hip", Side::right)[0], "hip_flex_r");
  EXPECT_EQ(opensim_columns("other", Side::left)[5], "joint_tz_l");
}

TEST(OpenSimTable, ATitleCannotBreakTheHeader)
{
  FlexionMotion motion = turning_motion("right");
  motion.title = "a=b\nendheader\tc";
  const Table table =
      parsed_table(opensim_table(motion, {opensim_columns("knee", Side::right), false, 30.0}));
  EXPECT_THAT(table.name, Not(HasSubstr("endheader")));
  EXPECT_THAT(table.name, Not(HasSubstr("=")));
  EXPECT_EQ(table.keys.size(), 6U);
  EXPECT_EQ(table.rows.size(), motion.frames.size());
}

}  // namespace vrda::tables::tables_test
