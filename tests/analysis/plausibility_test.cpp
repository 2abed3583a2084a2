// Prescribed poses of boxes and balls.
#include "analysis/audit.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/units.hpp"
#include "store/solved_cells.hpp"
#include "support/meshes.hpp"

namespace vrda::analysis::plausibility_test {

/// `mesh` rotated about Z, with its ridge along Z.
Mesh turned_about_z(const Mesh& mesh, double angle_rad)
{
  Pose X = Pose::Identity();
  X.linear() = rotation_z(angle_rad);
  return transformed(mesh, X);
}

/// One stable attitude: the reference mesh in place, the moving one translated by `at_mm`.
store::MotionModel posed_model(const Mesh& reference, const Mesh& moving, const Eigen::Vector3d& at_mm,
                               double flexion_deg = 0.0, double varus_deg = 0.0)
{
  store::MotionModel model;
  model.joint = "other";
  model.side = "right";
  model.method = "stability-search";
  model.has_compartments = false;
  model.contact_resolution_mm = 0.1;
  model.flexion_deg = {flexion_deg};
  model.varus_deg = {0.0};
  model.reference.contact.mesh = reference;
  model.moving.contact.mesh = moving;
  model = store::with_pending_cells(std::move(model));
  StepRecord record;
  record.status = StepStatus::stable;
  record.pose.translation_mm = at_mm;
  record.varus_rad = rad_from_deg(varus_deg);
  store::set_cell(model, record);
  return model;
}

void expect_plausibility(const store::MotionModel& model, Plausibility wanted,
                         const model::Ligaments& ligaments = {}, const JointBounds& bounds = {})
{
  const PoseAssessment found = assess_poses(model, ligaments, bounds, 1);
  EXPECT_EQ(found.is_overlapping(0, 0), 0);
  EXPECT_STREQ(name_of(static_cast<Plausibility>(found.plausibility(0, 0))), name_of(wanted));
}

Mesh stretched(Mesh mesh, const Eigen::Vector3d& factor)
{
  for (int k = 0; k < 3; ++k) mesh.vertices_mm.col(k) *= factor[k];
  return mesh;
}

/// A spike 60 mm high on its square base of 20 mm; its tip points up.
Mesh upright_spike()
{
  Mesh mesh;
  mesh.vertices_mm.resize(5, 3);
  mesh.vertices_mm << 0, 30, 0, -10, -30, -10, -10, -30, 10, 10, -30, 10, 10, -30, -10;
  mesh.triangles.resize(6, 3);
  mesh.triangles << 0, 1, 2, 0, 2, 3, 0, 3, 4, 0, 4, 1, 1, 3, 2, 1, 4, 3;
  return mesh;
}

/// A sheet facing down: level along X and Z, +-45 degrees along the diagonals.
Mesh saddle(double sign)
{
  Mesh mesh;
  mesh.vertices_mm.resize(9, 3);
  mesh.triangles.resize(8, 3);
  mesh.vertices_mm.row(0).setZero();
  constexpr int around[8][2] = {{1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}, {0, -1}, {1, -1}};
  for (int k = 0; k < 8; ++k) {
    const double x = 10.0 * around[k][0], z = 10.0 * around[k][1];
    mesh.vertices_mm.row(k + 1) << x, sign * 0.1 * x * z * 0.5, z;
    mesh.triangles.row(k) << 0, k + 1, (k + 1) % 8 + 1;
  }
  return mesh;
}

/// The model as an equilibrium under this force.
store::MotionModel loaded(store::MotionModel model, const Eigen::Vector3d& force_n,
                          std::int64_t n_contacts = 1)
{
  model.method = "equilibrium";
  model.equilibrium.emplace().forces.row_start = {0, n_contacts};
  model.push.force_n.row(0) = force_n.transpose();
  return model;
}

constexpr double apart_mm = 1e-3;  // the search's stand-off
const Mesh block = test::box({0, 0, 0}, {30, 10, 30});
const Mesh ridge = turned_about_z(test::box({0, 0, 0}, {30, 30, 30}), pi / 4.0);
constexpr double other_varus_deg = 1e-6;  // not the grid's, which makes it free
const Mesh spike = upright_spike(), hanging_spike = turned_about_z(spike, pi);
const double ridge_mm = 15.0 * std::sqrt(2.0);

TEST(Plausibility, OfUnloadedPoses)
{
  using enum Plausibility;
  const Mesh strip = test::box({0, 0, 0}, {0.08, 10, 30}), steep = stretched(ridge, {1, 2, 1}),
             ball = test::ball(20);
  const double steep_mm = -4.0 * ridge_mm, on_ridge_mm = -2.0 * ridge_mm;
  struct Row {
    const char* name;
    store::MotionModel model;
    Plausibility wanted;
  };
  for (const Row& row : std::vector<Row>{
           {"a block under a block", posed_model(block, block, {3, -10 - apart_mm, 2}), nothing_found},
           {"a gap beyond the resolution", posed_model(block, block, {3, -10.2, 2}), nothing_ahead},
           {"beside it", posed_model(block, block, {40, -10 - apart_mm, 2}), nothing_ahead},
           // The sides are flush: contact on a line. Half a resolution of width is too little, two are
           // enough.
           {"on its edge", posed_model(block, block, {30, -10 - apart_mm, 0}), nothing_ahead},
           {"half a resolution", posed_model(block, block, {29.95, -10 - apart_mm, 0}), nothing_ahead},
           {"two resolutions", posed_model(block, block, {29.8, -10 - apart_mm, 0}), nothing_found},
           // Less than a resolution of width along X or Z, more than its share along a diagonal.
           {"narrow along X", posed_model(block, block, {29.92, -10 - apart_mm, 0}), nothing_ahead},
           {"narrow along Z", posed_model(block, block, {0, -10 - apart_mm, 29.92}), nothing_ahead},
           // Displaced to either side it misses: no balance, since there is no contact at all.
           {"a narrow strip", posed_model(strip, strip, {0, -10 - apart_mm, 0}), nothing_ahead},
           {"a ridge on a ridge", posed_model(ridge, ridge, {0, on_ridge_mm - apart_mm, 0}),
            unstable_balance},
           {"a pole on a pole", posed_model(ball, ball, {0, -40 - apart_mm, 0}), unstable_balance},
           // A slope of 2: one resolution to the side the contact is two resolutions higher.
           {"steep ridges", posed_model(steep, steep, {0, steep_mm - apart_mm, 0}), unstable_balance},
           {"a gap before balance", posed_model(ridge, ridge, {0, on_ridge_mm - 0.2, 0}), nothing_ahead},
           // Both flanks are at 45 degrees: one direction goes down by as much as the other goes up.
           {"off a ridge", posed_model(ridge, ridge, {1, on_ridge_mm + 1 - apart_mm, 0}), nothing_ahead},
           // Level along X and Z; along one diagonal the contact is higher both ways, along the other lower.
           {"a saddle", posed_model(saddle(1), spike, {0, -30 - apart_mm, 0}), unstable_balance},
           {"its mirror image", posed_model(saddle(-1), spike, {0, -30 - apart_mm, 0}), unstable_balance},
           // The reference turns about its origin: its tip is higher after a rotation either way.
           {"given varus", posed_model(hanging_spike, block, {0, -35 - apart_mm, 0}), nothing_found},
           {"free varus", posed_model(hanging_spike, block, {0, -35 - apart_mm, 0}, 0, other_varus_deg),
            unstable_balance}}) {
    SCOPED_TRACE(row.name);
    expect_plausibility(row.model, row.wanted);
  }
}

TEST(Plausibility, LoadsOfTheEquilibriumTakePart)
{
  const Mesh low = stretched(ridge, {1, 0.5, 1});
  const store::MotionModel ridges = posed_model(low, low, {0, -ridge_mm - apart_mm, 0});
  expect_plausibility(loaded(ridges, {0, 20, 0}), Plausibility::unstable_balance);
  // 16 N along 0.1 mm against 20 N along 0.05 mm: lower on one side only.
  expect_plausibility(loaded(ridges, {16, 20, 0}), Plausibility::nothing_found);

  const store::MotionModel spiked =
      posed_model(hanging_spike, block, {0, -35 - apart_mm, 0}, 0, other_varus_deg);
  expect_plausibility(loaded(spiked, {0, 20, 0}), Plausibility::unstable_balance);
  // A resolution turns a block 30 mm wide by 0.1 / 15 rad; the tip is 0.0007 mm higher, 0.013 N mm.
  store::MotionModel turned = loaded(spiked, {0, 20, 0});
  turned.push.varus_moment_nmm[0] = 10;
  expect_plausibility(turned, Plausibility::nothing_found);
  store::MotionModel off_centre = loaded(spiked, {0, 20, 0});
  off_centre.push.point_mm.z() = 1;
  expect_plausibility(off_centre, Plausibility::nothing_found);
}

TEST(Plausibility, FibresTakePartAtTheirFlexion)
{
  // At 90 degrees the fibre pulls sideways with 14 N against 7 N of push and fibre up flanks of 45 degrees.
  model::Ligaments ligaments;
  ligaments.fibres.push_back({"f", "f", {0, 100, 0}, {0, 0, 0}, 20.0, 60.0});
  const store::MotionModel ridges = posed_model(ridge, ridge, {0, -2.0 * ridge_mm - apart_mm, 0}, 90.0);
  expect_plausibility(ridges, Plausibility::unstable_balance);
  expect_plausibility(ridges, Plausibility::nothing_ahead, ligaments);
}

TEST(Plausibility, AnEquilibriumWithoutContactIsNotDoubted)
{
  const store::MotionModel apart = posed_model(block, block, {3, -10 - 5, 2});
  expect_plausibility(apart, Plausibility::nothing_ahead);
  expect_plausibility(loaded(apart, {0, 20, 0}, 0), Plausibility::nothing_found);
  expect_plausibility(loaded(apart, {0, 20, 0}, 1), Plausibility::nothing_ahead);
}

TEST(Plausibility, ARidgeInAGrooveIsHeldAndABallMayTurnIntoAHigherPose)
{
  // Two slabs leaning against each other; their lower faces meet at 45 degrees, 5 sqrt(2) below the top.
  Mesh groove = turned_about_z(test::box({15, 0, 0}, {30, 10, 60}), -pi / 4.0);
  append(groove, turned_about_z(test::box({-15, 0, 0}, {30, 10, 60}), pi / 4.0));
  const double apex_mm = -5.0 * std::sqrt(2.0);
  expect_plausibility(posed_model(groove, ridge, {0, apex_mm - ridge_mm - apart_mm, 0}),
                      Plausibility::nothing_found);
  // The faceted ball is in contact at its two widest vertices and is narrower after a rotation either way.
  expect_plausibility(posed_model(groove, test::ball(6), {0, apex_mm - 6.0 * std::sqrt(2.0) - apart_mm, 0}),
                      Plausibility::unstable_balance);
  // A moment about Delta turns it one way.
  store::MotionModel turned = loaded(
      posed_model(groove, test::ball(6), {0, apex_mm - 6.0 * std::sqrt(2.0) - apart_mm, 0}), {0, 20, 0});
  expect_plausibility(turned, Plausibility::unstable_balance);
  turned.push.moment_nmm[0] = 200;
  expect_plausibility(turned, Plausibility::nothing_found);
}

TEST(Plausibility, OverlapsAndUnsolvedCellsAreNotJudged)
{
  const store::MotionModel model = posed_model(block, block, {3, -8, 2});
  for (const bool is_solved : {true, false}) {
    const PoseAssessment found =
        assess_poses(is_solved ? model : store::with_pending_cells(model), {}, {}, 1);
    EXPECT_EQ(found.is_overlapping(0, 0) == 1, is_solved);
    EXPECT_EQ(static_cast<Plausibility>(found.plausibility(0, 0)), Plausibility::not_judged);
  }
}

TEST(Plausibility, APoseBeyondTheJointsBoundsIsDislocated)
{
  const MovingPose at{{3, -10 - apart_mm, 2}, 0.0};
  const store::MotionModel model = posed_model(block, block, at.translation_mm);
  JointBounds bounds;
  bounds.neutral_mm = at.translation_mm - Eigen::Vector3d(3.0, 0.0, 4.0);
  bounds.max_travel_mm = 5.0 + 1e-9;  // the pose is 5 mm away, to rounding
  expect_plausibility(model, Plausibility::nothing_found, {}, bounds);
  bounds.max_travel_mm = 4.99;
  expect_plausibility(model, Plausibility::dislocated, {}, bounds);
  bounds = {};
  bounds.neutral_theta_rad = rad_from_deg(46.0);
  bounds.max_theta_rad = rad_from_deg(45.0);
  expect_plausibility(model, Plausibility::dislocated, {}, bounds);
  bounds.neutral_theta_rad = rad_from_deg(-316.0);  // 44 degrees the other way round
  expect_plausibility(model, Plausibility::nothing_found, {}, bounds);
}

store::MotionModel with_contact(store::MotionModel model, const Eigen::Vector3d& point_mm,
                                std::int32_t triangle_reference, std::int32_t triangle_moving)
{
  store::ContactRows& rows = model.contacts;
  rows.row_start = {0, 1};
  rows.point_world_mm.resize(1, 3);
  rows.point_world_mm.row(0) = point_mm.transpose();
  rows.normal_world.resize(1, 3);
  rows.normal_world.row(0) = -Eigen::RowVector3d::UnitY();
  rows.distance_mm = {apart_mm};
  rows.triangle_reference = {triangle_reference};
  rows.triangle_moving = {triangle_moving};
  rows.compartment = {0};
  return model;
}

TEST(Plausibility, AContactWhereASheetEndsIsABorderContact)
{
  // Two triangles over [-15, 15] x [-15, 15] that share the diagonal x = z; the normal is downward.
  Mesh sheet;
  sheet.vertices_mm.resize(4, 3);
  sheet.vertices_mm << -15, 0, -15, 15, 0, -15, 15, 0, 15, -15, 0, 15;
  sheet.triangles.resize(2, 3);
  sheet.triangles << 0, 1, 2, 0, 2, 3;
  const Eigen::Vector3d below(0, -5 - apart_mm, 0);
  const store::MotionModel model = posed_model(sheet, test::box({0, 0, 0}, {60, 10, 60}), below);
  expect_plausibility(with_contact(model, {15, 0, 0}, 0, 0), Plausibility::border_contact);
  expect_plausibility(with_contact(model, {14.95, 0, 0}, 0, 0), Plausibility::border_contact);
  expect_plausibility(with_contact(model, {14.8, 0, 0}, 0, 0), Plausibility::nothing_found);
  expect_plausibility(with_contact(model, {5, 0, 5}, 0, 0), Plausibility::nothing_found);  // the diagonal
  // A damaged journal may name a triangle that the mesh does not have.
  expect_plausibility(with_contact(model, {15, 0, 0}, 2, 100), Plausibility::nothing_found);
  // The sheet as the moving object, 5 mm to the right; a closed block has no border.
  const store::MotionModel swapped =
      posed_model(test::box({0, 0, 0}, {80, 10, 80}), sheet, {5, -5 - apart_mm, 0});
  expect_plausibility(with_contact(swapped, {20, -5, 0}, 0, 0), Plausibility::border_contact);
  expect_plausibility(with_contact(swapped, {15, -5, 0}, 0, 0), Plausibility::nothing_found);
}

store::MotionModel with_fibres(store::MotionModel model, const std::vector<std::string>& bundles,
                               const std::vector<double>& strain, const std::vector<double>& tension_n)
{
  store::LigamentRows rows;
  rows.name = rows.bundle = bundles;
  rows.strain = strain;
  rows.tension_n = tension_n;
  model.ligaments = rows;
  return model;
}

TEST(Plausibility, FibresBeyondTheFailureOfLigamentsAreOverstrained)
{
  const store::MotionModel model = posed_model(block, block, {3, -10 - apart_mm, 2});
  const std::vector<std::string> bundles{"ACL", "PCL", "ACL"};
  expect_plausibility(with_fibres(model, bundles, {0.1, 0.44, 0.2}, {865, 1000, 865}),
                      Plausibility::nothing_found);
  expect_plausibility(with_fibres(model, bundles, {0.1, 0.45, 0.2}, {100, 100, 100}),
                      Plausibility::overstrained);
  expect_plausibility(with_fibres(model, bundles, {0.1, 0.1, 0.1}, {865, 0, 866}),
                      Plausibility::overstrained);
}

}  // namespace vrda::analysis::plausibility_test
