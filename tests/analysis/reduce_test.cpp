// The zero-varus motion: choice of varus, poses, axes, rolling and sliding.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <cmath>

#include "analysis/reduce.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "model/coordinates.hpp"
#include "model/frames.hpp"
#include "store/motion.hpp"
#include "support/models.hpp"

namespace vrda::analysis::reduce_test {

using test::model_of;
using test::ModelPlan;

// Rounding of rotation products applied to coordinates of hundreds of mm.
constexpr double rounding_mm = 1e-11;
constexpr double rounding_deg = 1e-12;

const Eigen::Vector3d centre_mm(43.0, 51.0, 7.5);

/// Linear in varus. The left knee has the mirror image with -z.
store::PoseCoordinates knee_like(double flexion_deg, double varus_deg)
{
  const double u = flexion_deg / 90.0, v = varus_deg / 4.0;
  return {-5.0 * u * u + v, -21.0 + u - 0.5 * v, 1.5 * v - u, 12.0 * u - 2.0 * u * v};
}

/// Both compartments are in contact at -2 and 0 degrees of varus, so the zero varus of every flexion is -1.
/// The contact points are linear in varus.
store::MotionModel knee(const std::string& side, const Eigen::Vector3d& delta = {0, 1, 0})
{
  const double mirror = side == "left" ? -1.0 : 1.0;
  ModelPlan plan;
  plan.side = side;
  plan.rotation_centre_mm = {centre_mm.x(), centre_mm.y(), mirror * centre_mm.z()};
  plan.delta = {delta.x(), delta.y(), mirror * delta.z()};
  plan.motion = [mirror](double flexion_deg, double varus_deg) {
    store::PoseCoordinates numbers = knee_like(flexion_deg, varus_deg);
    numbers[2] *= mirror;
    return numbers;
  };
  store::MotionModel model = model_of(plan);
  model.is_in_contact[0] << 0, 1, 1, 1, 1, 0, 1, 1, 1, 1, 0, 1, 1, 1, 1, 0, 1, 1, 1, 1, 0, 1, 1, 1, 1, 0, 1,
      1, 1, 1, 0, 1, 1, 1, 1;
  model.is_in_contact[1].leftCols(3).setOnes();
  model.is_in_contact[1].rightCols(2).setZero();
  const std::size_t n_varus = model.varus_deg.size();
  store::ContactPaths& paths = *model.contact_paths;
  for (std::size_t cell = 0; cell < model.flexion_deg.size() * n_varus; ++cell) {
    const double u = model.flexion_deg[cell / n_varus] / 90.0, v = model.varus_deg[cell % n_varus];
    const auto put = [&](std::vector<double>& path, double x_mm, double y_mm, double z_mm) {
      path[3 * cell] = x_mm;
      path[3 * cell + 1] = y_mm;
      path[3 * cell + 2] = mirror * z_mm;
    };
    put(paths[0].reference_mm, -20.0 * u, -22.0 + 10.0 * u, -20.0 + v);
    put(paths[0].moving_mm, -6.0 * u, 1.0, -20.0 + v);
    put(paths[1].reference_mm, -18.0 * u, -20.0 + 9.0 * u, 22.0 + v);
    put(paths[1].moving_mm, -12.0 * u, 1.0, 22.0 + v);
  }
  return model;
}

Pose pose_at(const store::ZeroVarus& z, std::size_t i)
{
  Pose X = Pose::Identity();
  X.matrix() = Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(&z.X_reference_moving[16 * i]);
  return X;
}

Eigen::Vector3d row3(const std::vector<double>& rows, std::size_t i)
{
  return {rows[3 * i], rows[3 * i + 1], rows[3 * i + 2]};
}

double difference(const Pose& a, const Pose& b)
{
  return (a.matrix() - b.matrix()).cwiseAbs().maxCoeff();
}

TEST(Reduce, PosesLieBetweenTheTwoColumns)
{
  for (const Eigen::Vector3d& delta :
       {Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(Eigen::Vector3d(0.1, 1.0, -0.3).normalized())}) {
    const store::MotionModel model = knee("right", delta);
    const store::ZeroVarus z = reduce(model, "raw");
    EXPECT_EQ(n_reduced_flexions(z), 7);
    const SolverFrame frame{Side::right, model.rotation_centre_mm, model.delta};
    for (std::size_t i = 0; i < model.flexion_deg.size(); ++i) {
      EXPECT_EQ(z.source[i], static_cast<std::int8_t>(store::ZeroVarusSource::both_touch));
      EXPECT_EQ(z.varus_deg[i], -1.0);
      EXPECT_EQ(z.varus_first_deg[i], -2.0);
      EXPECT_EQ(z.varus_last_deg[i], 0.0);
      const store::PoseCoordinates expected = knee_like(model.flexion_deg[i], -1.0);
      EXPECT_NEAR(z.tx_mm[i], expected[0], rounding_mm);
      EXPECT_NEAR(z.ty_mm[i], expected[1], rounding_mm);
      EXPECT_NEAR(z.tz_mm[i], expected[2], rounding_mm);
      EXPECT_NEAR(z.theta_deg[i], expected[3], rounding_deg);
      const MovingPose moving{solver_translation_mm(frame, {expected[0], expected[1], expected[2]}),
                              rad_from_deg(expected[3])};
      const Attitude attitude{rad_from_deg(model.flexion_deg[i]), rad_from_deg(-1.0)};
      EXPECT_LT(difference(pose_at(z, i), X_reference_moving(frame, attitude, moving)), rounding_mm);
    }
  }
}

TEST(Reduce, ACellItselfIsTakenToTheLastBit)
{
  store::MotionModel model = knee("right");
  model.is_in_contact[0].col(1).setZero();
  const store::ZeroVarus z = reduce(model, "raw");
  const std::size_t cell = 4 * model.varus_deg.size() + 2;
  EXPECT_EQ(z.varus_deg[4], 0.0);
  EXPECT_EQ(z.ty_mm[4], model.ty_mm(4, 2));
  for (std::size_t k = 0; k < 16; ++k)
    EXPECT_EQ(z.X_reference_moving[16 * 4 + k], model.X_reference_moving[16 * cell + k]);
  EXPECT_EQ(z.clinical[JointCoordinate::anterior][4], model.clinical[JointCoordinate::anterior](4, 2));
  EXPECT_EQ(z.centres[0].moving_mm[3 * 4], model.contact_paths->at(0).moving_mm[3 * cell]);
}

TEST(Reduce, AHingeIsFound)
{
  // The tibia is hinged at a point q of the femur, relative to the rotation centre: t = Rz(flexion) q - q.
  const Eigen::Vector3d q(4.0, -9.0, 0.0);
  ModelPlan plan;
  plan.rotation_centre_mm = centre_mm;
  plan.motion = [&q](double flexion_deg, double) {
    const Eigen::Vector3d t = rotation_z(rad_from_deg(flexion_deg)) * q - q;
    return store::PoseCoordinates{t.x(), t.y(), t.z(), 0.0};
  };
  store::MotionModel model = model_of(plan);
  const store::ZeroVarus z = reduce(model, "raw");  // both contacts in all columns: varus 0
  ASSERT_EQ(z.helical_rotation_deg.size(), 6u);
  for (std::size_t k = 0; k < 6; ++k) {
    EXPECT_NEAR(z.helical_rotation_deg[k], 15.0, rounding_deg);
    EXPECT_NEAR(z.helical_translation_mm[k], 0.0, rounding_mm);
    EXPECT_LT((row3(z.helical_direction, k) + Eigen::Vector3d::UnitZ()).norm(), rounding_deg);
    EXPECT_LT((row3(z.helical_point_mm, k) - (centre_mm + q)).norm(), rounding_mm);
    EXPECT_NEAR(z.instant_centre_mm[2 * k], centre_mm.x() + q.x(), rounding_mm);
    EXPECT_NEAR(z.instant_centre_mm[2 * k + 1], centre_mm.y() + q.y(), rounding_mm);
  }
}

TEST(Reduce, ContactPointsLieBetweenTheColumnsToo)
{
  store::MotionModel model = knee("right");
  const double nan = std::numeric_limits<double>::quiet_NaN();
  // At flexion 1 the medial contact of the column at 0 is not known, at flexion 2 both are not.
  const std::size_t n_varus = model.varus_deg.size();
  for (const std::size_t cell : {n_varus + 2, 2 * n_varus + 1, 2 * n_varus + 2}) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      model.contact_paths->at(0).reference_mm[3 * cell + axis] = nan;
      model.contact_paths->at(0).moving_mm[3 * cell + axis] = nan;
    }
  }
  const store::ZeroVarus z = reduce(model, "raw");
  EXPECT_NEAR(z.centres[0].reference_mm[2], -21.0, rounding_mm);  // z = -20 + varus
  EXPECT_NEAR(z.centres[0].reference_mm[3 + 2], -22.0, rounding_mm);
  EXPECT_NEAR(z.centres[1].moving_mm[3 + 2], 21.0, rounding_mm);
  EXPECT_TRUE(std::isnan(z.centres[0].reference_mm[2 * 3 + 2]));
  for (const std::size_t k : {1u, 2u}) {
    EXPECT_TRUE(std::isnan(z.rolling[0].rolling_mm[k]));
    EXPECT_TRUE(std::isnan(z.rolling[0].sliding_mm[k]));
    EXPECT_FALSE(std::isnan(z.rolling[1].rolling_mm[k]));
  }
  EXPECT_FALSE(std::isnan(z.rolling[0].rolling_mm[0]));
  EXPECT_FALSE(std::isnan(z.rolling[0].sliding_mm[3]));
  // Per step the condyle's contact moves back by 20/6 and up by 10/6 mm, the plateau's back by 1 mm. Femur
  // and tibia differ by half a step of flexion and theta at the start, which changes lengths by a cosine
  // only.
  const double travel_mm = std::sqrt(500.0) / 6.0, out_of_plane = rad_from_deg(15.0);
  EXPECT_NEAR(z.rolling[0].rolling_mm[0], -1.0, rounding_mm);
  EXPECT_NEAR(z.rolling[0].sliding_mm[0], travel_mm - 1.0, travel_mm * out_of_plane * out_of_plane / 2.0);
}

