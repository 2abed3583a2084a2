#include "view/player_state.hpp"

#include <gtest/gtest.h>

#include "support/models.hpp"
#include "support/refusal.hpp"
#include "support/scratch.hpp"
#include "view/image.hpp"

namespace vrda::look_test {

view::Scene some_scene()
{
  store::MotionModel model = test::model_of({});
  test::add_bodies(model);
  return view::scene_of(model.reference, model.moving, model.rotation_centre_mm);
}

TEST(Look, LayersAreNamed)
{
  EXPECT_EQ(view::parsed_layers(""), view::LayerSet{});
  const view::LayerSet layers = view::parsed_layers("gaps,helical-axis");
  EXPECT_TRUE(layers.has(view::Layer::gap_map));
  EXPECT_TRUE(layers.has(view::Layer::helical_axis));
  EXPECT_FALSE(layers.has(view::Layer::contacts));
  for (const std::string text : {"gap", "gaps,", "gaps,gaps", "bodies"}) {
    SCOPED_TRACE(text);
    EXPECT_THAT(test::input_error([&] { view::parsed_layers(text); }),
                test::refuses({"--layers", "", text == "gaps,gaps" ? "twice" : "\""}));
  }
}

TEST(Look, ByDefaultNothingChanges)
{
  view::Scene scene = some_scene();
  const view::Lighting before = scene.lighting;
  view::apply_appearance(scene, {});
  EXPECT_EQ(scene.mode, view::DrawMode::textured);
  EXPECT_TRUE(scene.texture.is_empty());
  EXPECT_EQ(scene.lighting.sky, before.sky);
  EXPECT_EQ(scene.drawables.front().material.opacity, 1.0F);
}

TEST(Look, ModeTextureLightsAndTransparencyAreTakenOver)
{
  const test::Scratch scratch;
  view::AppearanceOptions look;
  look.mode = view::DrawMode::hidden_line;
  look.texture = (scratch.path() / "bone.png").string();
  look.texture_scale_mm = 25.0;
  view::write_png({2, 1, {1, 2, 3, 255, 4, 5, 6, 255}}, look.texture);
  look.lights = scratch
                    .write("lights.toml",
                           "[hemisphere]\nsky = [0.5, 0.5, 0.5]\nground = [0, 0, 0]\n"
                           "[background]\ntop = [0, 0, 1]\nbottom = [1, 0, 0]\n")
                    .string();
  look.see_through = "reference";
  view::Scene scene = some_scene();
  view::add_layer(scene, view::Layer::ligaments, view::ParentFrame::reference, "a layer of the reference");
  view::apply_appearance(scene, look);
  EXPECT_EQ(scene.mode, view::DrawMode::hidden_line);
  EXPECT_EQ(scene.texture.width, 2);
  EXPECT_EQ(scene.texture.scale_mm, 25.0);
  EXPECT_EQ(scene.lighting.sky, Eigen::Vector3f(0.5F, 0.5F, 0.5F));
  EXPECT_TRUE(scene.lighting.lights.empty());
  EXPECT_EQ(scene.background.top, Eigen::Vector3f(0, 0, 1));
  for (const view::Drawable& drawable : scene.drawables) {
    const float own = material_of(drawable.name == "plate" ? "meniscus" : "bone").opacity;
    const bool is_body =
        drawable.parent == view::ParentFrame::reference && drawable.layer == view::Layer::bodies;
    EXPECT_EQ(drawable.material.opacity < own, is_body) << drawable.name;
  }
}

TEST(Look, AHiddenObjectLeavesTheJointWhereItIs)
{
  view::Scene scene = some_scene();
  const view::Sphere before = view::joint_sphere(scene);
  const std::size_t n_points = view::points_within(scene, {}).size();
  view::AppearanceOptions look;
  look.hidden = "reference";
  view::apply_appearance(scene, look);
  for (const view::Drawable& drawable : scene.drawables)
    EXPECT_EQ(drawable.is_shown, drawable.parent == view::ParentFrame::moving) << drawable.name;
  EXPECT_EQ(view::joint_sphere(scene).radius_mm, before.radius_mm);
  EXPECT_LT(view::points_within(scene, {}).size(), n_points);
  EXPECT_GT(view::points_within(scene, {}).size(), 0U);
}

TEST(Look, AnObjectHasItsOwnName)
{
  // Of an ankle the tibia is the reference, of a hip the femur is the moving object.
  struct Row {
    const char *reference, *moving, *hidden;
    view::ParentFrame parent;
  };
  for (const Row& row : {Row{"tibia", "talus", "tibia", view::ParentFrame::reference},
                         Row{"tibia", "talus", "talus", view::ParentFrame::moving},
                         Row{"pelvis", "femur", "femur", view::ParentFrame::moving},
                         Row{"pelvis", "femur", "reference", view::ParentFrame::reference},
                         Row{"femur", "tibia", "tibia", view::ParentFrame::moving}}) {
    SCOPED_TRACE(row.hidden);
    view::Scene scene = some_scene();
    scene.reference_name = row.reference;
    scene.moving_name = row.moving;
    view::AppearanceOptions look;
    look.hidden = row.hidden;
    view::apply_appearance(scene, look);
    for (const view::Drawable& drawable : scene.drawables)
      EXPECT_EQ(drawable.is_shown, drawable.parent != row.parent) << drawable.name;
  }
  view::Scene ankle = some_scene();
  ankle.reference_name = "tibia";
  ankle.moving_name = "talus";
  view::AppearanceOptions look;
  look.see_through = "femur";
  EXPECT_THAT(test::input_error([&] { view::apply_appearance(ankle, look); }),
              test::refuses({.file = "--see-through", .found = "femur", .wanted = "tibia or talus"}));
}

TEST(Look, WhatIsWrongIsNamed)
{
  view::Scene scene = some_scene();
  view::AppearanceOptions look;
  look.see_through = "patella";
  EXPECT_EQ(test::input_error([&] { view::apply_appearance(scene, look); }).file, "--see-through");
  look = {};
  look.hidden = "both";
  EXPECT_EQ(test::input_error([&] { view::apply_appearance(scene, look); }).file, "--hide");
  look = {};
  look.texture = "none.png";
  EXPECT_EQ(test::input_error([&] { view::apply_appearance(scene, look); }).file, "none.png");
  look.texture_scale_mm = 0.0;
  EXPECT_EQ(test::input_error([&] { view::apply_appearance(scene, look); }).file, "--texture-scale");
  look = {};
  look.lights = "none.toml";
  EXPECT_EQ(test::input_error([&] { view::apply_appearance(scene, look); }).file, "none.toml");
}

}  // namespace vrda::look_test
