#include "analysis/audit.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "core/units.hpp"
#include "support/directional_gap.hpp"
#include "support/meshes.hpp"

namespace vrda::analysis::pose_meter_test {

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
  const geometry::TreeMesh reference = geometry::rotated_reference(scene.reference, attitude);
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

}  // namespace vrda::analysis::pose_meter_test
