// Structures, their picks, cuts and names in the picture.
#include "view/structures.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/meshes.hpp"
#include "support/models.hpp"
#include "view/camera.hpp"
#include "view/labels.hpp"
#include "view/layers.hpp"
#include "view/section.hpp"

namespace vrda::view::structures_test {

store::MotionModel knee(const std::string& side = "right")
{
  test::ModelPlan plan;
  plan.side = side;
  store::MotionModel model = test::model_of(plan);
  test::add_bodies(model);
  model.joint = "knee";
  model.has_compartments = true;
  const double z = side == "left" ? -1.0 : 1.0;
  store::LigamentRows rows;
  rows.name = {"a", "b"};
  rows.bundle = {"ACLam", "MCLs"};
  const Eigen::RowVector3d centre_mm = model.rotation_centre_mm.transpose();
  rows.reference_mm.resize(2, 3);
  rows.moving_mm.resize(2, 3);
  rows.reference_mm << centre_mm + Eigen::RowVector3d(0, 0, 0), centre_mm + Eigen::RowVector3d(0, 4, -22 * z);
  rows.moving_mm << centre_mm + Eigen::RowVector3d(0, -25, 0),
      centre_mm + Eigen::RowVector3d(0, -34, -31 * z);
  rows.stiffness_n = {1000, 2000};
  rows.slack_length_mm = {20, 40};
  rows.wrap = {-1, -1};
  rows.strain.assign(2 * static_cast<std::size_t>(model.status.size()), 0.0);
  model.ligaments = rows;
  return model;
}

/// A joint at its first pose.
struct Stage {
  explicit Stage(const store::MotionModel& shown)
      : model(shown), scene(scene_of(model, model.rotation_centre_mm)), layers(model, scene), caps(scene)
  {
    place();
  }
  void place()
  {
    const store::Motion motion(model, "raw");
    pose = motion.at({0.0, 0.0});
    const JointFrames frames = frames_of(pose);
    view::place(scene, frames);
    LayerSet shown;
    shown.set(Layer::ligaments, true);
    layers.update(scene, motion, {pose, frames, shown});
    caps.update(scene);
  }
  Drawable& of(const std::string& structure)
  {
    return *std::ranges::find(scene.drawables, structure, &Drawable::structure);
  }
  Camera camera(View view)
  {
    FrameOptions options;
    options.aspect = 1.0;
    CameraFit fit(view_rotation(view, side_named(model.side)), options);
    fit.include(points_within(scene, {Eigen::Vector3d::Zero(), 1e3}));
    return with_depth_range(fit.camera(), scene);
  }

