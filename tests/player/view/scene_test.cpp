#include "view/scene.hpp"

#include <gtest/gtest.h>

#include "core/text.hpp"
#include "support/models.hpp"

namespace vrda::view::scene_test {

constexpr double rounding = 1e-11;        // mm, products of poses with coordinates of hundreds
constexpr double single_rounding = 1e-5;  // mm, single precision at tens of mm

store::MotionModel moving_model(const std::string& side)
{
  test::ModelPlan plan;
  plan.side = side;
  plan.rotation_centre_mm = {100, -200, 40};
  plan.motion = [](double flexion_deg, double varus_deg) {
    return store::PoseCoordinates{-0.05 * flexion_deg, -0.01 * flexion_deg, 0.2 * varus_deg,
                                  0.1 * flexion_deg};
  };
  store::MotionModel model = test::model_of(plan);
  test::add_bodies(model);
  return model;
}

Scene scene_for(const store::MotionModel& model)
{
  return scene_of(model.reference, model.moving, model.rotation_centre_mm);
}

double difference(const Pose& a, const Pose& b)
{
  return (a.matrix() - b.matrix()).cwiseAbs().maxCoeff();
}

// There is a drawable for each component with its material.
TEST(Scene, Drawables)
{
  store::MotionModel model = moving_model("right");
  model.moving.visual = model.moving.contact;  // the same components again as visual parts
  const Scene scene = scene_for(model);
  ASSERT_EQ(scene.drawables.size(), 5U);
  EXPECT_EQ(scene.drawables[0].name, "ball");
  EXPECT_EQ(scene.drawables[0].parent, BodyIndex::reference);
  EXPECT_EQ(scene.drawables[2].name, "plate");
  EXPECT_EQ(scene.drawables[2].parent, BodyIndex::moving);
  EXPECT_TRUE(scene.drawables[2].has_contact);
  EXPECT_FALSE(scene.drawables[4].has_contact);
  EXPECT_EQ(scene.drawables[2].material.opacity, 1.0F);  // tissue, not glass
  EXPECT_EQ(scene.drawables[0].material.opacity, 1.0F);
}

// The relative pose is X_reference_moving whichever object is fixed.
TEST(Scene, RelativePose)
{
  for (const std::string side : {"right", "left"}) {
    const store::MotionModel model = moving_model(side);
    const store::Motion motion(model, "raw");
    Scene scene = scene_for(model);
    for (const BodyIndex held : {BodyIndex::moving, BodyIndex::reference, BodyIndex::world}) {
      for (const double flexion_deg : {0.0, 40.0, 90.0}) {
        const store::JointPose pose = motion.at({rad_from_deg(flexion_deg), rad_from_deg(1.5)});
        place(scene, frames_of(pose, held, model.rotation_centre_mm));
        // mesh = stored - origin, for both objects
        Pose X_stored_mesh = Pose::Identity();
        X_stored_mesh.translation() = model.rotation_centre_mm;
        const Pose X_world_reference = scene.drawables[0].X_world_mesh * X_stored_mesh.inverse();
        const Pose X_world_moving = scene.drawables[1].X_world_mesh * X_stored_mesh.inverse();
        EXPECT_LT(difference(X_world_reference.inverse() * X_world_moving, pose.X_reference_moving),
                  rounding);
      }
    }
  }
}

TEST(Scene, FixedObjectStays)
{
  struct Row {
    BodyIndex fixed;
    std::size_t body, other;  // rows of the drawables
  };
  for (const std::string side : {"right", "left"}) {
    const store::MotionModel model = moving_model(side);
    const store::Motion motion(model, "raw");
    Scene scene = scene_for(model);
    for (const Row& row : {Row{BodyIndex::moving, 1, 0}, Row{BodyIndex::reference, 0, 1}}) {
      for (const double flexion_deg : {0.0, 7.3, 33.0, 61.9, 90.0}) {
        const store::JointPose pose = motion.at({rad_from_deg(flexion_deg), rad_from_deg(-2.0)});
        place(scene, frames_of(pose, row.fixed, model.rotation_centre_mm));
        // The mesh is relative to the rotation centre, which is the origin of the screen's world.
        EXPECT_EQ(scene.drawables[row.body].X_world_mesh.matrix(), Eigen::Matrix4d::Identity())
            << flexion_deg;
        EXPECT_GT(difference(scene.drawables[row.other].X_world_mesh, Pose::Identity()), 1e-3);
      }
    }
  }
}

TEST(Scene, JointSphere)
{
  test::ModelPlan plan;
  store::MotionModel model = test::model_of(plan);
  test::add_bodies(model);
  Scene scene = scene_for(model);
  place(scene, frames_of(store::Motion(model, "raw").at({})));
  // Boxes: ball 20 about the origin; block and plate |x| <= 20, |z| <= 30, y from -35 to -20.
  const Sphere sphere = joint_sphere(scene, 0.5);
  EXPECT_LT((sphere.centre_world_mm - Eigen::Vector3d(0, -20, 0)).norm(), single_rounding);
  EXPECT_NEAR(sphere.radius_mm, 0.5 * 40.0, single_rounding);
  for (const Eigen::Vector3d& p_mm : points_within(scene, sphere)) {
    EXPECT_LE((p_mm - sphere.centre_world_mm).norm(), sphere.radius_mm);
  }
  std::size_t n_vertices = 0;
  for (const Drawable& drawable : scene.drawables) n_vertices += drawable.mesh.vertices.size();
  EXPECT_LT(points_within(scene, sphere).size(), n_vertices);
  EXPECT_EQ(points_within(scene, {}).size(), n_vertices);
}

}  // namespace vrda::view::scene_test
