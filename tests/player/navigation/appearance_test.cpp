#include "navigation/appearance.hpp"

#include <gtest/gtest.h>

#include "motion/support/models.hpp"
#include "render/image.hpp"
#include "support/refusal.hpp"
#include "support/scratch.hpp"

namespace vrda::look_test {

scene::Scene some_scene()
{
  store::MotionModel model = test::model_of({});
  test::add_bodies(model);
  return scene::scene_of(model.reference, model.moving, model.rotation_centre_mm);
}

TEST(Look, LayersAreNamed)
{
  EXPECT_EQ(navigation::parsed_layers(""), scene::LayerSet{});
  const scene::LayerSet layers = navigation::parsed_layers("gaps,helical-axis");
  EXPECT_TRUE(layers.has(scene::Layer::gap_map));
  EXPECT_TRUE(layers.has(scene::Layer::helical_axis));
  EXPECT_FALSE(layers.has(scene::Layer::contacts));
  for (const std::string text : {"gap", "gaps,", "gaps,gaps", "bodies"}) {
    SCOPED_TRACE(text);
    EXPECT_THAT(test::input_error([&] { navigation::parsed_layers(text); }),
                test::refuses({"--layers", "", text == "gaps,gaps" ? "twice" : "\""}));
  }
}

TEST(Look, ByDefaultNothingChanges)
{
  scene::Scene scene = some_scene();
  const scene::Lighting before = scene.lighting;
  navigation::apply_appearance(scene, {});
  EXPECT_EQ(scene.mode, scene::DrawMode::textured);
  EXPECT_TRUE(scene.texture.is_empty());
  EXPECT_EQ(scene.lighting.sky, before.sky);
  EXPECT_EQ(scene.drawables.front().material.opacity, 1.0F);
}

TEST(Look, ModeTextureLightsAndTransparencyAreTakenOver)
{
  const test::Scratch scratch;
  navigation::AppearanceOptions look;
  look.mode = scene::DrawMode::hidden_line;
  look.texture = (scratch.path() / "bone.png").string();
  look.texture_scale_mm = 25.0;
  render::write_png({2, 1, {1, 2, 3, 255, 4, 5, 6, 255}}, look.texture);
  look.lights = scratch
                    .write("lights.toml",
                           "[hemisphere]\nsky = [0.5, 0.5, 0.5]\nground = [0, 0, 0]\n"
                           "[background]\ntop = [0, 0, 1]\nbottom = [1, 0, 0]\n")
                    .string();
  look.see_through = "reference";
  scene::Scene scene = some_scene();
  scene::add_layer(scene, scene::Layer::ligaments, scene::ParentFrame::reference, "a layer of the reference");
  navigation::apply_appearance(scene, look);
  EXPECT_EQ(scene.mode, scene::DrawMode::hidden_line);
  EXPECT_EQ(scene.texture.width, 2);
  EXPECT_EQ(scene.texture.scale_mm, 25.0);
  EXPECT_EQ(scene.lighting.sky, Eigen::Vector3f(0.5F, 0.5F, 0.5F));
  EXPECT_TRUE(scene.lighting.lights.empty());
  EXPECT_EQ(scene.background.top, Eigen::Vector3f(0, 0, 1));
  for (const scene::Drawable& drawable : scene.drawables) {
    const float own = material_of(drawable.name == "plate" ? "meniscus" : "bone").opacity;
    const bool is_body =
        drawable.parent == scene::ParentFrame::reference && drawable.layer == scene::Layer::bodies;
    EXPECT_EQ(drawable.material.opacity < own, is_body) << drawable.name;
  }
}

TEST(Look, AHiddenObjectLeavesTheJointWhereItIs)
{
  scene::Scene scene = some_scene();
  const scene::Sphere before = scene::joint_sphere(scene);
  const std::size_t n_points = scene::points_within(scene, {}).size();
  navigation::AppearanceOptions look;
  look.hidden = "reference";
  navigation::apply_appearance(scene, look);
  for (const scene::Drawable& drawable : scene.drawables)
    EXPECT_EQ(drawable.is_shown, drawable.parent == scene::ParentFrame::moving) << drawable.name;
  EXPECT_EQ(scene::joint_sphere(scene).radius_mm, before.radius_mm);
  EXPECT_LT(scene::points_within(scene, {}).size(), n_points);
  EXPECT_GT(scene::points_within(scene, {}).size(), 0U);
}

TEST(Look, AnObjectHasItsOwnName)
{
  // Of an ankle the tibia is the reference, of a hip the femur is the moving object.
  struct Row {
    const char *reference, *moving, *hidden;
    scene::ParentFrame parent;
  };
  for (const Row& row : {Row{"tibia", "talus", "tibia", scene::ParentFrame::reference},
                         Row{"tibia", "talus", "talus", scene::ParentFrame::moving},
                         Row{"pelvis", "femur", "femur", scene::ParentFrame::moving},
                         Row{"pelvis", "femur", "reference", scene::ParentFrame::reference},
                         Row{"femur", "tibia", "tibia", scene::ParentFrame::moving}}) {
    SCOPED_TRACE(row.hidden);
    scene::Scene scene = some_scene();
    scene.reference_name = row.reference;
    scene.moving_name = row.moving;
    navigation::AppearanceOptions look;
    look.hidden = row.hidden;
    navigation::apply_appearance(scene, look);
    for (const scene::Drawable& drawable : scene.drawables)
      EXPECT_EQ(drawable.is_shown, drawable.parent != row.parent) << drawable.name;
  }
  scene::Scene ankle = some_scene();
  ankle.reference_name = "tibia";
  ankle.moving_name = "talus";
  navigation::AppearanceOptions look;
  look.see_through = "femur";
  EXPECT_THAT(test::input_error([&] { navigation::apply_appearance(ankle, look); }),
              test::refuses({.file = "--see-through", .found = "femur", .wanted = "tibia or talus"}));
}

TEST(Look, WhatIsWrongIsNamed)
{
  scene::Scene scene = some_scene();
  navigation::AppearanceOptions look;
  look.see_through = "patella";
  EXPECT_EQ(test::input_error([&] { navigation::apply_appearance(scene, look); }).file, "--see-through");
  look = {};
  look.hidden = "both";
  EXPECT_EQ(test::input_error([&] { navigation::apply_appearance(scene, look); }).file, "--hide");
  look = {};
  look.texture = "none.png";
  EXPECT_EQ(test::input_error([&] { navigation::apply_appearance(scene, look); }).file, "none.png");
  look.texture_scale_mm = 0.0;
  EXPECT_EQ(test::input_error([&] { navigation::apply_appearance(scene, look); }).file, "--texture-scale");
  look = {};
  look.lights = "none.toml";
  EXPECT_EQ(test::input_error([&] { navigation::apply_appearance(scene, look); }).file, "none.toml");
}

}  // namespace vrda::look_test