  store::MotionModel model;
  Scene scene;
  JointLayers layers;
  SectionCaps caps;
  store::JointPose pose;
};

constexpr Viewport square{0, 0, 400, 400};
constexpr const char *femur = "bodies/reference/ball", *plate = "bodies/moving/plate";

TEST(Structures, OfAModel)
{
  store::MotionModel model = knee();
  model.moving.components[0] = {"plate_rim", "meniscus"};  // a part of the plate
  const std::vector<Structure> all = structures_of(model);
  std::vector<std::string> ids;
  for (const Structure& structure : all) ids.push_back(structure.id);
  EXPECT_EQ(ids, (std::vector<std::string>{femur, plate, "ligaments/ACLam", "ligaments/MCLs", gap_structure,
                                           paths_structure}));
  EXPECT_EQ(all[2].name, "ACL, anteromedial");
  EXPECT_EQ(all[2].does, "Keeps the tibia from sliding forwards, most in the bent knee.") << "as on the page";
}

// Each change leaves layers of contact as they are.
TEST(Structures, Changes)
{
  const std::vector<Structure> all = structures_of(knee());
  Looks looks{std::vector<StructureLook>(all.size()), 1};
  change(looks, all, LookChange::isolate);
  for (std::size_t k = 0; k < all.size(); ++k)
    EXPECT_EQ(looks.of[k].is_visible, k == 1 || all[k].group == StructureGroup::contact) << all[k].id;
  change(looks, all, LookChange::fade_others);
  EXPECT_EQ(looks.of[0], (StructureLook{true, faded_opacity}));
  EXPECT_EQ(looks.of[1], StructureLook{});
  change(looks, all, LookChange::show_all);
  EXPECT_EQ(looks.of, std::vector<StructureLook>(all.size()));
}

TEST(Structures, StrainOfABundle)
{
  const store::MotionModel model = knee();
  const store::JointPose pose = store::Motion(model, "raw").at({0.0, 0.0});
  const auto reading = BundleReader(model).at("ligaments/ACLam", pose);
  ASSERT_TRUE(reading.has_value());
  const double length_mm = (pose.X_reference_moving * model.ligaments->moving_mm.row(0).transpose() -
                            model.ligaments->reference_mm.row(0).transpose())
                               .norm();
  EXPECT_NEAR(reading->strain, length_mm / 20.0 - 1.0, 1e-12);
  EXPECT_FALSE(BundleReader(model).at(femur, pose).has_value());
}

// The nearest solid counts, also behind a faded or hidden structure, and a bundle near the pointer.
TEST(Pick, KnownPixels)
{
  Stage stage(knee());
  const auto at = [&](const Eigen::Vector3d& p_mm, View view = View::front) -> std::string {
    const Camera camera = stage.camera(view);
    const Eigen::Vector4d clip = projection(camera) * (camera.X_world_camera.inverse() * p_mm).homogeneous();
    const Eigen::Vector2d px =
        200.0 * (Eigen::Vector2d(clip.x(), -clip.y()) / clip.w() + Eigen::Vector2d(1, 1));
    const auto found = picked(stage.scene, camera, square, px, 4.0);
    return found ? stage.scene.drawables[found->drawable].structure : "";
  };
  const Eigen::Vector3d middle(0, 0, 0);
  EXPECT_EQ(at({0, -15, -26}), "ligaments/MCLs");
  stage.of("ligaments/ACLam").is_shown = false;
  EXPECT_EQ(at(middle), femur);
  EXPECT_EQ(at({0, -19.8, 0}, View::top), femur) << "in front of the plate";
  EXPECT_EQ(at({0, -22.5, 0}), plate);
  EXPECT_EQ(at({0, -30, 26}), "bodies/moving/block");
  EXPECT_EQ(at({0, 60, 60}), "");
  stage.of(femur).material.opacity = 0.2F;
  EXPECT_EQ(at(middle), femur) << "nothing solid is behind it";
  EXPECT_EQ(at({0, -19.8, 0}, View::top), plate);
  stage.of(femur).is_shown = false;
  EXPECT_EQ(at({0, -19.8, 0}, View::top), plate);
}

double area_mm2(const Drawable& cap)
{
  double area = 0.0;
  const auto corner = [&](std::size_t i) {
    const std::array<float, 3>& p = cap.mesh.vertices[cap.mesh.triangles[i]].position_mm;
    return Eigen::Vector3d(p[0], p[1], p[2]);
  };
  for (std::size_t i = 0; i < cap.mesh.triangles.size(); i += 3)
    area += 0.5 * (corner(i + 1) - corner(i)).cross(corner(i + 2) - corner(i)).norm();
  return area;
}

// The cut of a ball is the disc of its height, of overlapping solids of one structure their union.
TEST(Section, CutOfABall)
{
  for (const double at_mm : {0.3, -11.0, 25.0}) {
    for (const Eigen::Vector3d& normal :
         {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(1.0 / 3, 2.0 / 3, -2.0 / 3)}) {
      SCOPED_TRACE(at_mm);
      Stage stage(knee());
      // A copy of the ball, which is inside it.
      Drawable inner = stage.of(femur);
      for (RenderVertex& vertex : inner.mesh.vertices)
        for (float& x : vertex.position_mm) x *= 0.5F;
      Scene scene;
      scene.drawables = {stage.of(femur), inner};
      SectionCaps caps(scene);
      scene.section = SectionPlane{normal, at_mm};
      caps.update(scene);
      const double disc_mm2 = std::max(0.0, pi * (400.0 - at_mm * at_mm));
      // A polyhedron of 16 x 32 faces is smaller by up to 3 %.
      EXPECT_LE(area_mm2(scene.drawables[2]), 1.001 * disc_mm2);
      EXPECT_GE(area_mm2(scene.drawables[2]), 0.97 * disc_mm2);
      scene.section.reset();
      caps.update(scene);
      EXPECT_FALSE(scene.drawables[2].is_shown);
    }
  }
}

// Every anchor is on what it names and nothing is in front of it; medial and lateral are on their sides.
TEST(Labels, InFrontOfBone)
{
  for (const std::string side : {"right", "left"}) {
    Stage stage(knee(side));
    LabelAnchors anchors(stage.model, stage.scene);
    std::vector<ScreenLabel> labels(anchors.texts().size());
    int n_hidden = 0;
    for (const View view : {View::front, View::back, View::medial, View::lateral, View::top}) {
      for (const bool is_cut : {false, true}) {
        SCOPED_TRACE(side + " " + view_names()[static_cast<std::size_t>(view)]);
        const Camera camera = stage.camera(view);
        stage.scene.section.reset();
        if (is_cut) stage.scene.section = SectionPlane{camera.X_world_camera.linear().col(2), 5.0};
        stage.place();
        anchors.place(labels, stage.scene, {camera, square});
        Eigen::Vector2d medial_px(0, 0), lateral_px(0, 0);
        for (std::size_t k = 0; k < labels.size(); ++k) {
          const std::string& text = anchors.texts()[k];
          n_hidden += labels[k].is_shown ? 0 : 1;
          if (text == "medial") medial_px = labels[k].anchor_px;
          if (text == "lateral") lateral_px = labels[k].anchor_px;
          const Eigen::Vector3d eye_mm = camera.X_world_camera.translation(),
                                p_mm = labels[k].anchor_world_mm;
          for (Drawable& drawable : stage.scene.drawables)  // bone and meniscus only
            if (drawable.layer != Layer::bodies) drawable.is_shown = false;
          const auto seen = picked(stage.scene, camera, square, labels[k].anchor_px, 0.0);
          const double nearest_mm = seen ? (seen->point_world_mm - eye_mm).norm() : 1e9;
          EXPECT_TRUE(!labels[k].is_shown || (p_mm - eye_mm).norm() < nearest_mm + 1.5) << text;
          const double towards_mm = camera.X_world_camera.linear().col(2).dot(p_mm);
          EXPECT_FALSE(is_cut && labels[k].is_shown && towards_mm > 5.001) << text << " is cut away";
          const bool is_in_ball = p_mm.norm() < 18.5;  // of 20 mm, behind its filled cut
          EXPECT_FALSE(is_cut && labels[k].is_shown && is_in_ball && text != "femur") << text;
        }
        EXPECT_TRUE((view != View::front && view != View::back) || is_cut ||
                    (medial_px.x() < lateral_px.x()) == ((view == View::front) == (side == "left")))
            << medial_px.transpose() << ", " << lateral_px.transpose();
      }
    }
    EXPECT_GT(n_hidden, 0) << "from the medial side the lateral one is hidden";
  }
}

}  // namespace vrda::view::structures_test
