// Bodies, markers and lights of a scene.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <array>
#include <cmath>
#include <random>

#include "core/text.hpp"
#include "core/units.hpp"
#include "support/models.hpp"
#include "support/scratch.hpp"
#include "view/scene.hpp"

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

constexpr double single_rounding_mm = 1e-4;  // single precision at 100 mm, summed

Eigen::Vector3d position(const RenderVertex& vertex)
{
  return {vertex.position_mm[0], vertex.position_mm[1], vertex.position_mm[2]};
}
Eigen::Vector3d normal(const RenderVertex& vertex)
{
  return {vertex.normal[0], vertex.normal[1], vertex.normal[2]};
}

double volume_mm3(const RenderMesh& mesh)
{
  double volume = 0.0;
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 3) {
    const Eigen::Vector3d a = position(mesh.vertices[mesh.triangles[t]]),
                          b = position(mesh.vertices[mesh.triangles[t + 1]]),
                          c = position(mesh.vertices[mesh.triangles[t + 2]]);
    volume += a.dot(b.cross(c)) / 6.0;
  }
  return volume;
}

/// Checks that normals are unit vectors on the outer side of their faces.
void expect_sound(const RenderMesh& mesh)
{
  for (const RenderVertex& vertex : mesh.vertices) EXPECT_NEAR(normal(vertex).norm(), 1.0, 1e-3);
  int n_faces = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 3) {
    const Eigen::Vector3d a = position(mesh.vertices[mesh.triangles[t]]),
                          b = position(mesh.vertices[mesh.triangles[t + 1]]),
                          c = position(mesh.vertices[mesh.triangles[t + 2]]);
    const Eigen::Vector3d face = (b - a).cross(c - a);
    const bool is_face = face.norm() > 1e-6;  // degenerate triangles have no area
    n_faces += is_face ? 1 : 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const double agreement = face.dot(normal(mesh.vertices[mesh.triangles[t + k]]));
      EXPECT_TRUE(!is_face || agreement > -1e-6 * face.norm());
    }
  }
  EXPECT_GT(n_faces, 40);
}

double polygon_part(double sides)  // area of the regular polygon / area of its circle
{
  return 0.5 * sides * std::sin(2.0 * pi / sides) / pi;
}

TEST(Solids, Ball)
{
  RenderMesh mesh;
  add_balls(mesh, 1);
  EXPECT_EQ(mesh.vertices.size(), ball_size().n_vertices);
  EXPECT_EQ(mesh.triangles.size(), ball_size().n_indices);
  const Eigen::Vector3d centre(40, -30, 7);
  set_ball(mesh, 0, centre, 5.0);
  for (const RenderVertex& vertex : mesh.vertices) {
    EXPECT_NEAR((position(vertex) - centre).norm(), 5.0, single_rounding_mm);
    EXPECT_LT((position(vertex) - centre - 5.0 * normal(vertex)).norm(), single_rounding_mm);
  }
  expect_sound(mesh);
  EXPECT_GT(volume_mm3(mesh), 0.88 * 4.0 / 3.0 * pi * 125.0);
  EXPECT_LT(volume_mm3(mesh), 4.0 / 3.0 * pi * 125.0);
}

TEST(Solids, RodAndTube)
{
  const Eigen::Vector3d from(3, 4, 5), to(-20, 30, 11);
  const double circle_mm3 = pi * 4.0 * (to - from).norm();
  RenderMesh rod;
  add_rods(rod, 1);
  set_rod(rod, 0, from, to, 2.0);
  expect_sound(rod);
  EXPECT_NEAR(volume_mm3(rod), polygon_part(12.0) * circle_mm3, 1e-4 * circle_mm3);
  RenderMesh tube;
  const std::array<Eigen::Vector3d, 4> way{from, 0.7 * from + 0.3 * to, 0.7 * from + 0.3 * to, to};
  add_tube(tube, way.size());
  EXPECT_EQ(tube.vertices.size(), tube_size(4).n_vertices);
  EXPECT_EQ(tube.triangles.size(), tube_size(4).n_indices);
  set_tube(tube, 0, way, 2.0);
  expect_sound(tube);
  EXPECT_NEAR(volume_mm3(tube), polygon_part(n_tube_sides) * circle_mm3, 1e-4 * circle_mm3);
}