TEST(Reduce, ASmoothedSetIsEvaluatedAtTheVarusOfTheRawCells)
{
  store::MotionModel model = knee("right");
  test::add_smoothed(model, 2, [](int i, int j) {
    return store::PoseCoordinates{i - 2.0 * j, -20.0 + i, 0.5 * j, i == 1 && j == 0 ? 4.0 : 0.1 * i};
  });
  const store::ZeroVarus z = reduce(model, "degree_2");
  const store::Motion motion(model, "degree_2");
  for (std::size_t i = 0; i < model.flexion_deg.size(); ++i) {
    const store::JointPose expected = motion.at({rad_from_deg(model.flexion_deg[i]), rad_from_deg(-1.0)});
    EXPECT_EQ(z.varus_deg[i], -1.0);
    EXPECT_LT(difference(pose_at(z, i), expected.X_reference_moving), rounding_mm);
    EXPECT_NEAR(z.theta_deg[i], deg_from_rad(expected.theta_rad), rounding_deg);
    const Eigen::Vector3d t_mm = expected.X_world_moving * model.rotation_centre_mm;
    EXPECT_LT((Eigen::Vector3d(z.tx_mm[i], z.ty_mm[i], z.tz_mm[i]) - t_mm).norm(), rounding_mm);
  }
  // Not the raw poses.
  EXPECT_GT(std::abs(z.ty_mm[3] - reduce(model, "raw").ty_mm[3]), 0.1);
}

