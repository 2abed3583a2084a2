// Gaps, penetration and recontact of single poses and of motions.
#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <random>

#include "analysis/audit.hpp"
#include "core/units.hpp"
#include "store/sample_model.hpp"
#include "support/directional_gap.hpp"
#include "support/meshes.hpp"
#include "support/models.hpp"

namespace vrda::analysis::motion_audit_test {

constexpr double rounding_mm = 1e-10;  // coordinates of hundreds of mm

Mesh dished_ceiling()
{
  Mesh ceiling = test::sheet(60, 20);
  for (Eigen::Index v = 0; v < ceiling.vertices_mm.rows(); ++v) {
    const double x = ceiling.vertices_mm(v, 0), z = ceiling.vertices_mm(v, 2);
    ceiling.vertices_mm(v, 1) = -(x * x + z * z) / 80.0;
  }
  ceiling.triangles.col(1).swap(ceiling.triangles.col(2));
  ceiling.normals = vertex_normals(ceiling);
  return ceiling;
}

TEST(PoseMeter, GapAndPenetrationOfTwoBoxes)
{
  const AuditScene scene =
      make_audit_scene(test::box({500, 410, 300}, {4, 4, 4}), test::box({500, 400, 300}, {2, 2, 2}),
                       {Side::right, {500, 400, 300}, {0, 1, 0}});
  PoseMeter meter(scene);
  Pose X = Pose::Identity();
  const PoseAudit free = meter.measure({}, X, OverlapTest::narrow_phase);
  EXPECT_FALSE(free.is_overlapping);
  EXPECT_NEAR(free.gap_mm, 7.0, rounding_mm);
  X.translation() << 0.5, 7.25, 0.5;
  const PoseAudit deep = meter.measure({}, X, OverlapTest::narrow_phase);
  EXPECT_TRUE(deep.is_overlapping);
  EXPECT_NEAR(deep.penetration_mm, 0.25, rounding_mm);
  X.translation() << 50, 0, 0;
  EXPECT_TRUE(std::isinf(meter.measure({}, X, OverlapTest::narrow_phase).gap_mm));
}

// Of a soft box only what is deeper than its overlap counts, also where the box is thinner than twice that.
TEST(PoseMeter, PenetrationOfASoftBoxCountsFromItsOverlap)
{
  for (const double thickness_mm : {4.0, 0.8}) {
    Mesh soft = test::box({500, 408 + 0.5 * thickness_mm, 300}, {40, thickness_mm, 40});
    soft.overlap_mm.assign(static_cast<std::size_t>(soft.triangles.rows()), 0.5);
    Mesh ball = test::ball(2);
    ball.vertices_mm.rowwise() += Eigen::RowVector3d(500, 400, 300);
    const AuditScene scene = make_audit_scene(soft, ball, {Side::right, {500, 400, 300}, {0, 1, 0}});
    PoseMeter meter(scene);
    Pose X = Pose::Identity();
    X.translation() << 0.5, 6.25, 0.7;  // 0.25 mm inside
    const PoseAudit allowed = meter.measure({}, X, OverlapTest::narrow_phase);
    EXPECT_FALSE(allowed.is_overlapping);
    EXPECT_NEAR(allowed.gap_mm, 0.25, 1e-6);
    X.translation().y() = 6.75;
    const PoseAudit deep = meter.measure({}, X, OverlapTest::narrow_phase);
    EXPECT_TRUE(deep.is_overlapping);
    EXPECT_NEAR(deep.penetration_mm, 0.25, 1e-6);
  }
}

// A ceiling at y = 10 with a lip at 0 below part of it; the moving box is 2 mm high and free between them.
AuditScene socket_scene()
{
  Mesh socket = test::box({0, 12, 0}, {20, 4, 20});
  append(socket, test::box({6, -1, 0}, {8, 2, 20}));
  return make_audit_scene(socket, test::box({0, 0, 0}, {6, 2, 6}), {});
}

TEST(PoseMeter, DeepInASocketTheNearestFreePlayCountsNotTheRim)
{
  const AuditScene scene = socket_scene();
  PoseMeter meter(scene);
  struct Row {
    double y_mm, penetration_mm, gap_mm;
  };
  // Free below the lip up to -3, and from 1 to 9.
  for (const Row& row : {Row{-5, 0, 2}, Row{-2.5, 0.5, 0}, Row{0.5, 3.5, 0}, Row{2, 0, 7}, Row{9.05, 0.05, 0},
                         Row{10, 1, 0}, Row{10.5, 1.5, 0}}) {
    SCOPED_TRACE(row.y_mm);
    Pose X = Pose::Identity();
    X.translation() << 0.3, row.y_mm, -0.2;
    const PoseAudit found = meter.measure({}, X, OverlapTest::sweep);
    EXPECT_EQ(found.is_overlapping, row.penetration_mm > 0.0);
    EXPECT_NEAR(found.penetration_mm, row.penetration_mm, rounding_mm);
    EXPECT_NEAR(found.gap_mm, row.gap_mm, rounding_mm);
    const double contact_mm = row.gap_mm - row.penetration_mm - contact_margin_mm;
    EXPECT_NEAR(meter.travel_into_contact_mm({}, X), contact_mm, rounding_mm);
  }
}

TEST(PoseMeter, WithNothingAheadThereIsNoTravelIntoContact)
{
  const AuditScene scene = socket_scene();
  Pose X = Pose::Identity();
  X.translation() << 40, 0, 0;
  EXPECT_TRUE(std::isnan(PoseMeter(scene).travel_into_contact_mm({}, X)));
}

TEST(PoseMeter, AnOpenSheetStruckFromBehindIsLeftTheWayItCame)
{
  // Both sheets face up: no facing pairs, but common points.
  Mesh tilted = test::sheet(20, 4);
  tilted.vertices_mm.col(1) = 0.1 * tilted.vertices_mm.col(0);
  const AuditScene scene = make_audit_scene(test::sheet(20, 4), tilted, {});
  const PoseAudit found = PoseMeter(scene).measure({}, Pose::Identity(), OverlapTest::sweep);
  EXPECT_TRUE(found.is_overlapping);
  EXPECT_NEAR(found.penetration_mm, 1.0, rounding_mm);  // 0.1 * 10
}

// Transforms every vertex through both poses, rebuilds the trees and queries the plain directional gap.
PoseAudit plainly_measured(const AuditScene& scene, const Mesh& moving_canonical, const Attitude& attitude,
                           const Pose& X_reference_moving, contact::NarrowPhase& narrow_phase)
{
  const geometry::TreeMesh reference = geometry::rotated_reference(scene.reference.with_tree(), attitude);
  const geometry::TreeMesh moving = geometry::rotated_reference(
      geometry::make_tree_mesh(solver_mesh(transformed(moving_canonical, X_reference_moving), scene.frame)),
      attitude);
  if (contact::find_collision(reference, moving, {}, narrow_phase)) {
    const geometry::Gap afar =
        test::directional_gap(reference, moving.mesh, moving.tree, {}, geometry::GapKind::signed_facing);
    return {true, std::max(0.0, -afar.travel_mm), 0.0};
  }
  return {false, 0.0, test::directional_gap(reference, moving.mesh, moving.tree, {}).travel_mm};
}

TEST(PoseMeter, AgreesWithThePlainWayAlsoWhereAPoseTurnsNotAboutDeltaAlone)
{
  const Mesh ceiling = dished_ceiling(), ball = test::ball(6);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  int n_overlapping = 0, n_free = 0, n_nothing_ahead = 0;
  for (const Side side : {Side::right, Side::left}) {
    const SolverFrame frame{side, {30, 20, -10}, Eigen::Vector3d(0.1, 1, 0.05).normalized()};
    const AuditScene scene = make_audit_scene(ceiling, ball, frame);
    PoseMeter meter(scene);
    contact::NarrowPhase narrow_phase;
    for (int k = 0; k < 100; ++k) {
      const Attitude attitude{0.3 * unit(random), 0.1 * unit(random)};
      const MovingPose pose{{18 * unit(random), -8 + 10 * unit(random), 30 * unit(random)}, unit(random)};
      Pose X = X_reference_moving(frame, attitude, pose);
      if (k % 2 == 1) X.linear() = rotation_x(0.2) * Eigen::Matrix3d(X.linear());
      const PoseAudit expected = plainly_measured(scene, ball, attitude, X, narrow_phase);
      const PoseAudit found = meter.measure(attitude, X, OverlapTest::narrow_phase);
      const PoseAudit swept = meter.measure(attitude, X, OverlapTest::sweep);
      EXPECT_EQ(swept.is_overlapping, found.is_overlapping);
      EXPECT_EQ(swept.penetration_mm, found.penetration_mm);
      EXPECT_EQ(swept.gap_mm, found.gap_mm);
      EXPECT_EQ(found.is_overlapping, expected.is_overlapping);
      EXPECT_NEAR(found.penetration_mm, expected.penetration_mm, rounding_mm);
      EXPECT_EQ(std::isinf(found.gap_mm), std::isinf(expected.gap_mm));
      const double gap_mm = std::isinf(expected.gap_mm) ? 0.0 : found.gap_mm - expected.gap_mm;
      EXPECT_NEAR(gap_mm, 0.0, rounding_mm);
      n_overlapping += expected.is_overlapping ? 1 : 0;
      n_nothing_ahead += std::isinf(expected.gap_mm) ? 1 : 0;
      n_free += expected.gap_mm > 0.0 && std::isfinite(expected.gap_mm) ? 1 : 0;
    }
  }
  EXPECT_GT(n_overlapping, 20);
  EXPECT_GT(n_free, 20);
  EXPECT_GT(n_nothing_ahead, 20);
}

TEST(PoseMeter, NotedFeaturesBoundTheTravelOfPosesNearby)
{
  const AuditScene scene =
      make_audit_scene(dished_ceiling(), test::ball(6), {Side::right, {0, 0, 0}, {0, 1, 0}});
  PoseMeter meter(scene);
  const Attitude attitude{0.05, -0.02};
  Pose X = Pose::Identity();
  X.translation() << 1.0, -12.0, 0.5;
  X.prerotate(Eigen::Matrix3d(reference_rotation(attitude).transpose()));
  meter.measure(attitude, X, OverlapTest::sweep);
  const std::optional<MovingPose> pose = meter.solver_pose();
  ASSERT_TRUE(pose);
  meter.note_features(0.2);
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> unit(-1, 1);
  int n_equal = 0;
  constexpr int n_poses = 200;
  for (int k = 0; k < n_poses; ++k) {
    MovingPose aside = *pose;
    aside.translation_mm.x() += 0.1 * unit(random);
    aside.translation_mm.z() += 0.1 * unit(random);
    aside.theta_rad += 0.02 * unit(random);
    const Attitude turned{attitude.flexion_rad, attitude.varus_rad + 0.01 * unit(random)};
    const double bound_mm = meter.travel_near_bound_mm(turned, aside);
    const double travel_mm = meter.travel_near_mm(turned, aside, 20.0);
    ASSERT_GE(bound_mm, travel_mm);
    n_equal += bound_mm == travel_mm ? 1 : 0;
  }
  EXPECT_GT(n_equal, n_poses / 2);
}

const std::vector<std::size_t> frame_order{3, 0, 4, 1, 2};

test::SampleOptions equilibrium_options()
{
  test::SampleOptions options;
  options.is_equilibrium = true;
  return options;
}

bool is_same(double a, double b)
{
  return a == b || (std::isnan(a) && std::isnan(b));
}

void expect_same_cell(const store::AuditSet& a, const store::AuditSet& b, Eigen::Index i, Eigen::Index j)
{
  EXPECT_EQ(a.state(i, j), b.state(i, j));
  EXPECT_TRUE(is_same(a.penetration_mm(i, j), b.penetration_mm(i, j))) << i << ' ' << j;
  EXPECT_TRUE(is_same(a.gap_mm(i, j), b.gap_mm(i, j))) << i << ' ' << j;
}

void expect_same(const store::AuditSet& a, const store::AuditSet& b)
{
  ASSERT_EQ(a.flexion_deg, b.flexion_deg);
  for (Eigen::Index i = 0; i < a.state.rows(); ++i) {
    for (Eigen::Index j = 0; j < a.state.cols(); ++j) expect_same_cell(a, b, i, j);
  }
}

TEST(Audit, EachFlexionAlongItsOwnDelta)
{
  const store::MotionModel turning = test::sample_model(equilibrium_options());
  const store::AuditSet found = audit(turning, "raw", 1, 2);
  for (std::size_t k = 0; k < turning.flexion_deg.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    store::MotionModel constant = turning;
    constant.delta = turning.push.delta.row(i).transpose();
    constant.push = store::constant_push(constant.delta, turning.flexion_deg.size());
    const store::AuditSet expected = audit(constant, "raw", 1, 1);
    for (Eigen::Index j = 0; j < found.state.cols(); ++j) expect_same_cell(found, expected, i, j);
  }
  // The last row has another Delta than the first, hence another gap.
  store::MotionModel wrong = turning;
  wrong.push = store::constant_push(turning.delta, turning.flexion_deg.size());
  const Eigen::Index last = found.state.rows() - 1;
  EXPECT_NE(audit(wrong, "raw", 1, 1).gap_mm(last, 0), found.gap_mm(last, 0));
}

/// The column of a grid, and its rows in another order as frames.
struct ColumnAndFrames {
  store::MotionModel column, frames;
};

ColumnAndFrames column_and_frames(bool has_turning_delta)
{
  test::SampleOptions options = equilibrium_options();
  options.is_equilibrium = has_turning_delta;
  options.n_varus = 1;
  options.n_flexion = 5;
  options.has_failed_cell = false;
  store::MotionModel column = test::sample_model(options);
  column.varus_deg = {0.0};
  column.smoothed.clear();
  return {column, test::frames_of(column, frame_order, {0.0, 1.0, 1.5, 4.0, 5.0})};
}

TEST(Audit, AFrameHasTheGapOfItsAttitude)
{
  for (const bool has_turning_delta : {false, true}) {
    const auto [column, frames] = column_and_frames(has_turning_delta);
    const store::AuditSet grid = audit(column, "raw", 1, 1), found = audit(frames, "raw", 2, 2);
    ASSERT_EQ(found.frame_key, (std::vector<double>{0, 0.5, 1, 1.25, 1.5, 2.75, 4, 4.5, 5}));
    for (std::size_t i = 0; i < frame_order.size(); ++i) {
      const auto at = static_cast<Eigen::Index>(2 * i), cell = static_cast<Eigen::Index>(frame_order[i]);
      EXPECT_EQ(found.flexion_deg[2 * i], column.flexion_deg[frame_order[i]]);
      EXPECT_EQ(found.state(at, 0), grid.state(cell, 0));
      EXPECT_TRUE(is_same(found.gap_mm(at, 0), grid.gap_mm(cell, 0))) << i;
    }
    // Between two frames the joint has another gap than at either.
    EXPECT_NE(found.state(1, 0), static_cast<std::int8_t>(store::AuditState::no_pose));
  }
}

TEST(Audit, TravelIsFromOneFrameToTheNext)
{
  test::ModelPlan plan;
  plan.flexion_deg = {0, 10, 40};
  plan.varus_deg = {0};
  plan.rotation_centre_mm = {20, 50, -30};
  // The reference turns about the rotation centre, so the moving point there only turns with it.
  store::MotionModel model = test::frames_of(test::model_of(plan), {2, 0, 1}, {1.0, 2.0, 3.0});
  const FrameTravel travel = frame_travel(model);
  EXPECT_EQ(travel.n_steps, 2);
  EXPECT_NEAR(deg_from_rad(travel.largest_rad), 40.0, 1e-9);
  EXPECT_NEAR(deg_from_rad(travel.mean_rad), 25.0, 1e-9);
  EXPECT_EQ(travel.key_of_rad, 2.0);
  EXPECT_NEAR(travel.largest_mm, 0.0, rounding_mm);
  test::unsolve(model, 1, 0);
  EXPECT_EQ(frame_travel(model).n_steps, 1);
  EXPECT_NEAR(deg_from_rad(frame_travel(model).largest_rad), 30.0, 1e-9);
}

// A wide block with its lower face 10 mm above the rotation centre, rotated by each attitude; below it a box
// of 2 mm with its centre at `y_mm`. Both are symmetric to the sagittal plane.
store::MotionModel block_model(const std::string& side, double y_mm)
{
  test::ModelPlan plan;
  plan.side = side;
  plan.rotation_centre_mm = {20, 50, -30};
  plan.flexion_deg = {0, 5, 10};
  plan.varus_deg = {-4, 0, 4};
  plan.motion = [y_mm](double, double) { return store::PoseCoordinates{0, y_mm, 0, 0}; };
  store::MotionModel model = test::model_of(plan);
  model.reference.contact.mesh = test::box(plan.rotation_centre_mm + Eigen::Vector3d(0, 30, 0), {90, 40, 90});
  model.moving.contact.mesh = test::box(plan.rotation_centre_mm, {2, 2, 2});
  return model;
}

// With n = R e_y the lower face is n . p = 10; the first upper corner of the box to reach it sets the gap.
double block_travel_mm(double flexion_deg, double varus_deg, double y_mm)
{
  const Eigen::Vector3d n =
      reference_rotation({rad_from_deg(flexion_deg), rad_from_deg(varus_deg)}) * Eigen::Vector3d::UnitY();
  return (10.0 - std::abs(n.x()) - n.y() - std::abs(n.z())) / n.y() - y_mm;
}

struct Tally {
  int n_free = 0, n_overlapping = 0;
};

Tally expect_closed_form(const store::AuditSet& found, double y_mm)
{
  Tally tally;
  for (Eigen::Index i = 0; i < found.state.rows(); ++i) {
    for (Eigen::Index j = 0; j < found.state.cols(); ++j) {
      const double travel_mm = block_travel_mm(found.flexion_deg[static_cast<std::size_t>(i)],
                                               found.varus_deg[static_cast<std::size_t>(j)], y_mm);
      const bool is_free = travel_mm > 0.0;
      EXPECT_EQ(found.state(i, j),
                static_cast<std::int8_t>(is_free ? store::AuditState::free : store::AuditState::overlapping));
      EXPECT_NEAR(found.penetration_mm(i, j), is_free ? 0.0 : -travel_mm, rounding_mm);
      EXPECT_EQ(std::isnan(found.gap_mm(i, j)), !is_free);
      EXPECT_NEAR(is_free ? found.gap_mm(i, j) : travel_mm, travel_mm, rounding_mm);
      tally.n_free += is_free ? 1 : 0;
      tally.n_overlapping += is_free ? 0 : 1;
    }
  }
  return tally;
}

TEST(Audit, FollowsTheClosedFormAtAndBetweenTheAttitudes)
{
  for (const std::string side : {"right", "left"}) {
    // The travel from y = 0 falls from 9 at 0, 0 to 8.9 at 10, 4.
    const double y_mm = 8.95;
    const store::MotionModel model = block_model(side, y_mm);
    const store::AuditSet found = audit(model, "raw", 3, 2);
    EXPECT_EQ(found.refine, 3);
    ASSERT_EQ(found.state.rows(), 7);
    ASSERT_EQ(found.state.cols(), 7);
    EXPECT_EQ(found.flexion_deg[3], 5.0);
    EXPECT_NEAR(found.varus_deg[1], -4.0 + 4.0 / 3.0, 1e-15);
    const Tally tally = expect_closed_form(found, y_mm);
    EXPECT_GT(tally.n_free, 5);
    EXPECT_GT(tally.n_overlapping, 5);
    const AuditFigures figures = figures_of(found);
    EXPECT_EQ(figures.n_poses, 49);
    EXPECT_EQ(figures.n_overlapping, tally.n_overlapping);
    EXPECT_NEAR(figures.largest_penetration.value_mm,
                -block_travel_mm(figures.largest_penetration.flexion_deg,
                                 figures.largest_penetration.varus_deg, y_mm),
                rounding_mm);
    EXPECT_EQ(figures.largest_penetration.value_mm, store::summary_of(found).largest_penetration_mm);
    EXPECT_EQ(figures.largest_gap.value_mm, store::summary_of(found).largest_gap_mm);
  }
}

TEST(Audit, TheAttitudesOfTheModelHaveTheSameBitsHoweverManyLieBetween)
{
  const store::MotionModel model = block_model("right", 8.95);
  const store::AuditSet coarse = audit(model, "raw", 1, 1), fine = audit(model, "raw", 4, 1);
  for (Eigen::Index i = 0; i < coarse.state.rows(); ++i) {
    for (Eigen::Index j = 0; j < coarse.state.cols(); ++j) {
      EXPECT_TRUE(is_same(coarse.gap_mm(i, j), fine.gap_mm(4 * i, 4 * j)));
      EXPECT_TRUE(is_same(coarse.penetration_mm(i, j), fine.penetration_mm(4 * i, 4 * j)));
    }
  }
}

TEST(Audit, ThreadsChangeNoBit)
{
  store::MotionModel model = block_model("left", 8.95);
  test::unsolve(model, 1, 1);
  const store::AuditSet one = audit(model, "raw", 3, 1);
  for (const int n_threads : {2, 5, 40}) expect_same(audit(model, "raw", 3, n_threads), one);
}

TEST(Audit, NamesWhereThereIsNoPoseAndWhereNothingIsAhead)
{
  store::MotionModel model = block_model("right", 8.0);
  test::unsolve(model, 1, 1);
  const store::AuditSet hole = audit(model, "raw", 2, 1);
  EXPECT_EQ(hole.state(2, 2), static_cast<std::int8_t>(store::AuditState::no_pose));
  EXPECT_EQ(hole.state(1, 3), static_cast<std::int8_t>(store::AuditState::no_pose));
  EXPECT_EQ(hole.state(0, 1), static_cast<std::int8_t>(store::AuditState::free));
  EXPECT_TRUE(std::isnan(hole.penetration_mm(2, 2)));
  EXPECT_EQ(figures_of(hole).n_poses, 16);  // the poses around the hole
  model.moving.contact.mesh.vertices_mm.col(0).array() += 500.0;
  const store::AuditSet aside = audit(model, "raw", 1, 1);
  EXPECT_EQ(aside.state(0, 0), static_cast<std::int8_t>(store::AuditState::nothing_ahead));
  EXPECT_TRUE(std::isnan(aside.gap_mm(0, 0)));
  EXPECT_EQ(aside.penetration_mm(0, 0), 0.0);
  EXPECT_EQ(figures_of(aside).n_nothing_ahead, 8);
}

TEST(Audit, TheZeroVarusMotionByFlexionAlone)
{
  store::MotionModel model = block_model("right", 0.0);
  store::ZeroVarus table;
  const std::size_t n = model.flexion_deg.size();
  table.source.assign(n, static_cast<std::int8_t>(store::ZeroVarusSource::both_touch));
  table.varus_deg.assign(n, 2.0);
  table.tx_mm = table.tz_mm = table.theta_deg = std::vector<double>(n, 0.0);
  table.ty_mm.assign(n, 8.8);
  model.zero_varus = table;
  const store::AuditSet found = audit(model, "zero_varus", 2, 1);
  ASSERT_EQ(found.state.rows(), 5);
  EXPECT_EQ(found.varus_deg, std::vector<double>{0.0});
  for (std::size_t k = 0; k < 5; ++k) {
    EXPECT_NEAR(found.gap_mm(static_cast<Eigen::Index>(k), 0),
                block_travel_mm(found.flexion_deg[k], 2.0, 8.8), rounding_mm);
  }
}

// The smoothed motion has height y_mm everywhere.
store::MotionModel smoothed_block_model(double y_mm)
{
  store::MotionModel model = block_model("left", 8.0);
  test::add_smoothed(model, 1, [y_mm](int i, int j) {
    return store::PoseCoordinates{0, i + j == 0 ? y_mm : 0.0, 0, 0};
  });
  return model;
}

TEST(Recontact, TravelsByTheClosedFormShortOfItByTheMargin)
{
  for (const double y_mm : {8.0, 8.95, 9.5}) {  // all free, mixed, all overlapping
    const store::MotionModel model = smoothed_block_model(y_mm);
    const store::GridD travel_mm = recontact(model, model.smoothed.front(), 1);
    for (Eigen::Index i = 0; i < travel_mm.rows(); ++i) {
      for (Eigen::Index j = 0; j < travel_mm.cols(); ++j) {
        const double expected_mm = block_travel_mm(model.flexion_deg[static_cast<std::size_t>(i)],
                                                   model.varus_deg[static_cast<std::size_t>(j)], y_mm);
        EXPECT_NEAR(travel_mm(i, j), expected_mm - contact_margin_mm, rounding_mm);
      }
    }
    EXPECT_TRUE((recontact(model, model.smoothed.front(), 3) == travel_mm).all());
  }
}

TEST(Recontact, TheAuditOfTheRecontactedMotionFindsTheMarginAndNoOverlap)
{
  store::MotionModel model = smoothed_block_model(9.5);
  test::unsolve(model, 0, 2);  // the polynomials have a pose there nevertheless
  model.smoothed.front().recontact_mm = recontact(model, model.smoothed.front(), 1);
  EXPECT_EQ(figures_of(audit(model, "degree_1", 1, 1)).n_overlapping, 9);
  const AuditFigures at_nodes = figures_of(audit(model, "degree_1_recontacted", 1, 1));
  EXPECT_EQ(at_nodes.n_poses, 9);
  EXPECT_EQ(at_nodes.n_overlapping, 0);
  EXPECT_EQ(at_nodes.n_nothing_ahead, 0);
  EXPECT_NEAR(at_nodes.largest_gap.value_mm, contact_margin_mm, rounding_mm);
  // Between them the travel is interpolated, but not the kink at zero varus.
  EXPECT_GT(figures_of(audit(model, "degree_1_recontacted", 2, 1)).n_overlapping, 0);
}

TEST(Recontact, LeavesAHoleWhereNothingIsAhead)
{
  store::MotionModel model = smoothed_block_model(8.0);
  model.moving.contact.mesh.vertices_mm.col(0).array() += 500.0;
  EXPECT_TRUE(recontact(model, model.smoothed.front(), 1).isNaN().all());
}

}  // namespace vrda::analysis::motion_audit_test
