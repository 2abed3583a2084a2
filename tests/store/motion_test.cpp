#include <gtest/gtest.h>

#include <cmath>

#include "core/text.hpp"
#include "core/units.hpp"
#include "model/coordinates.hpp"
#include "store/motion.hpp"
#include "store/motion_model.hpp"
#include "support/models.hpp"

namespace vrda::motion_test {

using test::model_of;
using test::ModelPlan;

// Rounding of rotation products applied to coordinates of hundreds of mm.
constexpr double rounding = 1e-11;

Attitude attitude_deg(double flexion_deg, double varus_deg)
{
  return {rad_from_deg(flexion_deg), rad_from_deg(varus_deg)};
}

store::PoseCoordinates knee_like(double flexion_deg, double varus_deg)
{
  const double u = flexion_deg / 90.0, v = varus_deg / 4.0;
  return {-5.0 * u * u, -21.0 + u - 0.5 * v, 1.5 * v, 12.0 * u - 2.0 * u * v};
}

ModelPlan plan_of(const std::string& side, const Eigen::Vector3d& delta)
{
  ModelPlan plan;
  plan.side = side;
  plan.rotation_centre_mm = {430.0, 510.0, side == "left" ? -75.0 : 75.0};
  plan.delta = delta;
  plan.motion = knee_like;
  return plan;
}

Pose stored_pose(const store::MotionModel& model, std::size_t cell)
{
  Pose X = Pose::Identity();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) {
      X.matrix()(row, column) =
          model.X_reference_moving[cell * 16 + static_cast<std::size_t>(4 * row + column)];
    }
  }
  return X;
}

double difference(const Pose& a, const Pose& b)
{
  return (a.matrix() - b.matrix()).cwiseAbs().maxCoeff();
}

/// Expects the stored pose at every cell, and consistency of the three poses.
void expect_stored_poses(const store::MotionModel& model)
{
  const store::Motion motion(model, "raw");
  const std::size_t n_varus = model.varus_deg.size();
  for (std::size_t cell = 0; cell < model.flexion_deg.size() * n_varus; ++cell) {
    const store::JointPose pose =
        motion.at(attitude_deg(model.flexion_deg[cell / n_varus], model.varus_deg[cell % n_varus]));
    EXPECT_EQ(pose.status, store::PoseStatus::solved);
    EXPECT_LT(difference(pose.X_reference_moving, stored_pose(model, cell)), rounding);
    EXPECT_LT(difference(pose.X_world_reference * pose.X_reference_moving, pose.X_world_moving), rounding);
  }
}

TEST(Motion, RawPosesAreThoseOfTheModelAtEveryCell)
{
  const Eigen::Vector3d tilted = Eigen::Vector3d(0.1, 1.0, -0.3).normalized();
  for (const std::string side : {"right", "left"}) {
    expect_stored_poses(model_of(plan_of(side, {0, 1, 0})));
    expect_stored_poses(model_of(plan_of(side, tilted)));
  }
}

Eigen::Vector3d turning_delta(double flexion_deg)
{
  return Eigen::Vector3d(0.1 + 0.004 * flexion_deg, 1.0, -0.3 + 0.00005 * flexion_deg * flexion_deg)
      .normalized();
}

TEST(Motion, RawPosesAreThoseOfTheModelWhereDeltaTurnsOverFlexion)
{
  for (const std::string side : {"right", "left"}) {
    ModelPlan plan = plan_of(side, {0, 1, 0});
    plan.turning_delta = turning_delta;
    expect_stored_poses(model_of(plan));
  }
}

// The attitude and theta are the joint's own angles for Delta = +Y only.
TEST(Motion, TheJointsOwnAnglesAreThoseOfThePoseWhereDeltaIsNotProximal)
{
  for (const std::string side : {"right", "left"}) {
    const Eigen::Vector3d oblique = Eigen::Vector3d(0.3, 0.9, 0.1).normalized();
    const store::MotionModel turned = model_of(plan_of(side, oblique));
    const store::MotionModel proximal = model_of(plan_of(side, Eigen::Vector3d::UnitY()));
    const store::Motion motion(turned, "raw"), plain(proximal, "raw");
    const store::JointPose pose = motion.at(attitude_deg(40, 1)), other = plain.at(attitude_deg(40, 1));
    EXPECT_FALSE(plain.own_coordinates(other).has_value());
    ASSERT_TRUE(motion.own_coordinates(pose).has_value());
    const ClinicalCoordinates own = *motion.own_coordinates(pose);
    const ClinicalCoordinates expected = clinical_coordinates(
        pose.X_reference_moving, side == "left" ? Side::left : Side::right, turned.rotation_centre_mm);
    EXPECT_EQ(own.flexion_rad, expected.flexion_rad);
    EXPECT_EQ(own.lateral_mm, expected.lateral_mm);
    EXPECT_GT(std::abs(own.flexion_rad - pose.attitude.flexion_rad), rad_from_deg(0.1));
    store::JointPose unsolved = pose;
    unsolved.status = store::PoseStatus::unsolved_cell;
    EXPECT_FALSE(motion.own_coordinates(unsolved).has_value());
  }
}