TEST(Reduce, TheSetZeroVarusHasThePosesOfTheTable)
{
  for (const std::string side : {"right", "left"}) {
    store::MotionModel model = knee(side, Eigen::Vector3d(0.1, 1.0, -0.3).normalized());
    model.zero_varus = reduce(model, "raw");
    const store::Motion motion(model, "zero_varus");
    for (std::size_t i = 0; i < model.flexion_deg.size(); ++i) {
      const store::JointPose pose = motion.at({rad_from_deg(model.flexion_deg[i]), 0.0});
      EXPECT_EQ(pose.status, store::PoseStatus::solved);
      EXPECT_LT(difference(pose.X_reference_moving, pose_at(*model.zero_varus, i)), rounding_mm);
    }
  }
}

TEST(Reduce, ARecontactedSetMayHaveNoAnswer)
{
  store::MotionModel model = knee("right");
  test::add_smoothed(model, 1, [](int i, int) { return store::PoseCoordinates{1.0 * i, -20.0, 0.0, 2.0}; });
  store::GridD travel_mm = store::GridD::Constant(7, 5, 0.25);
  travel_mm(2, 1) = std::numeric_limits<double>::quiet_NaN();  // next to the varus of -1
  model.smoothed.front().recontact_mm = travel_mm;
  const store::ZeroVarus plain = reduce(model, "degree_1"),
                         recontacted = reduce(model, "degree_1_recontacted");
  EXPECT_EQ(n_reduced_flexions(plain), 7);
  EXPECT_EQ(n_reduced_flexions(recontacted), 6);
  EXPECT_EQ(recontacted.source[2], static_cast<std::int8_t>(store::ZeroVarusSource::none));
  EXPECT_TRUE(std::isnan(recontacted.varus_first_deg[2]));
  EXPECT_NEAR(recontacted.ty_mm[5], plain.ty_mm[5] + 0.25, rounding_mm);
}

