#include "audit/audit.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/units.hpp"
#include "solve/stability_search.hpp"
#include "support/meshes.hpp"

namespace vrda {
namespace {

constexpr double rounding_mm = 1e-10;  // coordinates of hundreds of mm

TEST(Audit, GapAndPenetrationOfTwoBoxes)
{
  const AuditScene scene =
      make_audit_scene(test::box({500, 410, 300}, {4, 4, 4}), test::box({500, 400, 300}, {2, 2, 2}),
                       {Side::right, {500, 400, 300}, {0, 1, 0}});
  NarrowPhase narrow_phase;
  Pose X = Pose::Identity();
  const PoseAudit free = audit_pose(scene, {}, X, narrow_phase);
  EXPECT_FALSE(free.is_overlapping);
  EXPECT_NEAR(free.gap_mm, 7.0, rounding_mm);
  X.translation() << 0.5, 7.25, 0.5;
  const PoseAudit deep = audit_pose(scene, {}, X, narrow_phase);
  EXPECT_TRUE(deep.is_overlapping);
  EXPECT_NEAR(deep.penetration_mm, 0.25, rounding_mm);
  X.translation() << 50, 0, 0;
  EXPECT_TRUE(std::isinf(audit_pose(scene, {}, X, narrow_phase).gap_mm));
}

TEST(Audit, SeesWhatTheSolverSawOnBothSidesAndAlongAnyDelta)
{
  // A stable pose of the search, carried through X_reference_moving, must touch without overlap.
  Mesh ceiling = test::sheet(60, 20);
  for (Eigen::Index v = 0; v < ceiling.vertices_mm.rows(); ++v) {
    const double x = ceiling.vertices_mm(v, 0), z = ceiling.vertices_mm(v, 2);
    ceiling.vertices_mm(v, 1) = -(x * x + z * z) / 80.0;
  }
  ceiling.triangles.col(1).swap(ceiling.triangles.col(2));
  ceiling.normals = vertex_normals(ceiling);
  const Mesh ball = test::ball(6);
  const SearchOptions options;
  for (const Side side : {Side::right, Side::left}) {
    for (const Eigen::Vector3d& delta :
         {Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(Eigen::Vector3d(0.1, 1, 0.05).normalized())}) {
      const SolverFrame frame{side, {3, 2, -1}, delta};
      const Joint joint = make_joint({solver_mesh(ceiling, frame), {}}, {solver_mesh(ball, frame), {}}, {});
      const Attitude attitude{rad_from_deg(8), rad_from_deg(-3)};
      const StepRecord r = find_stable_pose(joint, attitude, {{0, -30, 0}, 0.1}, options);
      ASSERT_EQ(r.status, StepStatus::stable);
      NarrowPhase narrow_phase;
      const PoseAudit audit = audit_pose(make_audit_scene(ceiling, ball, frame), attitude,
                                         X_reference_moving(frame, attitude, r.pose), narrow_phase);
      EXPECT_FALSE(audit.is_overlapping);
      EXPECT_LE(audit.gap_mm, options.translation_resolution_mm);
    }
  }
}

}  // namespace
}  // namespace vrda