TEST(Motion, DeltaIsLinearBetweenTheRowsHeldBeyondThemAndNormalised)
{
  for (const std::string side : {"right", "left"}) {
    SCOPED_TRACE(side);
    ModelPlan plan = plan_of(side, {0, 1, 0});
    plan.turning_delta = turning_delta;
    store::MotionModel model = model_of(plan);
    test::add_smoothed(model, 1, [](int, int) { return store::PoseCoordinates{1.0, -20.0, 3.0, 8.0}; });
    const store::Motion raw(model, "raw"), smoothed(model, "degree_1");
    struct Row {
      double flexion_deg;
      Eigen::Vector3d delta;
    };
    const Eigen::Vector3d at_30 = turning_delta(30), at_45 = turning_delta(45);
    for (const Row& row :
         {Row{35, (2.0 * at_30 + at_45).normalized()}, Row{45, at_45}, Row{0, turning_delta(0)},
          Row{90, turning_delta(90)}, Row{120, turning_delta(90)}}) {
      SCOPED_TRACE(row.flexion_deg);
      // A frame with constant Delta rotates the reference equally.
      ModelPlan constant = plan_of(side, row.delta);
      const Attitude attitude = attitude_deg(row.flexion_deg, 3);
      const Pose expected = store::Motion(model_of(constant), "raw").at(attitude).X_world_reference;
      for (const store::Motion* motion : {&raw, &smoothed}) {
        const store::JointPose pose = motion->at(attitude);
        EXPECT_EQ(pose.status, store::PoseStatus::solved);
        EXPECT_LT(difference(pose.X_world_reference, expected), rounding);
        // Delta is the rotation axis of theta.
        EXPECT_LT((pose.X_world_moving.linear() * row.delta - row.delta).norm(), rounding);
      }
    }
  }
}

TEST(Motion, AFreeVarusIsTheSolvedOneWhateverIsRequested)
{
  ModelPlan plan = plan_of("right", {0, 1, 0});
  plan.varus_deg = {0};
  plan.free_varus_deg = [](double flexion_deg) { return -1.0 + 0.001 * flexion_deg * flexion_deg; };
  store::MotionModel model = model_of(plan);
  test::unsolve(model, 5, 0);  // 75 degrees
  const store::Motion motion(model, "raw");
  EXPECT_TRUE(motion.is_varus_free());
  EXPECT_FALSE(store::Motion(model_of({}), "raw").is_varus_free());
  for (const double flexion_deg : {0.0, 15.0, 30.0, 45.0, 60.0, 90.0}) {
    const std::size_t cell = static_cast<std::size_t>(flexion_deg / 15.0);
    const double found_rad = rad_from_deg(plan.free_varus_deg(flexion_deg));
    const store::JointPose clamped = motion.at(attitude_deg(flexion_deg, 4.0));
    EXPECT_TRUE(clamped.is_varus_clamped);
    EXPECT_NEAR(clamped.attitude.varus_rad, found_rad, rounding);
    EXPECT_LT(difference(clamped.X_reference_moving, stored_pose(model, cell)), rounding);
    const store::JointPose balanced =
        motion.at({rad_from_deg(flexion_deg), motion.balanced_varus_rad(rad_from_deg(flexion_deg))});
    EXPECT_FALSE(balanced.is_varus_clamped);
    EXPECT_EQ(difference(balanced.X_reference_moving, clamped.X_reference_moving), 0.0);
  }
  EXPECT_NEAR(motion.balanced_varus_rad(rad_from_deg(20)), rad_from_deg(-1.0 + (2 * 0.225 + 0.9) / 3),
              rounding);
  EXPECT_EQ(motion.first_varus_rad(), rad_from_deg(-1.0));
  EXPECT_EQ(motion.last_varus_rad(), rad_from_deg(7.1));
  EXPECT_EQ(motion.at(attitude_deg(70, 0)).status, store::PoseStatus::unsolved_cell);
}

