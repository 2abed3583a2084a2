#include "view/player_state.hpp"

#include <gtest/gtest.h>

#include "support/models.hpp"
#include "support/refusal.hpp"
#include "support/scratch.hpp"
#include "view/image.hpp"

namespace vrda::view::look_test {

Scene some_scene()
{
  store::MotionModel model = test::model_of({});
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
    EXPECT_THAT(test::input_error([&] { parsed_layers(text); }),
                test::refuses({"--layers", "", text == "gaps,gaps" ? "twice" : "\""}));
  }
}

// Mode texture lights and transparency are taken over.
TEST(Look, OptionsApply)
{
  const test::Scratch scratch;
  AppearanceOptions look;
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
  add_layer(scene, Layer::ligaments, BodyIndex::reference, "a layer of the reference");
  apply_appearance(scene, look);
  EXPECT_EQ(scene.mode, DrawMode::hidden_line);
  EXPECT_EQ(scene.texture.width, 2);
  EXPECT_EQ(scene.texture.scale_mm, 25.0);
  EXPECT_EQ(scene.lighting.sky, Eigen::Vector3f(0.5F, 0.5F, 0.5F));
  EXPECT_TRUE(scene.lighting.lights.empty());
  EXPECT_EQ(scene.background.top, Eigen::Vector3f(0, 0, 1));
  for (const Drawable& drawable : scene.drawables) {
    const float own = material_of(drawable.name == "plate" ? "meniscus" : "bone").opacity;
    const bool is_body = drawable.parent == BodyIndex::reference && drawable.layer == Layer::bodies;
    EXPECT_EQ(drawable.material.opacity < own, is_body) << drawable.name;
  }
}

TEST(Look, HiddenObject)
{
  Scene scene = some_scene();
  const Sphere before = joint_sphere(scene);
  const std::size_t n_points = points_within(scene, {}).size();
  AppearanceOptions look;
  look.hidden = "reference";
  apply_appearance(scene, look);
  for (const Drawable& drawable : scene.drawables)
    EXPECT_EQ(drawable.is_shown, drawable.parent == BodyIndex::moving) << drawable.name;
  EXPECT_EQ(joint_sphere(scene).radius_mm, before.radius_mm);
  EXPECT_LT(points_within(scene, {}).size(), n_points);
  EXPECT_GT(points_within(scene, {}).size(), 0U);
}

TEST(Look, AnObjectHasItsOwnName)
{
  // Of an ankle the tibia is the reference, of a hip the femur is the moving object.
  struct Row {
    const char *reference, *moving, *hidden;
    BodyIndex parent;
  };
  for (const Row& row :
       {Row{"tibia", "talus", "tibia", BodyIndex::reference},
        Row{"tibia", "talus", "talus", BodyIndex::moving}, Row{"pelvis", "femur", "femur", BodyIndex::moving},
        Row{"pelvis", "femur", "reference", BodyIndex::reference},
        Row{"femur", "tibia", "tibia", BodyIndex::moving}}) {
    SCOPED_TRACE(row.hidden);
    Scene scene = some_scene();
    scene.reference_name = row.reference;
    scene.moving_name = row.moving;
    AppearanceOptions look;
    look.hidden = row.hidden;
    apply_appearance(scene, look);
    for (const Drawable& drawable : scene.drawables)
      EXPECT_EQ(drawable.is_shown, drawable.parent != row.parent) << drawable.name;
  }
  Scene ankle = some_scene();
  ankle.reference_name = "tibia";
  ankle.moving_name = "talus";
  AppearanceOptions look;
  look.see_through = "femur";
  EXPECT_THAT(test::input_error([&] { apply_appearance(ankle, look); }),
              test::refuses({.file = "--see-through", .found = "femur", .wanted = "tibia or talus"}));
}

}  // namespace vrda::view::look_test
