#include <gtest/gtest.h>

#include "analysis/measured_joints.hpp"
#include "analysis/scenes.hpp"
#include "core/units.hpp"
#include "support/real_knees.hpp"

namespace vrda::repair_real_motion_test {

// Every tenth frame of a foot whose measured bones overlap by 0.4 mm, pushed together by another 2 mm.
TEST(RealMotion, OverlapOfMeasuredBonesIsRemoved)
{
  VRDA_REQUIRE_REAL_KNEES();
  test::MeasuredJoint joint = test::subtalar_joint(*test::data_directory() / "subtalar" / "08");
  analysis::MeasuredMotion thinned;
  thinned.name = joint.motion.name;
  for (std::size_t k = 0; k < joint.motion.key.size(); k += 10) {
    thinned.key.push_back(joint.motion.key[k]);
    thinned.X_reference_moving.push_back(joint.motion.X_reference_moving[k]);
    thinned.X_reference_moving.back().translation().y() += 2.0;
  }
  SolverFrame frame;
  frame.side = Side::left;
  const analysis::AuditScene scene = analysis::make_audit_scene(joint.reference, joint.moving, frame);
  analysis::RepairOptions options;
  options.noise = test::isotropic_noise(0.5, 1.0);
  options.n_threads = 2;
  const analysis::RepairedMotion found = analysis::repair(scene, thinned, options);
  EXPECT_TRUE(found.is_converged);
  for (const analysis::RepairedFrame& repaired : found.frames) {
    EXPECT_EQ(repaired.status, analysis::FrameStatus::repaired);
    EXPECT_GT(repaired.before.audit.penetration_mm, 1.0);
    EXPECT_LE(repaired.after.audit.penetration_mm, analysis::repair_tolerance_mm);
    // Pushed by 4 standard deviations; rotation and smoothing need a little more.
    EXPECT_LT(repaired.displacement.norm(), 6.0);
  }
}

}  // namespace vrda::repair_real_motion_test