TEST(Motion, SmoothedPosesFollowThePolynomials)
{
  store::MotionModel model = model_of(plan_of("right", {0, 1, 0}));
  test::add_smoothed(model, 2, [](int i, int j) {
    return i == 1 && j == 0 ? store::PoseCoordinates{1.0, -2.0, 3.0, 8.0} : store::PoseCoordinates{};
  });
  const double u = 60.0 / 45.0 - 1.0;
  const store::JointPose pose = store::Motion(model, "degree_2").at(attitude_deg(60, 1));
  const SolverFrame frame{Side::right, model.rotation_centre_mm, model.delta};
  const Pose expected =
      X_reference_moving(frame, attitude_deg(60, 1), {u * Eigen::Vector3d(1, -2, 3), rad_from_deg(8.0 * u)});
  EXPECT_EQ(pose.status, store::PoseStatus::solved);
  EXPECT_LT(difference(pose.X_reference_moving, expected), rounding);
  EXPECT_NEAR(pose.theta_rad, rad_from_deg(8.0 * u), rounding);
}

TEST(Motion, AttitudesBeyondTheRangeAreClampedAndSaySo)
{
  const store::Motion motion(model_of(plan_of("right", {0, 1, 0})), "raw");
  struct Row {
    double flexion_deg, varus_deg, used_flexion_deg, used_varus_deg;
    bool is_flexion_clamped, is_varus_clamped;
  };
  for (const Row& row : {Row{120, 0, 90, 0, true, false}, Row{-1, 9, 0, 4, true, true},
                         Row{90, -4, 90, -4, false, false}, Row{10, -5, 10, -4, false, true}}) {
    SCOPED_TRACE(row.flexion_deg);
    const store::JointPose pose = motion.at(attitude_deg(row.flexion_deg, row.varus_deg));
    EXPECT_EQ(pose.is_flexion_clamped, row.is_flexion_clamped);
    EXPECT_EQ(pose.is_varus_clamped, row.is_varus_clamped);
    const store::JointPose at_the_end = motion.at(attitude_deg(row.used_flexion_deg, row.used_varus_deg));
    EXPECT_EQ(difference(pose.X_reference_moving, at_the_end.X_reference_moving), 0.0);
    EXPECT_EQ(pose.attitude.flexion_rad, rad_from_deg(row.used_flexion_deg));
  }
}

TEST(Motion, AMirroredModelMovesAsTheMirrorImageWithTheSameClinicalNumbers)
{
  const store::MotionModel right = model_of(plan_of("right", {0, 1, 0}));
  ModelPlan mirrored = plan_of("left", {0, 1, 0});
  mirrored.motion = [](double flexion_deg, double varus_deg) {
    store::PoseCoordinates numbers = knee_like(flexion_deg, varus_deg);
    numbers[2] = -numbers[2];
    return numbers;
  };
  const store::MotionModel left = model_of(mirrored);
  const store::Motion right_motion(right, "raw"), left_motion(left, "raw");
  const Eigen::Vector4d mirror(1, 1, -1, 1);
  for (const Attitude& attitude : {attitude_deg(0, 0), attitude_deg(37, -3.2), attitude_deg(88, 1.1)}) {
    const store::JointPose r = right_motion.at(attitude), l = left_motion.at(attitude);
    for (const auto X : {&store::JointPose::X_world_reference, &store::JointPose::X_world_moving,
                         &store::JointPose::X_reference_moving}) {
      const Eigen::Matrix4d reflected = mirror.asDiagonal() * (r.*X).matrix() * mirror.asDiagonal();
      EXPECT_LT(((l.*X).matrix() - reflected).cwiseAbs().maxCoeff(), rounding);
    }
    const ClinicalCoordinates r_numbers =
        clinical_coordinates(r.X_reference_moving, Side::right, right.rotation_centre_mm);
    const ClinicalCoordinates l_numbers =
        clinical_coordinates(l.X_reference_moving, Side::left, left.rotation_centre_mm);
    EXPECT_NEAR(r_numbers.flexion_rad, attitude.flexion_rad, rounding);
    EXPECT_NEAR(r_numbers.internal_rotation_rad, l_numbers.internal_rotation_rad, rounding);
    EXPECT_NEAR(r_numbers.lateral_mm, l_numbers.lateral_mm, rounding);
  }
}