TEST(Reduce, ASmoothedFreeVarusIsTheSetsOwn)
{
  ModelPlan plan;
  plan.varus_deg = {0};
  plan.free_varus_deg = [](double flexion_deg) { return 0.1 * flexion_deg; };
  store::MotionModel model = model_of(plan);
  test::add_smoothed(model, 1, [](int, int) { return store::PoseCoordinates{0.0, -20.0, 3.0, 8.0}; });
  store::SmoothedSet& set = model.smoothed.front();
  store::SmoothedSurface varus = set.surfaces.front();
  varus.name = "varus";
  varus.coefficients.assign(varus.coefficients.size(), 0.0);
  for (std::size_t k = 0; k < varus.coefficients.size(); ++k) {
    const auto term = set.exponents.row(static_cast<Eigen::Index>(k));
    varus.coefficients[k] = term(1) != 0 ? 0.0 : term(0) == 0 ? 5.0 : 4.0;  // 5 + 4 P_1
  }
  set.surfaces.push_back(varus);
  const store::ZeroVarus z = reduce(model, "degree_1");
  for (std::size_t i = 0; i < model.flexion_deg.size(); ++i) {
    EXPECT_EQ(z.source[i], static_cast<std::int8_t>(store::ZeroVarusSource::free));
    EXPECT_NEAR(z.varus_deg[i], 1.0 + 8.0 * model.flexion_deg[i] / 90.0, rounding_deg);
    EXPECT_NEAR(z.clinical[JointCoordinate::varus][i], z.varus_deg[i], rounding_deg);
  }
}

TEST(Reduce, AFreeVarusNeedsNoCompartments)
{
  ModelPlan plan;
  plan.varus_deg = {0};
  plan.free_varus_deg = [](double flexion_deg) { return 1.0 + 0.01 * flexion_deg; };
  plan.motion = knee_like;
  store::MotionModel model = model_of(plan);
  model.joint = "other";
  model.has_compartments = false;
  model.contact_paths.reset();
  EXPECT_TRUE(is_reducible(model));
  const store::ZeroVarus z = reduce(model, "raw");
  for (std::size_t i = 0; i < model.flexion_deg.size(); ++i) {
    EXPECT_EQ(z.source[i], static_cast<std::int8_t>(store::ZeroVarusSource::free));
    EXPECT_EQ(z.varus_deg[i], 1.0 + 0.01 * model.flexion_deg[i]);
    EXPECT_EQ(z.tx_mm[i], model.tx_mm(static_cast<Eigen::Index>(i), 0));
    EXPECT_EQ(z.clinical[JointCoordinate::internal][i],
              model.clinical[JointCoordinate::internal](static_cast<Eigen::Index>(i), 0));
    EXPECT_TRUE(std::isnan(z.varus_first_deg[i]));
  }
  EXPECT_TRUE(z.centres[0].reference_mm.empty());
  EXPECT_TRUE(z.rolling[1].sliding_mm.empty());
  EXPECT_EQ(z.helical_direction.size(), 18u);
}

