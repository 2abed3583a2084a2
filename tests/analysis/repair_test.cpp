#include "analysis/repair.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <functional>

#include "analysis/scenes.hpp"
#include "analysis/score.hpp"
#include "core/units.hpp"
#include "support/meshes.hpp"
#include "support/refusal.hpp"

namespace vrda::analysis::repair_test {

// Surfaces are kept this far apart (repair.cpp); limits count as met within it.
constexpr double margin_mm = 5e-4;
// The quadratic programmes end at an excess of 1e-6 standard deviations, of 1 mm here.
constexpr double programme_mm = 1e-5;

RepairOptions still_options(double mm, double deg)
{
  RepairOptions options;
  options.noise = test::isotropic_noise(mm, deg);
  options.smoothing = Smoothing::none;
  options.gap_limit = GapLimit::none;
  return options;
}

RepairOptions limited_options(double gap_limit_mm)
{
  RepairOptions options = still_options(1, 1);
  options.gap_limit = GapLimit::of_length;
  options.gap_limit_mm = gap_limit_mm;
  return options;
}

// A plate whose lower face is at y = 10, over a ball of 10 mm around the origin with its pole on +Y.
AuditScene ball_under_plate(const SolverFrame& frame = {})
{
  return make_audit_scene(test::box({0, 15, 0}, {60, 10, 60}), test::ball(10), frame);
}

TEST(Repair, ABallPushedIntoAPlaneMovesBackAlongTheNormalAlone)
{
  constexpr double depth_mm = 0.8;
  const RepairedMotion found =
      repair(ball_under_plate(), test::resting_motion(1, {0, depth_mm, 0}), still_options(1, 1));
  const RepairedFrame& frame = found.frames.front();
  EXPECT_TRUE(found.is_converged);
  EXPECT_EQ(frame.status, FrameStatus::repaired);
  EXPECT_NEAR(frame.before.audit.penetration_mm, depth_mm, programme_mm);
  EXPECT_FALSE(frame.after.audit.is_overlapping);
  Vector6d expected = Vector6d::Zero();
  expected(4) = -depth_mm - margin_mm;  // standard deviations of 1 mm
  EXPECT_LT((frame.displacement - expected).cwiseAbs().maxCoeff(), programme_mm);
  EXPECT_NEAR(frame.X_reference_moving.translation().y(), -margin_mm, programme_mm);
}

TEST(Repair, NoiseByAxisMovesAlongItsCovarianceTimesTheNormal)
{
  // minimise |t / s|^2 with n . t >= d: t = S n d / (n . S n)
  const Eigen::Matrix3d R = rotation_z(rad_from_deg(25)) * rotation_x(rad_from_deg(10));
  Pose X_tilt = Pose::Identity();
  X_tilt.linear() = R;
  const Mesh ball = test::ball(10);
  const AuditScene scene =
      make_audit_scene(transformed(test::box({0, 14.5, 0}, {60, 10, 60}), X_tilt), ball, {});
  const Eigen::Vector3d normal = -R.col(1);
  const double depth_mm = (ball.vertices_mm * R.col(1)).maxCoeff() - 9.5;
  ASSERT_GT(depth_mm, 0.3);
  RepairOptions options = still_options(1, 0);  // rotations exact
  options.noise.translation_mm << 0.5, 1.0, 2.0;
  const Eigen::Vector3d variance = options.noise.translation_mm.cwiseAbs2();
  const Eigen::Vector3d along = variance.cwiseProduct(normal);
  const Eigen::Vector3d expected = along * ((depth_mm + margin_mm) / normal.dot(along));
  const RepairedMotion found = repair(scene, test::resting_motion(1, {0, 0, 0}), options);
  const RepairedFrame& frame = found.frames.front();
  EXPECT_LT((frame.X_reference_moving.translation() - expected).norm(), programme_mm);
  EXPECT_EQ(frame.X_reference_moving.linear(), Eigen::Matrix3d::Identity());
  EXPECT_NEAR(frame.displacement.norm(), expected.cwiseQuotient(options.noise.translation_mm).norm(),
              programme_mm / 0.5);
}

TEST(Repair, TwoBallsPartAlongTheLineOfTheirCentres)
{
  constexpr double radius_mm = 10.0, overlap_mm = 0.5;
  // A facet spans 180 / 96 degrees: sagitta and slope of both balls.
  constexpr double facet_rad = pi / 96, sagitta_mm = 2 * radius_mm * facet_rad * facet_rad / 8;
  const Mesh ball = test::ball(radius_mm, 96, 192);
  const Eigen::Vector3d centres = Eigen::Vector3d(0.3, -1.0, 0.2).normalized();
  const Eigen::Vector3d start = (2 * radius_mm - overlap_mm) * centres;
  const RepairedMotion found =
      repair(make_audit_scene(ball, ball, {}), test::resting_motion(1, start), still_options(1, 0));
  EXPECT_EQ(found.frames.front().status, FrameStatus::repaired);
  const Eigen::Vector3d moved = found.frames.front().X_reference_moving.translation() - start;
  EXPECT_NEAR(moved.norm(), overlap_mm + margin_mm, 2 * sagitta_mm);
  EXPECT_LT((moved.normalized() - centres).norm(), 2 * facet_rad);
}

TEST(Repair, AMotionThatMeetsItsLimitsStaysAsItIs)
{
  MeasuredMotion motion = test::resting_motion(9, {0, -0.5, 0});
  for (std::size_t k = 0; k < 9; ++k)
    motion.X_reference_moving[k].translation().x() = 0.1 * static_cast<double>(k % 3);
  const RepairedMotion found = repair(ball_under_plate(), motion, limited_options(0.6));
  for (std::size_t k = 0; k < 9; ++k) {
    EXPECT_EQ(found.frames[k].status, FrameStatus::unchanged);
    EXPECT_EQ(found.frames[k].X_reference_moving.matrix(), motion.X_reference_moving[k].matrix());
    EXPECT_TRUE(found.frames[k].displacement.isZero(0.0));
    EXPECT_NEAR(found.frames[k].after.audit.gap_mm, 0.5, programme_mm);
  }
}

TEST(Repair, AJointThatCameApartIsBroughtBackToTheLimit)
{
  const RepairedMotion found =
      repair(ball_under_plate(), test::resting_motion(1, {0, -1.5, 0}), limited_options(0.2));
  EXPECT_EQ(found.frames.front().status, FrameStatus::repaired);
  EXPECT_NEAR(found.frames.front().displacement(4), 1.3, margin_mm);
  EXPECT_NEAR(found.frames.front().after.audit.gap_mm, 0.2, margin_mm);
}

TEST(Repair, TheMeasurementLimitsTheGapByItsMedianAndItsRealSpread)
{
  // Gaps of 0.4 mm in most frames: no spread. One frame of 2 mm comes back to 0.4 mm, nearer ones stay.
  MeasuredMotion motion = test::resting_motion(21, {0, -0.4, 0});
  motion.X_reference_moving[7].translation().y() = -2.0;
  motion.X_reference_moving[12].translation().y() = -0.1;
  RepairOptions options = still_options(0.1, 0.1);
  options.gap_limit = GapLimit::from_measurement;
  const RepairedMotion found = repair(ball_under_plate(), motion, options);
  ASSERT_EQ(found.gap_limit_mm.size(), 1U);
  EXPECT_NEAR(found.gap_limit_mm.front(), 0.4, programme_mm);
  EXPECT_NEAR(found.frames[7].after.audit.gap_mm, 0.4, margin_mm);
  EXPECT_EQ(found.frames[12].status, FrameStatus::unchanged);
  EXPECT_NEAR(found.frames[12].after.audit.gap_mm, 0.1, programme_mm);
}

TEST(Repair, TwoOverlappingCondylesEndInContact)
{
  // Both sides overlap, one more than the other.
  const AuditScene scene = test::condyle_scene();
  std::mt19937_64 generator(3);
  MeasuredMotion motion = test::resting_motion(5, {0, 0, 0});
  motion.X_reference_moving = test::contact_motion(scene, 5, generator);
  for (Pose& X : motion.X_reference_moving) {
    X.translation().y() += 1.5;
    X.prerotate(rotation_x(rad_from_deg(1.5)));
  }
  RepairOptions options = still_options(0.5, 1);
  options.gap_limit = GapLimit::of_length;
  const RepairedMotion found = repair(scene, motion, options);
  EXPECT_TRUE(found.is_converged);
  for (const RepairedFrame& frame : found.frames) {
    EXPECT_EQ(frame.status, FrameStatus::repaired);
    EXPECT_GT(frame.before.audit.penetration_mm, 0.5);
    EXPECT_LE(frame.after.audit.penetration_mm, repair_tolerance_mm);
    EXPECT_LE(frame.after.audit.gap_mm, repair_tolerance_mm);
  }
}

TEST(Repair, LimitsThatNoDisplacementMeetsAreNotConverged)
{
  RepairOptions options = still_options(0, 1);  // translations exact
  const RepairedMotion found = repair(ball_under_plate(), test::resting_motion(1, {0, 0.5, 0}), options);
  EXPECT_EQ(found.frames.front().status, FrameStatus::not_converged);
  EXPECT_FALSE(found.is_converged);
  EXPECT_GT(found.frames.front().after.audit.penetration_mm, repair_tolerance_mm);
  EXPECT_EQ(found.frames.front().X_reference_moving.translation(), Eigen::Vector3d(0, 0.5, 0));
}

TEST(Repair, BesideTheReferenceNothingIsAhead)
{
  RepairOptions options = still_options(1, 1);
  options.gap_limit = GapLimit::from_measurement;
  const RepairedMotion found = repair(ball_under_plate(), test::resting_motion(3, {200, 0, 0}), options);
  for (const RepairedFrame& frame : found.frames) {
    EXPECT_EQ(frame.status, FrameStatus::nothing_ahead);
    EXPECT_TRUE(frame.displacement.isZero(0.0));
  }
}

struct Trial {
  AuditScene scene = test::condyle_scene();
  MeasuredMotion measured;
  std::vector<Pose> X_true;
  RepairOptions options;
};

Trial noisy_trial(unsigned seed, std::size_t n)
{
  Trial trial;
  std::mt19937_64 generator(seed);
  trial.measured = test::resting_motion(n, {0, 0, 0});
  trial.X_true = test::contact_motion(trial.scene, n, generator);
  trial.options.noise = test::isotropic_noise(0.4, 0.6);
  trial.measured.X_reference_moving = test::with_noise(trial.X_true, trial.options.noise, generator);
  trial.options.gap_limit = GapLimit::of_length;
  return trial;
}

void expect_same(const RepairedMotion& a, const RepairedMotion& b)
{
  ASSERT_EQ(a.frames.size(), b.frames.size());
  EXPECT_EQ(a.n_iterations, b.n_iterations);
  for (std::size_t k = 0; k < a.frames.size(); ++k) {
    EXPECT_EQ(a.frames[k].X_reference_moving.matrix(), b.frames[k].X_reference_moving.matrix()) << k;
    EXPECT_EQ(a.frames[k].after.audit.gap_mm, b.frames[k].after.audit.gap_mm) << k;
  }
}

TEST(Repair, AnyNumberOfThreadsGivesTheSameBits)
{
  Trial trial = noisy_trial(11, 14);
  const RepairedMotion one = repair(trial.scene, trial.measured, trial.options);
  trial.options.n_threads = 3;
  expect_same(one, repair(trial.scene, trial.measured, trial.options));
}

// Distance and largest overlap and gap over the trials with that smoothing.
struct Score {
  int n_nearer = 0, n_frames_beyond = 0;
  double mean_share = 0.0;  ///< distance from the truth after / before
};

Score score_of(Smoothing smoothing, int n_trials)
{
  Score score;
  for (int seed = 0; seed < n_trials; ++seed) {
    Trial trial = noisy_trial(static_cast<unsigned>(1000 + seed), 12);
    trial.options.smoothing = smoothing;
    trial.options.n_threads = 2;
    const RepairedMotion found = repair(trial.scene, trial.measured, trial.options);
    const double before =
        test::distance_from(trial.X_true, trial.measured.X_reference_moving, trial.options.noise);
    const double after = test::distance_from(trial.X_true, test::poses_of(found), trial.options.noise);
    score.n_nearer += after < before ? 1 : 0;
    score.mean_share += after / before / n_trials;
    for (const RepairedFrame& frame : found.frames) {
      const bool is_met = frame.after.audit.penetration_mm <= repair_tolerance_mm &&
                          frame.after.audit.gap_mm <= repair_tolerance_mm;
      score.n_frames_beyond += is_met ? 0 : 1;
    }
  }
  return score;
}

TEST(Repair, OfAHundredNoisyMotionsInContactNinetyFiveComeNearerToTheTruth)
{
  const Score smooth = score_of(Smoothing::from_noise, 100);
  EXPECT_GE(smooth.n_nearer, 95);
  EXPECT_EQ(smooth.n_frames_beyond, 0);
  // Second differences of 12 frames leave 4 to 5 of 12 numbers of each coordinate free.
  EXPECT_LT(smooth.mean_share, 0.75);
  RecordProperty("mean_share_smooth", std::to_string(smooth.mean_share));
  const Score contact = score_of(Smoothing::none, 100);
  EXPECT_GE(contact.n_nearer, 95);
  EXPECT_EQ(contact.n_frames_beyond, 0);
  EXPECT_GT(contact.mean_share, smooth.mean_share);
  RecordProperty("mean_share_contact", std::to_string(contact.mean_share));
}

// Both bodies in other coordinates: the same displacements.
TEST(Repair, MovingBothBodiesTogetherChangesNothing)
{
  Trial trial = noisy_trial(5, 8);
  // One weight for all coordinates: weights from the noise are of each axis, and the axes turn.
  trial.options.smoothing = Smoothing::of_period;
  trial.options.period_frames = 6.0;
  const RepairedMotion here = repair(trial.scene, trial.measured, trial.options);
  Pose G = Pose::Identity();
  G.linear() = rotation_x(0.4) * rotation_z(-0.7);
  G.translation() << 300, -200, 100;
  SolverFrame frame;
  frame.rotation_centre_mm = G.translation();
  frame.delta = G.linear().col(1);
  const AuditScene scene = make_audit_scene(transformed(trial.scene.reference.mesh(), G),
                                            transformed(trial.scene.moving.mesh(), G), frame);
  MeasuredMotion there = trial.measured;
  for (Pose& X : there.X_reference_moving) X = G * X * G.inverse();
  const RepairedMotion found = repair(scene, there, trial.options);
  ASSERT_EQ(found.frames.size(), here.frames.size());
  for (std::size_t k = 0; k < here.frames.size(); ++k) {
    const Pose X = G.inverse() * found.frames[k].X_reference_moving * G;
    // Steps end at changes of 1e-3 standard deviations, of 0.4 mm.
    EXPECT_LT((X.translation() - here.frames[k].X_reference_moving.translation()).norm(), 2e-3) << k;
    EXPECT_NEAR(found.frames[k].displacement.norm(), here.frames[k].displacement.norm(), 5e-3) << k;
  }
}

TEST(Repair, ALeftJointIsTheMirrorImageOfARightOne)
{
  Trial trial = noisy_trial(6, 6);
  const RepairedMotion right = repair(trial.scene, trial.measured, trial.options);
  const AuditScene scene =
      make_audit_scene(mirrored_z(trial.scene.reference.mesh()), mirrored_z(trial.scene.moving.mesh()),
                       {Side::left, Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitY()});
  MeasuredMotion left = trial.measured;
  for (Pose& X : left.X_reference_moving) X = reflected(X);
  const RepairedMotion found = repair(scene, left, trial.options);
  for (std::size_t k = 0; k < right.frames.size(); ++k) {
    EXPECT_EQ(found.frames[k].X_reference_moving.matrix(),
              reflected(right.frames[k].X_reference_moving).matrix())
        << k;
  }
}

TEST(Repair, Refusals)
{
  struct Row {
    const char* field;
    std::function<void(MeasuredMotion&, RepairOptions&)> edit;
  };
  for (const Row& row : std::vector<Row>{
           {"--noise-mm, --noise-deg", [](auto&, auto&o) { o = still_options(0, 0); }},
           {"--noise-mm", [](auto&, auto&o) { o = still_options(-1, 1); }},
           {"--noise-deg", [](auto&, auto&o) { o = still_options(1, nan); }},
           {"--smooth", [](auto&, auto&o) { o.smoothing = Smoothing::of_period, o.period_frames = 2.0; }},
           {"--gap-mm", [](auto&, auto&o) { o.gap_limit = GapLimit::of_length, o.gap_limit_mm = -0.1; }},
           {"key of frame 3", [](auto&m, auto&) { m.key[2] = m.key[1]; }},
           {"key of frame 2", [](auto&m, auto&) { m.key[1] = nan; }},
           {"frame 2 (key 1)", [](auto&m, auto&) { m.X_reference_moving[1].translation().x() = nan; }},
           {"frame 3 (key 2)", [](auto&m, auto&) { m.X_reference_moving[2].linear() *= 1.001; }},
           {"frame 2 (key 1)", [](auto&m, auto&) { m.X_reference_moving[1].linear() = rotation_z(1.6); }},
           {"frames", [](auto&m, auto&) {
              m = test::resting_motion(0, {0, 0, 0});
            }}}) {
    SCOPED_TRACE(row.field);
    MeasuredMotion motion = test::resting_motion(3, {0, -1, 0});
    RepairOptions options = still_options(1, 1);
    row.edit(motion, options);
    EXPECT_THAT(test::input_error([&] { repair(ball_under_plate(), motion, options); }),
                test::refuses({.file = "motion.csv", .field = row.field}));
  }
}

// Derivatives against central differences, for features of each kind away from contact.
TEST(FeatureMeasure, GradientsMatchDifferences)
{
  using Kind = solve::ContactConstraint::Kind;
  Pose X = Pose::Identity();
  X.linear() = rotation_x(0.2) * rotation_z(-0.3) * rotation_y(0.4);
  X.translation() << 1, -3, 2;
  for (const Kind kind : {Kind::face_of_reference, Kind::face_of_moving, Kind::edges}) {
    FeatureConstraint feature;
    feature.contact.kind = kind;
    feature.contact.reference_mm << 2, 1, -1;
    feature.contact.moving_mm << 0.5, 5, -4;
    feature.contact.reference_direction = Eigen::Vector3d(0.3, -1, 0.2).normalized();
    feature.contact.moving_direction =
        kind == Kind::edges ? Eigen::Vector3d(0.9, 0.1, 0.5) : Eigen::Vector3d(-0.2, -1, 0.1);
    feature.contact.moving_direction.normalize();
    feature.sign = -1.0;
    const FeatureMeasure at = measured(feature, X);
    constexpr double step = 1e-5;  // its square, times second derivatives of some tens, is the error
    for (Eigen::Index c = 0; c < 6; ++c) {
      const auto moved = [&](double by) {
        Pose Y = X;
        if (c < 3) {
          Y.linear() = rotation_of(by * Eigen::Vector3d::Unit(c)) * X.linear();
        } else {
          Y.translation()(c - 3) += by;
        }
        return measured(feature, Y);
      };
      const FeatureMeasure low = moved(-step), high = moved(step);
      EXPECT_NEAR(at.separation.gradient(c), (high.separation.mm - low.separation.mm) / (2 * step), 1e-7)
          << c;
      EXPECT_NEAR(at.travel.gradient(c), (high.travel.mm - low.travel.mm) / (2 * step), 1e-7) << c;
    }
  }
}

}  // namespace vrda::analysis::repair_test