TEST(Motion, TheBalancedVarusIsLinearBetweenSolvedSpineCells)
{
  store::MotionModel model = model_of({});
  model.is_spine.setZero();
  model.is_spine(0, 1) = model.is_spine(2, 3) = model.is_spine(4, 4) = model.is_spine(6, 2) = 1;
  test::unsolve(model, 4, 4);  // the spine cell at 60 degrees
  const store::Motion motion(model, "raw");
  struct Row {
    double flexion_deg, expected_deg;
  };
  for (const Row row :
       {Row{-5, -2}, Row{0, -2}, Row{15, 0}, Row{30, 2}, Row{60, 1}, Row{90, 0}, Row{99, 0}}) {
    EXPECT_NEAR(motion.balanced_varus_rad(rad_from_deg(row.flexion_deg)), rad_from_deg(row.expected_deg),
                rounding);
  }
  EXPECT_TRUE(motion.has_spine());
}

TEST(Motion, WithoutASpineTheBalancedVarusIsTheOneNearestZero)
{
  ModelPlan plan;
  plan.varus_deg = {3, 5};
  store::MotionModel model = model_of(plan);
  model.is_spine.setZero();
  const store::Motion motion(model, "raw");
  EXPECT_FALSE(motion.has_spine());
  EXPECT_EQ(motion.balanced_varus_rad(0.5), rad_from_deg(3));
}

// Poses of a model of another size.

constexpr double factor = 1.07;
constexpr double rounding_mm = 1e-9;  // of numbers up to 200 mm, some tens of operations

test::ModelPlan plan_of_size(double size)
{
  test::ModelPlan plan;
  plan.rotation_centre_mm = size * Eigen::Vector3d(12, -30, 7);
  plan.motion = [size](double flexion_deg, double varus_deg) {
    return store::PoseCoordinates{size * 0.02 * flexion_deg, size * (0.3 * varus_deg - 0.05 * flexion_deg),
                                  size * -0.1 * varus_deg, 0.1 * flexion_deg + varus_deg};
  };
  return plan;
}

store::MotionModel model_of_size(double size)
{
  store::MotionModel model = test::model_of(plan_of_size(size));
  test::add_smoothed(model, 2, [size](int i, int j) {
    const double one = 1.0 / (1 + i + 2 * j);
    return store::PoseCoordinates{size * one, -2.0 * size * one, 0.5 * size * one, 3.0 * one};
  });
  return model;
}

TEST(ScaledPoses, AreThoseOfAJointMadeAtThatSize)
{
  const store::MotionModel scaled = store::scaled_model(model_of_size(1.0), factor),
                           made = model_of_size(factor);
  for (const std::string set : {"raw", "degree_2"}) {
    SCOPED_TRACE(set);
    const store::Motion of_scaled(scaled, set), of_made(made, set);
    for (double flexion_deg = 0.0; flexion_deg <= 90.0; flexion_deg += 7.0) {
      const Attitude at{rad_from_deg(flexion_deg), rad_from_deg(1.3)};
      const store::JointPose a = of_scaled.at(at), b = of_made.at(at);
      EXPECT_TRUE(a.X_reference_moving.matrix().isApprox(b.X_reference_moving.matrix(), 1e-12));
      EXPECT_LT((a.X_reference_moving.translation() - b.X_reference_moving.translation()).norm(),
                rounding_mm);
      EXPECT_LT((a.X_world_moving.translation() - b.X_world_moving.translation()).norm(), rounding_mm);
      EXPECT_NEAR(a.theta_rad, b.theta_rad, 1e-12);
    }
  }
}

/// Frames whose flexion rises and falls, through a full turn of theta.
store::MotionModel sequence(const std::string& side, bool has_turning_delta)
{
  ModelPlan plan = plan_of(side, Eigen::Vector3d(0.1, 1.0, -0.3).normalized());
  plan.flexion_deg = {0, 15, 30, 45, 60, 75};
  plan.varus_deg = {0};
  plan.motion = [](double flexion_deg, double) -> store::PoseCoordinates {
    return {1.0, -20.0 + 0.01 * flexion_deg, 0.5,
            flexion_deg > 40 ? 178.0 - 360.0 + flexion_deg / 10.0 : 178.0 + flexion_deg / 100.0};
  };
  if (has_turning_delta)
    plan.turning_delta = [](double flexion_deg) {
      return Eigen::Vector3d(0.001 * flexion_deg, 1, 0).normalized();
    };
  return test::frames_of(model_of(plan), {2, 4, 5, 3, 1, 0}, {0.0, 0.1, 0.4, 0.9, 1.6, 2.5});
}