TEST(Reduce, AFlexionWithoutAnAnswerLeavesAHole)
{
  store::MotionModel model = knee("right");
  for (Eigen::Index j = 0; j < 5; ++j) test::unsolve(model, 3, j);
  const store::ZeroVarus z = reduce(model, "raw");
  EXPECT_EQ(n_reduced_flexions(z), 6);
  EXPECT_EQ(z.source[3], static_cast<std::int8_t>(store::ZeroVarusSource::none));
  EXPECT_TRUE(std::isnan(z.varus_deg[3]));
  EXPECT_TRUE(std::isnan(z.X_reference_moving[16 * 3]));
  EXPECT_TRUE(std::isnan(z.centres[0].moving_mm[3 * 3]));
  for (const std::size_t k : {2u, 3u}) {
    EXPECT_TRUE(std::isnan(z.helical_rotation_deg[k]));
    EXPECT_TRUE(std::isnan(z.helical_point_mm[3 * k]));
    EXPECT_TRUE(std::isnan(z.instant_centre_mm[2 * k]));
    EXPECT_TRUE(std::isnan(z.rolling[1].rolling_mm[k]));
  }
  EXPECT_FALSE(std::isnan(z.helical_rotation_deg[1]));
}

TEST(Reduce, OneFlexionHasNoSteps)
{
  ModelPlan plan;
  plan.flexion_deg = {20};
  const store::ZeroVarus z = reduce(model_of(plan), "raw");
  EXPECT_EQ(n_reduced_flexions(z), 1);
  EXPECT_TRUE(z.helical_rotation_deg.empty());
}

// Rounding of a root: a product and a quotient of degrees below 10.
constexpr double root_rounding_deg = 1e-14;

/// One flexion with columns at -4, -2, 0, 2 and 4 degrees and these contacts: B both, m medial, l lateral, x
/// unsolved. `imbalance_mm` per column (NaN: the medial side faces nothing); the spine is at the middle one.
store::MotionModel row_of(const std::string& marks,
                          const std::vector<double>& imbalance_mm = {4, 2, 0.5, -1, -3})
{
  ModelPlan plan;
  plan.flexion_deg = {30};
  store::MotionModel model = model_of(plan);
  for (Eigen::Index j = 0; j < model.status.cols(); ++j) {
    const char mark = marks[static_cast<std::size_t>(j)];
    const double imbalance = imbalance_mm[static_cast<std::size_t>(j)];
    model.is_in_contact[0](0, j) = mark == 'B' || mark == 'm' ? 1 : 0;
    model.is_in_contact[1](0, j) = mark == 'B' || mark == 'l' ? 1 : 0;
    model.gap_mm[0](0, j) = imbalance < 0.0 ? 0.0 : imbalance;
    model.gap_mm[1](0, j) = imbalance > 0.0 ? 0.0 : -imbalance;
    if (mark == 'x') test::unsolve(model, 0, j);
  }
  return model;
}

VarusChoice choice_of(const store::MotionModel& model)
{
  return varus_choices(model, store::Motion(model, "raw")).at(0);
}

