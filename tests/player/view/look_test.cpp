#include "view/look.hpp"

#include <gtest/gtest.h>

#include "motion/support/models.hpp"
#include "render/image.hpp"
#include "support/input_error.hpp"
#include "support/scratch.hpp"

namespace vrda::look_test {

Scene some_scene()
{
  MotionModel model = test::model_of({});
  test::add_bodies(model);
  return scene_of(model.reference, model.moving, model.rotation_centre_mm);
}

TEST(Look, LayersAreNamed)
{
  EXPECT_EQ(parsed_layers(""), LayerSet{});
  const LayerSet layers = parsed_layers("gaps,helical-axis");
  EXPECT_TRUE(layers.has(Layer::gap_map));
  EXPECT_TRUE(layers.has(Layer::helical_axis));
  EXPECT_FALSE(layers.has(Layer::contacts));
  for (const std::string text : {"gap", "gaps,", "gaps,gaps", "bodies"}) {
    SCOPED_TRACE(text);
    const InputError::Facts facts = test::input_error([&] { parsed_layers(text); });
    EXPECT_EQ(facts.file, "--layers");
    EXPECT_NE(facts.found.find(text == "gaps,gaps" ? "twice" : "\""), std::string::npos);
  }
}

TEST(Look, ByDefaultNothingChanges)
{
  Scene scene = some_scene();
  const Lighting before = scene.lighting;
  dress(scene, {});
  EXPECT_EQ(scene.mode, DrawMode::textured);
  EXPECT_TRUE(scene.texture.is_empty());
  EXPECT_EQ(scene.lighting.sky, before.sky);
  EXPECT_EQ(scene.drawables.front().material.opacity, 1.0F);
}

TEST(Look, ModeTextureLightsAndTransparencyAreTakenOver)
{
  const test::Scratch scratch;
  LookOptions look;
  look.mode = DrawMode::hidden_line;
  look.texture = (scratch.path() / "bone.png").string();
  look.texture_scale_mm = 25.0;
  write_png({2, 1, {1, 2, 3, 255, 4, 5, 6, 255}}, look.texture);
  look.lights = scratch
                    .write("lights.toml",
                           "[hemisphere]\nsky = [0.5, 0.5, 0.5]\nground = [0, 0, 0]\n"
                           "[background]\ntop = [0, 0, 1]\nbottom = [1, 0, 0]\n")
                    .string();
  look.see_through = "reference";
  Scene scene = some_scene();
  dress(scene, look);
  EXPECT_EQ(scene.mode, DrawMode::hidden_line);
  EXPECT_EQ(scene.texture.width, 2);
  EXPECT_EQ(scene.texture.scale_mm, 25.0);
  EXPECT_EQ(scene.lighting.sky, Eigen::Vector3f(0.5F, 0.5F, 0.5F));
  EXPECT_TRUE(scene.lighting.lights.empty());
  EXPECT_EQ(scene.background.top, Eigen::Vector3f(0, 0, 1));
  for (const Drawable& drawable : scene.drawables) {
    const float own = material_of(drawable.name == "plate" ? "meniscus" : "bone").opacity;
    EXPECT_EQ(drawable.material.opacity < own, drawable.owner == Owner::reference) << drawable.name;
  }
}

TEST(Look, AHiddenObjectLeavesTheJointWhereItIs)
{
  Scene scene = some_scene();
  const Sphere before = joint_sphere(scene);
  const std::size_t n_points = points_within(scene, {}).size();
  LookOptions look;
  look.hidden = "reference";
  dress(scene, look);
  for (const Drawable& drawable : scene.drawables)
    EXPECT_EQ(drawable.is_shown, drawable.owner == Owner::moving) << drawable.name;
  EXPECT_EQ(joint_sphere(scene).radius_mm, before.radius_mm);
  EXPECT_LT(points_within(scene, {}).size(), n_points);
  EXPECT_GT(points_within(scene, {}).size(), 0U);
}

TEST(Look, WhatIsWrongIsNamed)
{
  Scene scene = some_scene();
  LookOptions look;
  look.see_through = "femur";
  EXPECT_EQ(test::input_error([&] { dress(scene, look); }).file, "--see-through");
  look = {};
  look.hidden = "both";
  EXPECT_EQ(test::input_error([&] { dress(scene, look); }).file, "--hide");
  look = {};
  look.texture = "none.png";
  EXPECT_EQ(test::input_error([&] { dress(scene, look); }).file, "none.png");
  look.texture_scale_mm = 0.0;
  EXPECT_EQ(test::input_error([&] { dress(scene, look); }).file, "--texture-scale");
  look = {};
  look.lights = "none.toml";
  EXPECT_EQ(test::input_error([&] { dress(scene, look); }).file, "none.toml");
}

}  // namespace vrda::look_test