TEST(Solids, Band)
{
  // A twisted band along Y: its width turns from X to Z.
  std::array<Eigen::Vector3d, 5> way;
  for (std::size_t k = 0; k < way.size(); ++k) way[k] = {0.0, 10.0 * static_cast<double>(k), 0.0};
  RenderMesh mesh;
  add_tube(mesh, way.size());
  set_band(mesh, 0, way, {3.0, 0.5, {2.0, 1.0, 0.0}, {0.0, 1.0, 2.0}});
  expect_sound(mesh);
  for (std::size_t k = 0; k < way.size(); ++k) {
    SCOPED_TRACE(k);
    const double part = static_cast<double>(k) / 4.0;
    const Eigen::Vector3d wide = Eigen::Vector3d(1.0 - part, 0.0, part).normalized();
    const Eigen::Vector3d thin = Eigen::Vector3d(-part, 0.0, 1.0 - part).normalized();
    double width_mm = 0.0, thickness_mm = 0.0;
    for (std::size_t side = 0; side < n_tube_sides; ++side) {
      const RenderVertex& vertex = mesh.vertices[n_tube_sides * (k + 1) + side];
      const Eigen::Vector3d from_axis = position(vertex) - way[k];
      EXPECT_NEAR(from_axis.y(), 0.0, single_rounding_mm);
      // The normal of the ellipse (x / 3)^2 + (z / 0.5)^2 = 1.
      const double x = from_axis.dot(wide), z = from_axis.dot(thin);
      EXPECT_NEAR(x * x / 9.0 + z * z / 0.25, 1.0, single_rounding_mm);
      const Eigen::Vector3d gradient = (x / 9.0 * wide + z / 0.25 * thin).normalized();
      EXPECT_NEAR(gradient.dot(normal(vertex)), 1.0, single_rounding_mm);
      width_mm = std::max(width_mm, x);
      thickness_mm = std::max(thickness_mm, z);
    }
    EXPECT_NEAR(width_mm, 3.0, single_rounding_mm);
    EXPECT_NEAR(thickness_mm, 0.5, single_rounding_mm);
  }
}

TEST(Solids, Arrow)
{
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(-50.0, 50.0);
  int n_short = 0, n_long = 0;
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector3d from(place(random), place(random), place(random));
    const Eigen::Vector3d along = Eigen::Vector3d(place(random), place(random), place(random)).normalized();
    const double length_mm = i % 2 == 0 ? 1.0 : 25.0;
    n_short += i % 2 == 0 ? 1 : 0;
    n_long += i % 2 == 0 ? 0 : 1;
    RenderMesh mesh;
    add_arrows(mesh, 1);
    set_arrow(mesh, 0, from, from + length_mm * along, 0.6);
    expect_sound(mesh);
    double low = 1e9, high = -1e9;
    for (const RenderVertex& vertex : mesh.vertices) {
      low = std::min(low, (position(vertex) - from).dot(along));
      high = std::max(high, (position(vertex) - from).dot(along));
    }
    EXPECT_NEAR(low, 0.0, single_rounding_mm);
    EXPECT_NEAR(high, length_mm, single_rounding_mm);
  }
  EXPECT_EQ(n_short, 100);
  EXPECT_EQ(n_long, 100);
}

TEST(LightsFile, TheExampleIsTheStudio)
{
  const Lights lights = read_lights(VRDA_JOBS "/lights-studio.toml");
  const Lighting studio = studio_lighting();
  EXPECT_EQ(lights.lighting.sky, studio.sky);
  EXPECT_EQ(lights.lighting.ground, studio.ground);
  ASSERT_EQ(lights.lighting.lights.size(), studio.lights.size());
  for (std::size_t i = 0; i < studio.lights.size(); ++i) {
    EXPECT_EQ(lights.lighting.lights[i].towards_camera, studio.lights[i].towards_camera);
    EXPECT_EQ(lights.lighting.lights[i].colour, studio.lights[i].colour);
  }
  ASSERT_TRUE(lights.background.has_value());
  EXPECT_EQ(lights.background->top, background_of(Backdrop::studio).top);
  EXPECT_EQ(lights.background->bottom, background_of(Backdrop::studio).bottom);
}

// A follower is drawn in its own frame, whatever is fixed on screen, and hidden where it has no pose.
TEST(Scene, DrawsWhatFollowsTheJoint)
{
  store::MotionModel model = moving_model("right");
  test::add_follower(model, BodyIndex::reference, {40, 5, 0}, [](double flexion_deg, double) {
    JointCoordinates q = JointCoordinates::Zero();
    q(0) = rad_from_deg(flexion_deg);
    q(4) = -0.3 * flexion_deg;
    return q;
  });
  model.followers[0].status(6, 2) = static_cast<std::int8_t>(StepStatus::unbounded);
  Scene scene = scene_of(model, model.rotation_centre_mm);
  const std::vector<bool> shown = shown_drawables(scene);
  const Drawable& bead = scene.drawables.back();
  ASSERT_EQ(bead.name, "bead");
  ASSERT_EQ(bead.parent, model::follower_index(0));
  const store::Motion motion(model, "raw");
  const store::JointPose pose = motion.at({rad_from_deg(30.0), 0.0}),
                         none = motion.at({rad_from_deg(90.0), 0.0});
  for (const BodyIndex fixed : holdable) {
    const JointFrames frames = frames_of(pose, fixed, model.rotation_centre_mm);
    place(scene, frames);
    show_bodies(scene, shown, fixed, true, frames);
    EXPECT_TRUE(bead.is_shown);
    const Pose X_reference_bead = frames.X_world_reference.inverse() * frames.of(model::follower_index(0));
    EXPECT_LT(difference(X_reference_bead, pose.X_reference_follower[0]), rounding);
    EXPECT_LT((bead.X_world_mesh.translation() - frames.of(bead.parent) * bead.origin_mm).norm(), rounding);
  }
  const JointFrames frames = frames_of(none);
  place(scene, frames);
  show_bodies(scene, shown, BodyIndex::world, true, frames);
  EXPECT_FALSE(bead.is_shown);
  EXPECT_TRUE(scene.drawables.front().is_shown);
}

}  // namespace vrda::view::scene_test