TEST(VarusChoice, ByContactsAndGaps)
{
  using enum store::ZeroVarusSource;
  struct Case {
    const char* marks;
    std::vector<double> imbalance_mm;
    store::ZeroVarusSource source;
    double first_deg, last_deg, varus_deg;
    Eigen::Index before, after;
    double weight_after;
    bool is_cut_off;
  };
  const std::vector<double> falling{4, 2, 0.5, -1, -3};
  for (const Case& c :
       {Case{"llBmm", falling, both_touch, 0, 0, 0, 2, 2, 0.0, false},
        Case{"lBBBm", falling, both_touch, -2, 2, 0, 2, 2, 0.0, false},
        Case{"llBBm", falling, both_touch, 0, 2, 1, 2, 3, 0.5, false},
        Case{"BBBBB", falling, both_touch, -4, 4, 0, 2, 2, 0.0, true},
        // A hole between columns in contact does not split the run.
        Case{"lBxBm", falling, both_touch, -2, 2, 0, 1, 3, 0.5, false},
        Case{"BxxBm", falling, both_touch, -4, 2, -1, 0, 3, 0.5, true},
        // Of two runs the one nearest to the spine at 0; only the border of that one matters.
        Case{"BllBm", falling, both_touch, 2, 2, 2, 3, 3, 0.0, false},
        Case{"BlBBm", falling, both_touch, 0, 2, 1, 2, 3, 0.5, false},
        Case{"llmBB", falling, both_touch, 2, 4, 3, 3, 4, 0.5, true},
        Case{"lmBBx", falling, both_touch, 0, 2, 1, 2, 3, 0.5, false},
        // Without both contacts the root of the imbalance: 0.5 mm at 0 degrees, -1 mm at 2.
        Case{"lllmm", falling, interpolated, nan, nan, 2.0 / 3.0, 2, 3, 1.0 / 3.0, false},
        Case{"llllm", {3, 2, 1, 0, -1}, interpolated, nan, nan, 2, 3, 3, 0.0, false},
        // 2 mm at -2 degrees, -3 mm at 4: columns without gaps count for the pose only, unsolved ones not.
        Case{"lllxm", {4, 2, nan, -1, -3}, interpolated, nan, nan, 0.4, 2, 4, 0.1, false},
        // Nothing changes its sign.
        Case{"lllll", {5, 4, 3, 2, 1}, none, nan, nan, nan, 0, 0, 0.0, false},
        Case{"xxxxx", falling, none, nan, nan, nan, 0, 0, 0.0, false},
        Case{"xxlxx", falling, none, nan, nan, nan, 0, 0, 0.0, false}}) {
    SCOPED_TRACE(c.marks);
    const VarusChoice choice = choice_of(row_of(c.marks, c.imbalance_mm));
    EXPECT_EQ(choice.source, c.source);
    EXPECT_THAT(choice.first_deg, testing::NanSensitiveDoubleEq(c.first_deg));
    EXPECT_THAT(choice.last_deg, testing::NanSensitiveDoubleEq(c.last_deg));
    EXPECT_THAT(choice.varus_deg, testing::NanSensitiveDoubleNear(c.varus_deg, root_rounding_deg));
    EXPECT_EQ(choice.before, c.before);
    EXPECT_EQ(choice.after, c.after);
    EXPECT_NEAR(choice.weight_after, c.weight_after, root_rounding_deg);
    EXPECT_EQ(choice.is_cut_off, c.is_cut_off);
  }
}

TEST(VarusChoice, AColumnAMereRoundingAwayIsMeant)
{
  store::MotionModel model = row_of("lBBBm");
  model.varus_deg[2] += 1e-13;
  const VarusChoice choice = choice_of(model);
  EXPECT_EQ(choice.before, 2);
  EXPECT_EQ(choice.after, 2);
}

TEST(VarusChoice, OfSeveralRootsTheNearestToTheSpine)
{
  // Roots at -3, 1 and 3.
  store::MotionModel model = row_of("lmlml", {1, -1, -1, 1, -1});
  EXPECT_NEAR(choice_of(model).varus_deg, 1.0, root_rounding_deg);
  model.is_spine.setZero();
  model.is_spine(0, 0) = 1;
  EXPECT_NEAR(choice_of(model).varus_deg, -3.0, root_rounding_deg);
  // Of two at equal distance the lower.
  EXPECT_NEAR(choice_of(row_of("lmmll", {1, -1, -1, -1, 1})).varus_deg, -3.0, root_rounding_deg);
  EXPECT_NEAR(choice_of(row_of("lmmml", {-1, 1, 1, -1, -1})).varus_deg, 1.0, root_rounding_deg);
}

TEST(VarusChoice, AFreeVarusIsTaken)
{
  ModelPlan plan;
  plan.varus_deg = {0};
  plan.free_varus_deg = [](double flexion_deg) { return 1.0 + 0.01 * flexion_deg; };
  store::MotionModel model = model_of(plan);
  model.is_in_contact[0].setZero();
  test::unsolve(model, 2, 0);
  const std::vector<VarusChoice> choices = varus_choices(model, store::Motion(model, "raw"));
  ASSERT_EQ(choices.size(), 7u);
  EXPECT_EQ(choices[1].source, store::ZeroVarusSource::free);
  EXPECT_EQ(choices[1].varus_deg, 1.0 + 0.01 * 15.0);
  EXPECT_EQ(choices[2].source, store::ZeroVarusSource::none);
}