TEST(Sequence, PosesAreThoseOfTheFrames)
{
  for (const std::string side : {"right", "left"}) {
    for (const bool has_turning_delta : {false, true}) {
      const store::MotionModel model = sequence(side, has_turning_delta);
      const store::Motion motion(model, "raw");
      EXPECT_TRUE(motion.is_sequence());
      EXPECT_EQ(motion.key_name(), "time_s");
      EXPECT_EQ(motion.keys(), model.frames->key);
      for (std::size_t i = 0; i < motion.keys().size(); ++i) {
        const store::JointPose pose = motion.at_frame(motion.keys()[i]);
        ASSERT_EQ(pose.status, store::PoseStatus::solved);
        EXPECT_EQ(pose.key, motion.keys()[i]);
        EXPECT_LT(difference(pose.X_reference_moving, stored_pose(model, i)), rounding);
        EXPECT_LT(difference(pose.X_world_reference * pose.X_reference_moving, pose.X_world_moving),
                  rounding);
        const Eigen::Vector3d delta = model.push.delta.row(static_cast<Eigen::Index>(i)).transpose();
        EXPECT_LT((motion.delta_of(pose) - delta).norm(), 1e-15);
      }
    }
  }
}

TEST(Sequence, BetweenFramesAPoseFollowsItsNeighbours)
{
  const store::Motion motion(sequence("right", false), "raw");
  // Theta goes from 178.3 through 180 to -176 degrees by the short way.
  const store::JointPose half = motion.at_frame(0.05);
  EXPECT_GT(std::abs(deg_from_rad(half.theta_rad)), 176.0);
  // A thousandth of the first step.
  const store::JointPose start = motion.at_frame(0.0), near = motion.at_frame(1e-4);
  const double step = difference(start.X_reference_moving, motion.at_frame(0.1).X_reference_moving);
  EXPECT_LT(difference(start.X_reference_moving, near.X_reference_moving), 0.01 * step);
  EXPECT_GT(difference(start.X_reference_moving, near.X_reference_moving), 1e-4 * step);
  const store::JointPose before = motion.at_frame(-1.0), after = motion.at_frame(9.0);
  EXPECT_TRUE(before.is_flexion_clamped && after.is_flexion_clamped);
  EXPECT_EQ(before.key, 0.0);
  EXPECT_LT(difference(before.X_reference_moving, start.X_reference_moving), rounding);
}

TEST(Sequence, AFrameWithoutAPoseIsAHole)
{
  store::MotionModel model = sequence("right", false);
  test::unsolve(model, 2, 0);
  const store::Motion motion(model, "raw");
  EXPECT_EQ(motion.at_frame(0.4).status, store::PoseStatus::unsolved_cell);
  EXPECT_EQ(motion.at_frame(0.3).status, store::PoseStatus::unsolved_cell);
  EXPECT_EQ(motion.at_frame(0.1).status, store::PoseStatus::solved);
}

TEST(Sequence, IsNotEvaluatedByFlexion)
{
  const store::Motion motion(sequence("right", true), "raw"),
      grid(model_of(plan_of("right", {0, 1, 0})), "raw");
  EXPECT_THROW(motion.at({0.0, 0.0}), InternalError);
  EXPECT_THROW(motion.balanced_varus_rad(0.0), InternalError);
  EXPECT_THROW(motion.delta(0.0), InternalError);
  EXPECT_THROW(grid.at_frame(0.0), InternalError);
  EXPECT_THROW(grid.key_at(0.0), InternalError);
}

TEST(Sequence, PositionsCountFrames)
{
  const store::Motion motion(sequence("right", false), "raw");
  for (std::size_t i = 0; i < motion.keys().size(); ++i) {
    EXPECT_EQ(motion.key_at(static_cast<double>(i)), motion.keys()[i]);
    EXPECT_EQ(motion.position_of(motion.keys()[i]), static_cast<double>(i));
  }
  EXPECT_NEAR(motion.key_at(1.5), 0.25, 1e-15);
  EXPECT_NEAR(motion.position_of(0.25), 1.5, 1e-15);
  EXPECT_EQ(motion.key_at(-1.0), 0.0);
  EXPECT_EQ(motion.key_at(99.0), 2.5);
}

// Rounding of a dozen products and sums of numbers up to a hundred.
constexpr double few_products = 1e-12;

/// Degree two in each angle with all product terms.
store::PoseCoordinates biquadratic(double flexion_deg, double varus_deg)
{
  const double u = flexion_deg / 90.0, v = varus_deg / 4.0;
  return {1.0 + u + v + u * v, -20.0 + 3.0 * u * u - v * v, u * u * v * v - 2.0 * u * v * v,
          15.0 * u - 4.0 * u * u * v};
}

