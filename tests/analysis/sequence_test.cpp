#include "analysis/score.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "analysis/moving_joint.hpp"
#include "store/motion.hpp"
#include "support/models.hpp"
#include "support/refusal.hpp"

namespace vrda::analysis::sequence_test {

// Rounding of angles of some 100 degrees and lengths of some 100 mm to a matrix and back.
constexpr double rounding = 1e-12;
const Eigen::Vector3d centre_mm(3, -8, 5);

Convention convention_of(const store::MotionModel& model)
{
  return {model.side == "left" ? Side::left : Side::right, model.rotation_centre_mm,
          Translations::rotation_centre};
}

store::PoseCoordinates drift(double flexion_deg, double varus_deg)
{
  return {0.05 * flexion_deg, -0.02 * flexion_deg + 0.1 * varus_deg, 0.3,
          0.1 * flexion_deg - 0.2 * varus_deg};
}

store::MotionModel free_model(const std::string& side = "right")
{
  test::ModelPlan plan;
  plan.side = side;
  plan.varus_deg = {0};
  plan.rotation_centre_mm = centre_mm;
  plan.motion = drift;
  plan.free_varus_deg = [](double flexion_deg) { return 0.04 * flexion_deg - 1.0; };
  return test::model_of(plan);
}

void expect_near(const Coordinates& value, const Coordinates& expected, double tolerance)
{
  for (std::size_t c = 0; c < n_scored; ++c)
    EXPECT_NEAR(value[c], expected[c], tolerance) << joint_coordinate_names[c];
}

TEST(ScoreCoordinates, OfThePoseOfCoordinatesAreTheSame)
{
  for (const Side side : {Side::right, Side::left}) {
    for (const Translations translations : {Translations::rotation_centre, Translations::mesh_origin}) {
      Convention convention{side, centre_mm, translations};
      if (translations == Translations::mesh_origin)
        convention.long_axis = Eigen::Vector3d(0.5, 0.6, -0.2).normalized();
      for (int k = 0; k < 24; ++k) {
        const Coordinates value = test::moving_coordinates(k, 24);
        const Pose X = right_sided_pose(value, convention);
        expect_near(coordinates_of(X, right_sided(convention)), value, rounding);
        const Pose X_own = side == Side::left ? reflected(X) : X;
        expect_near(coordinates_of(X_own, convention), value, rounding);
      }
    }
  }
}

TEST(ScoreCoordinates, AboutTheAxesOfDeltaAreThoseOfTheAttitude)
{
  // flexion, varus and theta of a pose made about a Delta other than +Y, on both sides
  for (const Side side : {Side::right, Side::left}) {
    Convention convention{side, centre_mm, Translations::rotation_centre};
    convention.long_axis = Eigen::Vector3d(0.5, 0.6, -0.2).normalized();
    const SolverFrame frame{side, centre_mm, *convention.long_axis};
    const Pose X = X_reference_moving(frame, {0.7, -0.1}, {{1, 2, 3}, 0.2});
    const Coordinates value = coordinates_of(X, convention);
    EXPECT_NEAR(value[0], 0.7, rounding);
    EXPECT_NEAR(value[1], -0.1, rounding);
    EXPECT_NEAR(value[2], 0.2, rounding);
    convention.long_axis.reset();
    EXPECT_GT(std::abs(coordinates_of(X, convention)[1] + 0.1), 0.01);
  }
}

TEST(ScoreCoordinates, OfTheMeshOriginAreTheTranslationOfThePose)
{
  const Pose X = test::rigid_transform(0.1, 0.2, -0.9, {4, 5, 6});
  for (const Side side : {Side::right, Side::left}) {
    const Coordinates found = coordinates_of(X, {side, centre_mm, Translations::mesh_origin});
    EXPECT_EQ(Eigen::Vector3d(found[3], found[4], found[5]),
              Eigen::Vector3d(4, 5, side == Side::left ? -6 : 6));
  }
}

TEST(ScoreSequence, OverFlexionIsLinearBetweenTheRows)
{
  Sequence found{"found", "flexion_deg", {}, {}};
  for (const double flexion_deg : {0.0, 10.0, 30.0}) {
    found.key.push_back(flexion_deg);
    found.rows.push_back({{rad_from_deg(flexion_deg), 0.01 * flexion_deg, 0, -flexion_deg, 7, 0}});
  }
  Sequence measured{"measured", "frame", {}, {}};
  for (const double flexion_deg : {25.0, 4.0, 10.0, 30.0, 0.0, 25.0, -1.0, 31.0}) {
    measured.key.push_back(static_cast<double>(measured.key.size()));
    measured.rows.push_back({{rad_from_deg(flexion_deg), 0, 0, 0, 0, 0}});
  }
  const std::vector<Row> rows = rows_over_flexion(found, measured, false);
  for (std::size_t k = 0; k < 6; ++k) {
    SCOPED_TRACE(k);
    const double flexion_rad = measured.rows[k].value[0], flexion_deg = deg_from_rad(flexion_rad);
    EXPECT_EQ(rows[k].missing, "");
    expect_near(rows[k].value, {flexion_rad, 0.01 * flexion_deg, 0, -flexion_deg, 7, 0}, rounding);
  }
  EXPECT_EQ(rows[6].missing, outside_range);
  EXPECT_EQ(rows[7].missing, outside_range);
}

TEST(ScoreSequence, OfAModelWithFreeVarusAreItsStoredPoses)
{
  for (const std::string side : {"right", "left"}) {
    const store::MotionModel model = free_model(side);
    ASSERT_TRUE(is_sequence(model, "raw"));
    const Sequence s = sequence_of("m.h5", model, "raw", convention_of(model));
    ASSERT_EQ(s.rows.size(), 7u);
    EXPECT_EQ(s.key_name, "flexion_deg");
    for (Eigen::Index i = 0; i < 7; ++i) {
      const Coordinates& value = s.rows[static_cast<std::size_t>(i)].value;
      for (std::size_t c = 0; c < n_joint_coordinates; ++c)
        EXPECT_NEAR(in_file(value[c], c), model.clinical[c](i, 0), rounding);
    }
  }
}

TEST(ScoreSequence, OfFramesAreMatchedByTheirKeys)
{
  // frames may repeat a flexion in any order; each row is one frame
  store::MotionModel model = free_model();
  const std::vector<double> ascending = model.flexion_deg;
  model.frames = store::FrameSequence{"time_s", {0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6}};
  model.flexion_deg = {0, 15, 30, 45, 30, 15, 0};
  const Sequence s = sequence_of("m.h5", model, "raw", convention_of(model));
  EXPECT_EQ(s.key_name, "time_s");
  EXPECT_EQ(s.key, model.frames->key);
  Sequence measured = s;
  measured.key = {0.5, 0.15, 0.0, 0.1, 0.2, 0.3, 0.4};
  const std::vector<Row> rows = rows_by_key(s, measured);
  EXPECT_NEAR(deg_from_rad(rows[0].value[0]), ascending[5], rounding);
  EXPECT_EQ(rows[1].missing, no_such_key);
  EXPECT_NEAR(deg_from_rad(rows[2].value[0]), ascending[0], rounding);
}

TEST(ScoreSequence, AHoleIsCrossedOnlyOnRequest)
{
  store::MotionModel model = free_model();
  test::unsolve(model, 2, 0);  // 30 degrees
  const Sequence found = sequence_of("m.h5", model, "raw", convention_of(model));
  Sequence measured{"measured", "frame", {0, 1, 2, 3}, {}};
  for (const double flexion_deg : {15.0, 20.0, 30.0, 45.0})
    measured.rows.push_back({{rad_from_deg(flexion_deg), 0, 0, 0, 0, 0}});
  const std::vector<Row> rows = rows_over_flexion(found, measured, false);
  EXPECT_EQ(rows[0].missing, "");
  EXPECT_EQ(rows[1].missing, unsolved_cell);
  EXPECT_EQ(rows[2].missing, unsolved_cell);
  EXPECT_EQ(rows[3].missing, "");
  const std::vector<Row> bridged = rows_over_flexion(found, measured, true);
  for (std::size_t c = 1; c < n_scored; ++c) {
    const double first = found.rows[1].value[c], second = found.rows[3].value[c];
    EXPECT_EQ(bridged[2].missing, "");
    EXPECT_NEAR(bridged[2].value[c], 0.5 * (first + second), rounding);
    EXPECT_NEAR(bridged[1].value[c], first + (second - first) / 6.0, rounding);
  }
}

TEST(ScoreSequence, FlexionsThatDoNotAscendAreRefused)
{
  Sequence found = test::moving_sequence(12);
  found.file = "found.csv";
  const auto facts = test::input_error([&] { rows_over_flexion(found, found, false); });
  EXPECT_THAT(facts, test::refuses({.file = "found.csv", .field = "flexion"}));
}

/// Poses of `model` at some attitudes as a measurement.
Sequence measured_at(const store::MotionModel& model, const std::vector<Attitude>& attitudes)
{
  const store::Motion motion(model, "raw");
  std::vector<Pose> poses;
  std::vector<double> key;
  for (const Attitude& attitude : attitudes) {
    poses.push_back(motion.at(attitude).X_reference_moving);
    key.push_back(static_cast<double>(key.size()));
  }
  return sequence_of("measured", "frame", key, poses, convention_of(model));
}

TEST(ScoreSequence, AGridIsEvaluatedAtTheMeasuredAttitude)
{
  // the attitude about the model's own axes is found for any Delta, also one that depends on flexion
  for (const std::string side : {"right", "left"}) {
    for (const bool turns : {false, true}) {
      test::ModelPlan plan;
      plan.side = side;
      plan.rotation_centre_mm = centre_mm;
      plan.delta = Eigen::Vector3d(0.3, 0.9, -0.2).normalized();
      plan.motion = drift;
      if (turns)
        plan.turning_delta = [](double f) { return Eigen::Vector3d(0.004 * f, 1.0, 0.1).normalized(); };
      const store::MotionModel model = test::model_of(plan);
      ASSERT_FALSE(is_sequence(model, "raw"));
      const Sequence measured =
          measured_at(model, {{0.0, 0.0}, {0.51, 0.03}, {1.2, -0.05}, {rad_from_deg(90), rad_from_deg(4)}});
      const std::vector<Row> rows = rows_at_attitudes(model, "raw", measured, convention_of(model));
      for (std::size_t k = 0; k < rows.size(); ++k) {
        EXPECT_EQ(rows[k].missing, "");
        // The flexion that chose Delta is known to 1e-12 rad.
        expect_near(rows[k].value, measured.rows[k].value, 1e-10);
      }
    }
  }
}

TEST(ScoreSequence, OfAGridBeyondItsAxesIsNotEvaluated)
{
  store::MotionModel model = test::model_of({});
  Sequence measured = measured_at(model, {{0.5, 0.0}, {0.5, 0.0}, {0.5, 0.0}});
  measured.rows[0].value[0] = rad_from_deg(91);
  measured.rows[1].value[1] = rad_from_deg(-4.1);
  test::unsolve(model, 2, 2);  // 30 degrees, no varus
  measured.rows[2].missing = "no_contact";
  measured.rows.push_back({{rad_from_deg(29), 0, 0, 0, 0, 0}});
  model.theta_determined(5, 1) = 0;  // 75 degrees, -2 degrees of varus
  measured.rows.push_back({{rad_from_deg(80), rad_from_deg(-1), 0, 0, 0, 0}});
  const std::vector<Row> rows = rows_at_attitudes(model, "raw", measured, convention_of(model));
  EXPECT_EQ(rows[0].missing, outside_range);
  EXPECT_EQ(rows[1].missing, outside_range);
  EXPECT_EQ(rows[2].missing, "no_contact");
  EXPECT_EQ(rows[3].missing, unsolved_cell);
  EXPECT_EQ(rows[4].missing, "");
  EXPECT_FALSE(rows[4].is_determined[at_internal]);
  EXPECT_TRUE(rows[4].is_determined[at_flexion]);
}

TEST(ScoreSequence, OfAGridAsMeasurementAreItsCells)
{
  test::ModelPlan plan;
  plan.motion = drift;
  store::MotionModel model = test::model_of(plan);
  test::unsolve(model, 0, 1);
  model.theta_determined(1, 0) = 0;
  const Sequence s = sequence_of("m.h5", model, "raw", convention_of(model));
  ASSERT_EQ(s.rows.size(), 35u);
  EXPECT_EQ(s.key_name, "cell");
  EXPECT_EQ(s.rows[1].missing, "no_contact");
  EXPECT_FALSE(s.rows[5].is_determined[at_internal]);
  EXPECT_NEAR(deg_from_rad(s.rows[14].value[1]), 4.0, rounding);
  EXPECT_NEAR(deg_from_rad(s.rows[14].value[0]), 30.0, rounding);
}

}  // namespace vrda::analysis::sequence_test
