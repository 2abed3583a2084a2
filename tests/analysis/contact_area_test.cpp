#include <gtest/gtest.h>

#include <cmath>

#include "analysis/flexion_curves.hpp"
#include "core/units.hpp"
#include "model/coordinates.hpp"
#include "support/meshes.hpp"
#include "support/models.hpp"

namespace vrda::analysis::contact_area_test {

constexpr double radius_mm = 20.0;

/// A ball whose centre is at the origin under a plate whose lower face is the plane y = 0; no compartments.
store::MotionModel ball_under_plate()
{
  store::MotionModel model = test::model_of({});
  model.has_compartments = false;
  model.reference.contact.mesh = test::box({0, 5, 0}, {90, 10, 90});
  model.moving.contact.mesh = test::ball(radius_mm, 180, 360);
  return model;
}

store::JointPose at_gap(double gap_mm)
{
  store::JointPose pose;
  pose.X_reference_moving = Pose(Eigen::Translation3d(0, -radius_mm - gap_mm, 0));
  return pose;
}

double area_mm2(const store::MotionModel& model, const store::JointPose& pose)
{
  const CurveGroup group = contact_area(model, {pose}, 1).front();
  EXPECT_EQ(group.curves.size(), 1u);
  return group.curves.front().values.front();
}

// Facets of 1 degree are up to R (1 - cos(half a degree)) inside the ball.
constexpr double sagitta_mm = radius_mm * rad_from_deg(0.5) * rad_from_deg(0.5) / 2.0;
constexpr double per_mm_mm2 = 2.0 * pi * radius_mm;  ///< area of a cap a height

TEST(ContactArea, OfABallUnderAPlaneIsItsCap)
{
  // 2 pi R (d - g): the cap above the plane at the distance that counts
  const store::MotionModel model = ball_under_plate();
  for (const double gap_mm : {0.0, 0.25, 0.5, 0.9, 1.1, 5.0}) {
    const double height_mm = std::max(0.0, contact_area_distance_mm - gap_mm);
    EXPECT_NEAR(area_mm2(model, at_gap(gap_mm)), per_mm_mm2 * height_mm, 2.0 * per_mm_mm2 * sagitta_mm)
        << gap_mm;
  }
}

TEST(ContactArea, OffsetsBringTheSurfacesNearerAndAMovedJointHasTheSame)
{
  store::MotionModel model = ball_under_plate();
  const double bare_mm2 = area_mm2(model, at_gap(0.2));
  for (Body* body : {&model.reference, &model.moving})
    body->contact.mesh.offset_mm.assign(static_cast<std::size_t>(body->contact.mesh.triangles.rows()), 0.15);
  EXPECT_NEAR(area_mm2(model, at_gap(0.5)), bare_mm2, 1e-6);
  Pose X = Pose::Identity();
  X.linear() = rotation_x(0.4) * rotation_z(-0.7);
  X.translation() << 300, -200, 100;
  model.reference.contact.mesh = transformed(model.reference.contact.mesh, X);
  store::JointPose turned = at_gap(0.5);
  turned.X_reference_moving = X * turned.X_reference_moving;
  EXPECT_NEAR(area_mm2(model, turned), bare_mm2, 1e-6);
}

TEST(ContactArea, OfCompartmentsIsThatOfTheirTriangles)
{
  store::MotionModel model = ball_under_plate();
  const double whole_mm2 = area_mm2(model, at_gap(0.3));
  model.has_compartments = true;
  const Mesh& ball = model.moving.contact.mesh;
  for (Eigen::Index t = 0; t < ball.triangles.rows(); ++t) {
    const bool is_lateral = face_normal(ball, t).z() > 0.0;
    model.compartment_of_triangle.push_back(
        static_cast<std::int8_t>(is_lateral ? Compartment::lateral : Compartment::medial));
  }
  const CurveGroup group = contact_area(model, {at_gap(0.3)}, 2).front();
  ASSERT_EQ(group.curves.size(), 2u);
  EXPECT_EQ(group.curves[0].name, "contact_area_medial_mm2");
  // Halves of a cap, to a row of facets along the border.
  EXPECT_NEAR(group.curves[0].values[0], 0.5 * whole_mm2, 0.01 * whole_mm2);
  EXPECT_NEAR(group.curves[0].values[0] + group.curves[1].values[0], whole_mm2, 1e-9);
}

TEST(SpineCurves, HaveAValueForEachFlexionWithAPose)
{
  store::MotionModel model = ball_under_plate();
  test::unsolve(model, 1, 2);
  const std::vector<CurveGroup> groups = spine_curves(model, 1);
  ASSERT_EQ(groups.front().curves.front().values.size(), model.flexion_deg.size());
  for (std::size_t i = 0; i < model.flexion_deg.size(); ++i)
    EXPECT_EQ(std::isnan(groups.front().curves.front().values[i]), i == 1);
  EXPECT_TRUE(is_flexion_curve("contact_area_medial_mm2"));
  EXPECT_FALSE(is_flexion_curve("anterior_mm"));
}

}  // namespace vrda::analysis::contact_area_test