/// Not a polynomial, so that nothing is exact by accident.
store::PoseCoordinates wavy(double flexion_deg, double varus_deg)
{
  const double u = rad_from_deg(flexion_deg), v = rad_from_deg(varus_deg);
  return {sine(2.0 * u + v), cosine(u - 7.0 * v), sine(u * v), 20.0 * cosine(3.0 * u)};
}

TEST(RawSurfaces, GridValuesAreReproducedToTheLastBit)
{
  ModelPlan plan;
  plan.motion = wavy;
  const store::MotionModel model = model_of(plan);
  const store::RawSurfaces surfaces = store::raw_surfaces(model);
  for (const double flexion_deg : plan.flexion_deg) {
    for (const double varus_deg : plan.varus_deg) {
      const store::RawSample found = store::sample(surfaces, attitude_deg(flexion_deg, varus_deg));
      const store::PoseCoordinates expected = wavy(flexion_deg, varus_deg);
      ASSERT_TRUE(found.is_solved);
      for (std::size_t number = 0; number < 3; ++number) EXPECT_EQ(found.values[number], expected[number]);
      EXPECT_EQ(found.values[3], rad_from_deg(expected[3]));
    }
  }
}

TEST(RawSurfaces, SurfacesOfDegreeTwoInEachAngleAreReproducedBetweenTheCells)
{
  ModelPlan plan;
  plan.flexion_deg = {0, 10, 25, 30, 52, 90};  // uneven steps
  plan.varus_deg = {-4, -1, 0.5, 4};
  plan.motion = biquadratic;
  const store::RawSurfaces surfaces = store::raw_surfaces(model_of(plan));
  for (double flexion_deg = 0.0; flexion_deg <= 90.0; flexion_deg += 3.7) {
    for (double varus_deg = -4.0; varus_deg <= 4.0; varus_deg += 0.61) {
      const store::RawSample found = store::sample(surfaces, attitude_deg(flexion_deg, varus_deg));
      const store::PoseCoordinates expected = biquadratic(flexion_deg, varus_deg);
      ASSERT_TRUE(found.is_solved);
      for (std::size_t number = 0; number < 3; ++number) {
        EXPECT_NEAR(found.values[number], expected[number], few_products);
      }
      EXPECT_NEAR(found.values[3], rad_from_deg(expected[3]), few_products);
    }
  }
}

TEST(RawSurfaces, SlopesAreContinuousAcrossCells)
{
  ModelPlan plan;
  plan.motion = wavy;
  const store::RawSurfaces surfaces = store::raw_surfaces(model_of(plan));
  constexpr double step_rad = 1e-6;
  // Difference quotients err by half the second derivative (below 100) times the step, twice.
  constexpr double tolerance = 100.0 * step_rad;
  for (const double varus_deg : {-3.0, -2.0, 1.3}) {
    const Attitude node = attitude_deg(45, varus_deg);
    const store::PoseCoordinates here = store::sample(surfaces, node).values;
    const store::PoseCoordinates before =
        store::sample(surfaces, {node.flexion_rad - step_rad, node.varus_rad}).values;
    const store::PoseCoordinates after =
        store::sample(surfaces, {node.flexion_rad + step_rad, node.varus_rad}).values;
    for (std::size_t number = 0; number < 4; ++number) {
      EXPECT_NEAR((here[number] - before[number]) / step_rad, (after[number] - here[number]) / step_rad,
                  tolerance);
    }
  }
}

TEST(RawSurfaces, AttitudesBesideAnUnsolvedCellHaveNoAnswerAndOthersStayExact)
{
  ModelPlan plan;
  plan.varus_deg = {-6, -4, -2, 0, 2, 4, 6};  // enough columns for a parabola on each side of the hole
  plan.motion = biquadratic;
  store::MotionModel model = model_of(plan);
  test::unsolve(model, 3, 3);  // 45 degrees, varus 0
  const store::RawSurfaces surfaces = store::raw_surfaces(model);
  for (const Attitude& beside :
       {attitude_deg(45, 0), attitude_deg(40, 0), attitude_deg(50, 1), attitude_deg(31, -1)}) {
    EXPECT_FALSE(store::sample(surfaces, beside).is_solved);
  }
  // On the far edges of the patches around the hole, and in the patches next to those.
  for (const Attitude& away :
       {attitude_deg(30, 0), attitude_deg(30, 1), attitude_deg(60, 0), attitude_deg(45, 2),
        attitude_deg(45, -2), attitude_deg(20, 0), attitude_deg(70, 1), attitude_deg(50, 3)}) {
    const store::RawSample found = store::sample(surfaces, away);
    ASSERT_TRUE(found.is_solved) << away.flexion_rad << " " << away.varus_rad;
    const store::PoseCoordinates expected =
        biquadratic(deg_from_rad(away.flexion_rad), deg_from_rad(away.varus_rad));
    for (std::size_t number = 0; number < 3; ++number)
      EXPECT_NEAR(found.values[number], expected[number], few_products);
  }
}

