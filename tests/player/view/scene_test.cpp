#include "view/scene.hpp"

#include <gtest/gtest.h>

#include "core/text.hpp"
#include "support/models.hpp"

namespace vrda::scene_test {

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

view::Scene scene_of(const store::MotionModel& model)
{
  return view::scene_of(model.reference, model.moving, model.rotation_centre_mm);
}

double difference(const Pose& a, const Pose& b)
{
  return (a.matrix() - b.matrix()).cwiseAbs().maxCoeff();
}

TEST(Scene, ThereIsADrawableForEachComponentWithItsMaterial)
{
  store::MotionModel model = moving_model("right");
  model.moving.visual = model.moving.contact;  // the same components again as visual parts
  const view::Scene scene = scene_of(model);
  ASSERT_EQ(scene.drawables.size(), 5U);
  EXPECT_EQ(scene.drawables[0].name, "ball");
  EXPECT_EQ(scene.drawables[0].parent, view::ParentFrame::reference);
  EXPECT_EQ(scene.drawables[2].name, "plate");
  EXPECT_EQ(scene.drawables[2].parent, view::ParentFrame::moving);
  EXPECT_TRUE(scene.drawables[2].has_contact);
  EXPECT_FALSE(scene.drawables[4].has_contact);
  EXPECT_EQ(scene.drawables[2].material.opacity, 1.0F);  // tissue, not glass
  EXPECT_EQ(scene.drawables[0].material.opacity, 1.0F);
}

TEST(Scene, ATriangleOfNoComponentIsABrokenPromise)
{
  store::MotionModel model = moving_model("right");
  model.moving.contact.component.back() = 7;
  EXPECT_THROW(scene_of(model), InternalError);
  model.moving.contact.component.pop_back();
  EXPECT_THROW(scene_of(model), InternalError);
}

TEST(Scene, TheRelativePoseIsXReferenceMovingWhicheverObjectIsFixed)
{
  for (const std::string side : {"right", "left"}) {
    const store::MotionModel model = moving_model(side);
    const store::Motion motion(model, "raw");
    view::Scene scene = scene_of(model);
    for (const view::FixedObject held :
         {view::FixedObject::moving, view::FixedObject::reference, view::FixedObject::push}) {
      for (const double flexion_deg : {0.0, 40.0, 90.0}) {
        const store::JointPose pose = motion.at({rad_from_deg(flexion_deg), rad_from_deg(1.5)});
        view::place(scene, view::frames_of(pose, held, model.rotation_centre_mm));
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

TEST(Scene, AFixedObjectStaysWhereItIsBitForBit)
{
  struct Row {
    view::FixedObject fixed;
    std::size_t body, other;  // rows of the drawables
  };
  for (const std::string side : {"right", "left"}) {
    const store::MotionModel model = moving_model(side);
    const store::Motion motion(model, "raw");
    view::Scene scene = scene_of(model);
    for (const Row& row : {Row{view::FixedObject::moving, 1, 0}, Row{view::FixedObject::reference, 0, 1}}) {
      for (const double flexion_deg : {0.0, 7.3, 33.0, 61.9, 90.0}) {
        const store::JointPose pose = motion.at({rad_from_deg(flexion_deg), rad_from_deg(-2.0)});
        view::place(scene, view::frames_of(pose, row.fixed, model.rotation_centre_mm));
        // The mesh is relative to the rotation centre, which is the origin of the screen's world.
        EXPECT_EQ(scene.drawables[row.body].X_world_mesh.matrix(), Eigen::Matrix4d::Identity())
            << flexion_deg;
        EXPECT_GT(difference(scene.drawables[row.other].X_world_mesh, Pose::Identity()), 1e-3);
      }
    }
  }
}

TEST(Scene, WithAFixedPushTheObjectsHaveTheirPosesInItsFrame)
{
  const store::JointPose pose = store::Motion(moving_model("left"), "raw").at({rad_from_deg(33.0), 0.0});
  const view::JointFrames frames = view::frames_of(pose, view::FixedObject::push);
  EXPECT_EQ(frames.X_world_reference.matrix(), pose.X_world_reference.matrix());
  EXPECT_EQ(frames.X_world_moving.matrix(), pose.X_world_moving.matrix());
}

TEST(Scene, TheJointSphereLiesWhereTheObjectsMeet)
{
  test::ModelPlan plan;
  store::MotionModel model = test::model_of(plan);
  test::add_bodies(model);
  view::Scene scene = scene_of(model);
  view::place(scene, view::frames_of(store::Motion(model, "raw").at({})));
  // Boxes: ball 20 about the origin; block and plate |x| <= 20, |z| <= 30, y from -35 to -20.
  const view::Sphere sphere = view::joint_sphere(scene, 0.5);
  EXPECT_LT((sphere.centre_world_mm - Eigen::Vector3d(0, -20, 0)).norm(), single_rounding);
  EXPECT_NEAR(sphere.radius_mm, 0.5 * 40.0, single_rounding);
  for (const Eigen::Vector3d& p_mm : view::points_within(scene, sphere)) {
    EXPECT_LE((p_mm - sphere.centre_world_mm).norm(), sphere.radius_mm);
  }
  std::size_t n_vertices = 0;
  for (const view::Drawable& drawable : scene.drawables) n_vertices += drawable.mesh.vertices.size();
  EXPECT_LT(view::points_within(scene, sphere).size(), n_vertices);
  EXPECT_EQ(view::points_within(scene, {}).size(), n_vertices);
}

TEST(Scene, AnEmptySceneHasAnEmptySphere)
{
  EXPECT_EQ(view::joint_sphere({}).radius_mm, 0.0);
}

TEST(Scene, EveryBackdropHasColoursAndBlackIsBlack)
{
  EXPECT_EQ(view::background_of(view::Backdrop::black).top, Eigen::Vector3f::Zero());
  EXPECT_EQ(view::background_of(view::Backdrop::black).bottom, Eigen::Vector3f::Zero());
  EXPECT_GT(view::background_of(view::Backdrop::studio).top.sum(),
            view::background_of(view::Backdrop::night).top.sum());
  EXPECT_LE(view::studio_lighting().lights.size(), view::most_lights);
}

}  // namespace vrda::scene_test