constexpr double wheel_rounding_mm = 1e-12;
constexpr double wheel_mm = 22.0;

/// A wheel (reference, axis Z, centre at its origin) on a plane (moving, Y = 0), flexed and `x_mm` forward.
CompartmentContact wheel_on_plane(double flexion_rad, double x_mm)
{
  Pose X_moving_reference = Pose::Identity();
  X_moving_reference.linear() = rotation_z(flexion_rad);
  X_moving_reference.translation() = Eigen::Vector3d(x_mm, wheel_mm, 0.0);
  CompartmentContact contact;
  contact.X_reference_moving = X_moving_reference.inverse();
  contact.p_moving_mm = {x_mm, 0.0, 0.0};
  contact.p_reference_mm = contact.X_reference_moving * contact.p_moving_mm;
  return contact;
}

// The wheel's contact moves back by the chord of the turn, that of the plane by the way of the wheel.
TEST(Rolling, IsTheCommonWayAndSlidingTheDifference)
{
  struct Row {
    const char* name;
    double turn_deg, forward_mm;
    bool rolls_by_turn;  ///< else by the way on the plane
  };
  for (const Row& row : {Row{"spins in place", 3.0, 0.0, false}, Row{"locked", 0.0, -2.5, true},
                         Row{"a condyle: rolls back a third, slides forward", 6.0, -0.7, false},
                         Row{"skids further than it turns", 2.0, -2.3, true}}) {
    SCOPED_TRACE(row.name);
    const double turn_rad = rad_from_deg(row.turn_deg), chord_mm = 2.0 * wheel_mm * sine(0.5 * turn_rad);
    const Rolling found =
        rolling_between(wheel_on_plane(0.2, 4.0), wheel_on_plane(0.2 + turn_rad, 4.0 + row.forward_mm));
    EXPECT_NEAR(found.reference_mm, -chord_mm, wheel_rounding_mm);
    EXPECT_NEAR(found.moving_mm, row.forward_mm, wheel_rounding_mm);
    EXPECT_NEAR(found.rolling_mm, row.rolls_by_turn ? -chord_mm : row.forward_mm, wheel_rounding_mm);
    EXPECT_NEAR(found.sliding_mm, row.forward_mm + chord_mm, wheel_rounding_mm);
  }
  // Opposite ways share nothing.
  EXPECT_EQ(rolling_between(wheel_on_plane(0.2, 0.0), wheel_on_plane(0.25, 1.0)).rolling_mm, 0.0);
}

TEST(Rolling, AWheelThatRollsDoesNotSlide)
{
  const double turn_rad = rad_from_deg(1.0);
  for (const double start_deg : {0.0, 45.0, 130.0}) {
    SCOPED_TRACE(start_deg);
    const double start_rad = rad_from_deg(start_deg), end_rad = start_rad + turn_rad;
    const CompartmentContact start = wheel_on_plane(start_rad, -wheel_mm * start_rad);
    const CompartmentContact end = wheel_on_plane(end_rad, -wheel_mm * end_rad);
    const Rolling rolling = rolling_between(start, end);
    // With increasing flexion it rolls backwards. A chord is shorter than its arc by angle^2 / 24.
    const double arc_mm = wheel_mm * turn_rad, sagged_mm = arc_mm * turn_rad * turn_rad / 24.0;
    EXPECT_NEAR(rolling.rolling_mm, -arc_mm, sagged_mm);
    EXPECT_NEAR(rolling.sliding_mm, 0.0, sagged_mm);
    // The centre of the finite rotation is on the radius to the mid-contact: r (a / 2) / sin(a / 2).
    const auto turning_mm =
        instant_centre_mm(start.X_reference_moving, end.X_reference_moving, Eigen::Vector3d::Zero());
    ASSERT_TRUE(turning_mm);
    const Eigen::Vector3d middle = rotation_z(-0.5 * (start_rad + end_rad)) * Eigen::Vector3d(0.0, -1.0, 0.0);
    const double expected_mm = wheel_mm * 0.5 * turn_rad / sine(0.5 * turn_rad);
    EXPECT_LT((*turning_mm - expected_mm * middle.head<2>()).norm(), wheel_rounding_mm / turn_rad);
  }
}

}  // namespace vrda::analysis::reduce_test
