// Structures, their picks, cuts and names in the picture.
#include "view/structures.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

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

// An open sheet has a line, and a bone with one defective triangle is a solid.
TEST(Section, CutOfASheet)
{
  Stage stage(knee());
  Scene scene;
  scene.drawables = {stage.of(femur), stage.of(femur)};
  RenderMesh& sheet = scene.drawables[0].mesh;
  sheet.vertices.resize(4);
  for (std::size_t k = 0; k < 4; ++k)
    sheet.vertices[k].position_mm = {k % 2 == 0 ? -20.0F : 20.0F, k < 2 ? -20.0F : 20.0F, 3.0F};
  sheet.triangles = {0, 1, 2, 2, 1, 3};
  const Mesh fine = test::ball(20, 40, 80);
  std::vector<Eigen::Index> triangles(static_cast<std::size_t>(fine.triangles.rows() - 1));
  std::iota(triangles.begin(), triangles.end(), 0);
  scene.drawables[1].mesh = make_render_mesh(fine, triangles, Eigen::Vector3d::Zero());
  scene.drawables[1].structure = plate;
  SectionCaps caps(scene);
  scene.section = SectionPlane{Eigen::Vector3d::UnitX(), 5.0};
  caps.update(scene);
  // 40 mm in two triangles, each with two square ends.
  constexpr double width_mm = SectionCaps::line_mm;
  EXPECT_NEAR(area_mm2(scene.drawables[2]), (40.0 + 2.0 * width_mm) * width_mm, SectionCaps::row_mm);
  for (const RenderVertex& vertex : scene.drawables[2].mesh.vertices) {
    EXPECT_NEAR(vertex.position_mm[0], 5.0, 1e-4);
    EXPECT_LE(std::abs(vertex.position_mm[1]), 20.0 + 0.5 * width_mm + SectionCaps::row_mm);
    EXPECT_NEAR(std::abs(vertex.position_mm[2] - 3.0F), 0.5 * width_mm, SectionCaps::row_mm);
  }
  EXPECT_NEAR(area_mm2(scene.drawables[3]) / (pi * 375.0), 1.0, 0.01);
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

/// Makes the mesh a square across the camera's line of sight; `is_back`: its inner side is seen.
void make_square(Drawable& drawable, const Camera& camera, const Eigen::Vector3d& middle_mm, double half_mm,
                 bool is_back)
{
  drawable.mesh.vertices.resize(4);
  for (std::size_t k = 0; k < 4; ++k) {
    const Eigen::Vector3d across(k % 2 == 0 ? -half_mm : half_mm, k < 2 ? -half_mm : half_mm, 0.0);
    const Eigen::Vector3d corner_mm = middle_mm + camera.X_world_camera.linear() * across;
    const Eigen::Vector3f p = (drawable.X_world_mesh.inverse() * corner_mm).cast<float>();
    drawable.mesh.vertices[k].position_mm = {p.x(), p.y(), p.z()};
  }
  drawable.mesh.triangles = {0, 1, 2, 2, 1, 3};
  if (is_back) drawable.mesh.triangles = {0, 2, 1, 2, 3, 1};
  update_box(drawable);
}

// Either side of an open sheet hides what is behind it.
TEST(Labels, BehindASheet)
{
  for (const bool is_back : {false, true}) {
    Stage stage(knee());
    const Camera camera = stage.camera(View::medial);
    make_square(stage.of(plate), camera, 30.0 * camera.X_world_camera.linear().col(2), 200.0, is_back);
    LabelAnchors anchors(stage.model, stage.scene);
    std::vector<ScreenLabel> labels(anchors.texts().size());
    anchors.place(labels, stage.scene, {camera, square});
    for (std::size_t k = 0; k < labels.size(); ++k)
      EXPECT_FALSE(labels[k].is_shown && anchors.texts()[k] == "femur") << is_back;
  }
}

// On a filled cut there is the name of its bone, and none of a side that is behind it.
TEST(Labels, SideBehindACut)
{
  Stage stage(knee());
  Camera camera = stage.camera(View::medial);
  const Drawable& bone = stage.of("bodies/moving/block");
  camera.X_world_camera.translation().y() = (bone.X_world_mesh * bone.box_mm.center()).y();
  LabelAnchors anchors(stage.model, stage.scene);
  std::vector<ScreenLabel> labels(anchors.texts().size());
  const auto is_shown = [&](const char* text) {
    anchors.place(labels, stage.scene, {camera, square});
    const auto found = std::ranges::find(anchors.texts(), text);
    return labels.at(static_cast<std::size_t>(found - anchors.texts().begin())).is_shown;
  };
  EXPECT_TRUE(is_shown("medial"));
  stage.scene.section = SectionPlane{Eigen::Vector3d::UnitZ(), 0.0};
  stage.place();
  EXPECT_TRUE(is_shown("tibia"));
  EXPECT_FALSE(is_shown("lateral"));
}

// A band over the anchor of a bone moves it, one over the whole bone leaves no name.
TEST(Labels, BehindFibres)
{
  Stage stage(knee());
  LabelAnchors anchors(stage.model, stage.scene);
  std::vector<ScreenLabel> labels(anchors.texts().size());
  const Camera camera = stage.camera(View::medial);
  const auto label = [&](const char* text) {
    anchors.place(labels, stage.scene, {camera, square});
    return labels.at(
        static_cast<std::size_t>(std::ranges::find(anchors.texts(), text) - anchors.texts().begin()));
  };
  const ScreenLabel first = label("femur");
  ASSERT_TRUE(first.is_shown);
  Drawable& band = stage.of("ligaments/MCLs");
  const Eigen::Vector3d above_mm = first.anchor_world_mm + 2.0 * camera.X_world_camera.linear().col(2);
  for (const double half_mm : {1.0, 200.0}) {
    SCOPED_TRACE(half_mm);
    make_square(band, camera, above_mm, half_mm, false);
    const ScreenLabel found = label("femur");
    EXPECT_EQ(found.is_shown, half_mm < 100.0);
    EXPECT_TRUE(!found.is_shown || found.anchor_world_mm != first.anchor_world_mm);
    EXPECT_TRUE(label("MCL").is_shown) << "its own band";
    band.is_shown = false;
    EXPECT_EQ(label("femur").anchor_world_mm, first.anchor_world_mm);
    band.is_shown = true;
  }
}

}  // namespace vrda::view::structures_test