TEST(RawSurfaces, ANodeMissedByRoundingNeedsNoneOfItsNeighbours)
{
  ModelPlan plan;
  plan.motion = biquadratic;
  store::MotionModel model = model_of(plan);
  test::unsolve(model, 2, 2);
  test::unsolve(model, 4, 2);
  const store::RawSurfaces surfaces = store::raw_surfaces(model);
  for (const double off_rad : {-1e-15, 1e-15}) {
    const store::RawSample found = store::sample(surfaces, {rad_from_deg(45) + off_rad, off_rad});
    EXPECT_TRUE(found.is_solved);
    EXPECT_EQ(found.values[1], model.ty_mm(3, 2));
  }
}

TEST(SmoothedSurfaces, AgreeWithTheLegendrePolynomialsWrittenOut)
{
  store::MotionModel model = test::model_of({});
  // x = P_3(u), y = P_2(u) P_1(v), z = P_0, theta = 10 degrees P_2(v)
  test::add_smoothed(model, 3, [](int i, int j) {
    return store::PoseCoordinates{i == 3 && j == 0 ? 1.0 : 0.0, i == 2 && j == 1 ? 1.0 : 0.0,
                                  i + j == 0 ? 1.0 : 0.0, i == 0 && j == 2 ? 10.0 : 0.0};
  });
  const store::SmoothedSurfaces surfaces = store::smoothed_surfaces(model, model.smoothed.front());
  for (const double flexion_deg : {0.0, 7.0, 45.0, 81.5, 90.0}) {
    for (const double varus_deg : {-4.0, -1.5, 0.0, 4.0}) {
      const store::PoseAndVarus found =
          store::evaluate(surfaces, {rad_from_deg(flexion_deg), rad_from_deg(varus_deg)});
      const double u = flexion_deg / 45.0 - 1.0, v = varus_deg / 4.0;
      EXPECT_NEAR(found[0], 0.5 * (5.0 * u * u * u - 3.0 * u), few_products);
      EXPECT_NEAR(found[1], 0.5 * (3.0 * u * u - 1.0) * v, few_products);
      EXPECT_NEAR(found[2], 1.0, few_products);
      EXPECT_NEAR(found[3], rad_from_deg(10.0) * 0.5 * (3.0 * v * v - 1.0), few_products);
    }
  }
}

/// A dozen operations on numbers near 1.
constexpr double dozen_operations = 1e-14;

store::SmoothedSet quadratic_set()
{
  store::SmoothedSet set;
  set.degree = 2;
  set.exponents.resize(6, 2);
  set.exponents << 0, 0, 1, 0, 0, 1, 2, 0, 1, 1, 0, 2;
  set.surfaces.resize(1);
  set.surfaces[0].coefficients = {1.0, 2.0, -3.0, 0.5, 0.25, -0.75};
  return set;
}

TEST(EvaluateSmoothed, ClosedForm)
{
  const store::SmoothedSet set = quadratic_set();
  const store::AxisRanges ranges{{0.0, 90.0}, {-10.0, 10.0}};
  for (const double flexion_deg : {0.0, 12.5, 45.0, 90.0, 95.0}) {
    for (const double varus_deg : {-10.0, 0.0, 3.0, 10.0}) {
      const double u = flexion_deg / 45.0 - 1.0, v = varus_deg / 10.0;
      EXPECT_NEAR(store::evaluate(set, set.surfaces[0], ranges, flexion_deg, varus_deg),
                  1.0 + 2.0 * u - 3.0 * v + 0.25 * (3 * u * u - 1) + 0.25 * u * v - 0.375 * (3 * v * v - 1),
                  10 * dozen_operations);
    }
  }
}

// Its polynomials are those at 0.
TEST(EvaluateSmoothed, OneValue)
{
  const store::SmoothedSet set = quadratic_set();
  const store::AxisRanges ranges{{0.0, 90.0}, {0.0, 0.0}};
  EXPECT_NEAR(store::evaluate(set, set.surfaces[0], ranges, 45.0, 7.0), 1.0 - 0.25 + 0.375, dozen_operations);
  EXPECT_THROW(store::axis_ranges({}, {0.0}), InternalError);
}

