// Smoothing, recontact and audit of bodies that follow the joint: closed forms.
#include <gtest/gtest.h>

#include <functional>

#include "analysis/audit.hpp"
#include "analysis/smooth.hpp"
#include "core/units.hpp"
#include "support/meshes.hpp"
#include "support/models.hpp"

namespace vrda::analysis_followers_test {

constexpr double wall_mm = 20.0;  // the front of the reference

// A box in front of a wall, which it meets along -X: 8 mm away at 0 degrees, inside it at 90.
JointCoordinates follower_at(double flexion_deg, double varus_deg)
{
  JointCoordinates q = JointCoordinates::Zero();
  q << 0.01 * flexion_deg, 0.002 * varus_deg, 0.0, -0.1 * flexion_deg, 0.3 * flexion_deg, 0.2 * varus_deg;
  return q;
}

store::MotionModel model_of(const std::string& side)
{
  test::ModelPlan plan;
  plan.side = side;
  store::MotionModel model = test::model_of(plan);
  model.reference.contact.mesh = test::box({wall_mm - 50.0, 0, 0}, {100, 200, 200});
  model.moving.contact.mesh = test::box({wall_mm - 50.0, -150, 0}, {50, 50, 50});
  test::add_follower(model, BodyIndex::reference, {wall_mm + 10.0, 0, 0}, follower_at);
  return model;
}

// Distance of the follower's nearest corner from the wall, by its pose.
double distance_mm(const store::MotionModel& model, const Pose& X)
{
  return transformed(model.followers[0].body.contact.mesh, X).vertices_mm.col(0).minCoeff() - wall_mm;
}

void unsolve(store::MotionModel& model, Eigen::Index i, Eigen::Index j)
{
  store::FollowerRows& rows = model.followers[0];
  rows.status(i, j) = static_cast<std::int8_t>(StepStatus::unbounded);
  for (store::GridD& grid : rows.coordinates) grid(i, j) = nan;
}

// Polynomials of their own degree are reproduced, also where a cell is missing.
TEST(SmoothedFollowers, ReproduceLinearCoordinates)
{
  for (const std::string side : {"right", "left"}) {
    SCOPED_TRACE(side);
    store::MotionModel model = model_of(side);
    unsolve(model, 2, 3);
    store::SmoothedSet set = analysis::smooth(analysis::smooth_input(model, "knee.h5"), 2);
    ASSERT_EQ(set.followers.size(), 1U);
    EXPECT_EQ(set.followers[0].surfaces[0].n_cells, 34);
    EXPECT_LT(set.followers[0].surfaces[3].rms, 1e-12);
    model = store::with_smoothed(std::move(model), std::move(set));
    const store::JointPose pose =
        store::Motion(model, "degree_2").at({rad_from_deg(31.0), rad_from_deg(1.7)});
    ASSERT_TRUE(pose.has_follower[0]);
    const Pose wanted = follower_pose(follower_at(31.0, 1.7), side_named(side), model.followers[0].centre_mm);
    EXPECT_LT((pose.X_reference_follower[0].matrix() - wanted.matrix()).norm(), 1e-9);
  }
}

TEST(SmoothedFollowers, AreLeftOutWhereTheirCellsAreTooFew)
{
  store::MotionModel model = model_of("right");
  for (Eigen::Index j = 0; j < 5; ++j) {
    for (Eigen::Index i = 1; i < 7; ++i) unsolve(model, i, j);
  }
  const store::SmoothedSet set = analysis::smooth(analysis::smooth_input(model, "knee.h5"), 2);
  EXPECT_TRUE(set.followers.empty());
  EXPECT_EQ(set.surfaces.size(), 4U);
}

// After recontact it touches the wall, from either side of it.
TEST(SmoothedFollowers, AreMovedIntoContact)
{
  for (const std::string side : {"right", "left"}) {
    SCOPED_TRACE(side);
    store::MotionModel model = model_of(side);
    store::SmoothedSet set = analysis::smooth(analysis::smooth_input(model, "knee.h5"), 1);
    analysis::add_recontact(model, set, 2);
    ASSERT_TRUE(set.followers[0].recontact_mm.has_value());
    // Without rotation its travel is its distance.
    EXPECT_NEAR((*set.followers[0].recontact_mm)(0, 2), 8.0, 1e-6);
    EXPECT_LT((*set.followers[0].recontact_mm)(6, 2), 0.0);
    model = store::with_smoothed(std::move(model), std::move(set));
    const store::Motion motion(model, "degree_1_recontacted");
    for (const double flexion_deg : model.flexion_deg) {
      const store::JointPose pose = motion.at({rad_from_deg(flexion_deg), rad_from_deg(2.0)});
      ASSERT_TRUE(pose.has_follower[0]);
      const double gap_mm = distance_mm(model, pose.X_reference_follower[0]);
      EXPECT_GT(gap_mm, 0.0) << flexion_deg;
      EXPECT_LT(gap_mm, 1e-5) << flexion_deg;
    }
  }
}

// At 0 degrees it is 8 mm away; rotated, the audit's travel along its own Delta is longer than the distance.
TEST(AuditOfFollowers, MeasuresGapAndPenetration)
{
  store::MotionModel model = model_of("right");
  unsolve(model, 1, 1);
  const store::AuditSet found = analysis::audit(model, "raw", 1, 2);
  ASSERT_EQ(found.followers.size(), 1U);
  const store::FollowerAudit& follower = found.followers[0];
  EXPECT_NEAR(follower.gap_mm(0, 2), 8.0, 1e-9);
  EXPECT_EQ(follower.state(1, 1), static_cast<std::int8_t>(store::AuditState::no_pose));
  for (Eigen::Index i = 0; i < 7; ++i) {
    if (i == 1) continue;
    const Pose X = store::pose_in(model.followers[0].X_of_follower, static_cast<std::size_t>(5 * i + 1));
    const double along = (X.linear() * -Eigen::Vector3d::UnitX()).x();  // share of the travel across the gap
    const double wanted_mm = distance_mm(model, X) / -along;
    const double measured_mm = wanted_mm > 0.0 ? follower.gap_mm(i, 1) : -follower.penetration_mm(i, 1);
    EXPECT_NEAR(measured_mm, wanted_mm, 1e-6) << i;
  }
  EXPECT_EQ(analysis::figures_of(found, follower).n_poses, 34);
}

// In front of the wall at one attitude, 1e-3 mm from it, and what displaces or changes that.
struct PlausibilityRow {
  const char* name;
  JointCoordinates at;
  std::function<void(store::MotionModel&)> change;
  Plausibility wanted;
};

JointCoordinates at(double tilt_deg, double anterior_mm, double proximal_mm)
{
  JointCoordinates q = JointCoordinates::Zero();
  q << 0.0, 0.0, rad_from_deg(tilt_deg), anterior_mm, proximal_mm, 0.0;
  return q;
}

void stretch(store::MotionModel& model, double constant_tension_n)
{
  store::LigamentRows& rows = model.followers[0].ligaments.emplace();
  rows.name = rows.bundle = {"tendon"};
  rows.constant_tension_n = {constant_tension_n};
  rows.strain = {0.5};
  rows.tension_n = {5000.0};
}

// A sheet that ends at y = 100, on the plane of the wall.
void open_wall(store::MotionModel& model)
{
  Mesh& mesh = model.reference.contact.mesh;
  mesh.vertices_mm.resize(4, 3);
  mesh.vertices_mm << wall_mm, -100, -100, wall_mm, 100, -100, wall_mm, 100, 100, wall_mm, -100, 100;
  mesh.triangles.resize(2, 3);
  mesh.triangles << 0, 1, 2, 0, 2, 3;
}

TEST(PlausibilityOfFollowers, FirstObjection)
{
  using enum Plausibility;
  const auto nothing = [](store::MotionModel&) {};
  for (const PlausibilityRow& row : std::vector<PlausibilityRow>{
           {"in contact", at(0, 0, 0), nothing, nothing_found},
           {"a gap beyond the resolution", at(0, 0.2, 0), nothing, nothing_ahead},
           {"beside the wall", at(0, 0, 105), nothing, nothing_ahead},
           // Half a resolution of its width is in front of the wall.
           {"at the edge of the wall", at(0, 0, 102.95), nothing, nothing_ahead},
           {"turned away", at(100, 4, 0), nothing, dislocated},
           {"far from the wall", at(0, 9, 0), nothing, dislocated},
           {"at the border of a sheet", at(0, 0, 97), open_wall, border_contact},
           {"a strained tendon", at(0, 0, 0), [](auto& model) { stretch(model, 0.0); }, overstrained},
           {"a line", at(0, 0, 0), [](auto& model) { stretch(model, 10.0); }, nothing_found},
           {"inside", at(0, -1, 0), nothing, not_judged}}) {
    SCOPED_TRACE(row.name);
    test::ModelPlan plan;
    plan.flexion_deg = {0.0};
    plan.varus_deg = {0.0};
    store::MotionModel model = test::model_of(plan);
    model.reference.contact.mesh = test::box({wall_mm - 50.0, 0, 0}, {100, 200, 200});
    model.moving.contact.mesh = test::box({wall_mm - 50.0, -150, 0}, {50, 50, 50});
    test::add_follower(model, BodyIndex::reference, {wall_mm + 2.001, 0, 0},
                       [&](double, double) { return row.at; });
    row.change(model);
    store::ForceRows& forces = model.followers[0].forces;
    forces.row_start = {0, 1};
    forces.point_world_mm = Eigen::RowVector3d(wall_mm, row.at(4) + 3.0, 0.0);
    forces.triangle_reference = forces.triangle_moving = {0};
    const analysis::PoseAssessment found = analysis::assess_poses(model, {}, {}, 1).followers.at(0);
    EXPECT_EQ(found.is_overlapping(0, 0), row.wanted == not_judged ? 1 : 0);
    EXPECT_STREQ(name_of(static_cast<Plausibility>(found.plausibility(0, 0))), name_of(row.wanted));
  }
}

}  // namespace vrda::analysis_followers_test