JointCoordinates follower_at(double flexion_deg, double varus_deg)
{
  JointCoordinates q;
  q << 0.013 * flexion_deg, -0.02 * varus_deg, 0.1 + 0.001 * flexion_deg, 3.0 - 0.3 * flexion_deg,
      -0.4 * flexion_deg, 0.2 * varus_deg;
  return q;
}

// Linear coordinates are exact between the cells; a second follower moves with the first, or with the tibia.
TEST(Followers, HaveTheirCoordinatesAtEveryAttitude)
{
  for (const std::string side : {"right", "left"}) {
    SCOPED_TRACE(side);
    store::MotionModel model = model_of(plan_of(side, {0, 1, 0}));
    const Eigen::Vector3d centre(470.0, 530.0, 10.0);
    test::add_follower(model, BodyIndex::reference, centre, follower_at);
    test::add_follower(model, model::follower_index(0), centre, follower_at);
    test::add_follower(model, BodyIndex::moving, centre, follower_at);
    const store::Motion motion(model, "raw");
    const store::JointPose pose = motion.at(attitude_deg(37.0, 1.3));
    const Pose own = follower_pose(follower_at(37.0, 1.3), side_named(side), centre);
    for (const std::size_t k : {0U, 1U, 2U}) ASSERT_TRUE(pose.has_follower[k]);
    EXPECT_FALSE(pose.has_follower[3]);
    EXPECT_LT((pose.X_reference_follower[0].matrix() - own.matrix()).norm(), 1e-9);
    EXPECT_LT((pose.X_reference_follower[1].matrix() - (own * own).matrix()).norm(), 1e-9);
    EXPECT_LT((pose.X_reference_follower[2].matrix() - (pose.X_reference_moving * own).matrix()).norm(),
              1e-9);
    EXPECT_LT(
        (pose.X_world(model::follower_index(0)).matrix() - (pose.X_world_reference * own).matrix()).norm(),
        1e-9);
  }
}

// Of the sample that a quantile is, not those of the solved attitude.
TEST(Followers, OfAQuantileAreThoseOfItsSample)
{
  const store::MotionModel model = test::whole_model();
  const store::FollowerRows& rows = model.followers.at(0);
  const std::size_t n = model.flexion_deg.size(), i = 2;
  for (const auto& [set, sample] :
       {std::pair{"quantile_5", std::size_t{0}}, std::pair{"quantile_95", std::size_t{0}},
        std::pair{"quantile_100", std::size_t{2}}}) {
    SCOPED_TRACE(set);
    const store::JointPose pose = store::Motion(model, set).at({rad_from_deg(model.flexion_deg[i]), 0.0});
    ASSERT_TRUE(pose.X_of(rows));
    const double value = 0.5 * static_cast<double>(sample * n + i);
    JointCoordinates wanted;
    for (Eigen::Index k = 0; k < 3; ++k) {
      wanted(k) = rad_from_deg(static_cast<double>(k + 1) * value);
      wanted(3 + k) = -static_cast<double>(k + 1) * value;
    }
    const Pose X = follower_pose(wanted, side_named(model.side), rows.centre_mm);
    EXPECT_LT((pose.X_of(rows)->matrix() - X.matrix()).norm(), 1e-9);
  }
}

// Beside a cell without a pose of its own it has none, nor has what follows it; the joint has.
TEST(Followers, HaveNoPoseBesideAnUnsolvedCell)
{
  store::MotionModel model = model_of(plan_of("right", {0, 1, 0}));
  test::add_follower(model, BodyIndex::reference, {0, 0, 0}, follower_at);
  test::add_follower(model, model::follower_index(0), {0, 0, 0}, follower_at);
  model.followers[0].status(2, 2) = static_cast<std::int8_t>(StepStatus::unbounded);
  const store::Motion motion(model, "raw");
  const store::JointPose beside = motion.at(attitude_deg(31.0, 0.5)),
                         away = motion.at(attitude_deg(70.0, 0.5));
  EXPECT_EQ(beside.status, store::PoseStatus::solved);
  EXPECT_FALSE(beside.has_follower[0]);
  EXPECT_FALSE(beside.has_follower[1]);
  EXPECT_TRUE(away.has_follower[0]);
  EXPECT_TRUE(away.has_follower[1]);
}

}  // namespace vrda::motion_test
