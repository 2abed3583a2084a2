#include "view/scene.hpp"

#include <gmock/gmock.h>

#include "support/refusal.hpp"
#include "support/scratch.hpp"

namespace vrda::lights_file_test {

const std::string hemisphere = "[hemisphere]\nsky = [0.2, 0.2, 0.2]\nground = [0.1, 0.1, 0.1]\n";

TEST(LightsFile, TheExampleIsTheStudio)
{
  const view::Lights lights = view::read_lights(VRDA_JOBS "/lights-studio.toml");
  const view::Lighting studio = view::studio_lighting();
  EXPECT_EQ(lights.lighting.sky, studio.sky);
  EXPECT_EQ(lights.lighting.ground, studio.ground);
  ASSERT_EQ(lights.lighting.lights.size(), studio.lights.size());
  for (std::size_t i = 0; i < studio.lights.size(); ++i) {
    EXPECT_EQ(lights.lighting.lights[i].towards_camera, studio.lights[i].towards_camera);
    EXPECT_EQ(lights.lighting.lights[i].colour, studio.lights[i].colour);
  }
  ASSERT_TRUE(lights.background.has_value());
  EXPECT_EQ(lights.background->top, view::background_of(view::Backdrop::studio).top);
  EXPECT_EQ(lights.background->bottom, view::background_of(view::Backdrop::studio).bottom);
}

TEST(LightsFile, LightsAndBackgroundMayBeLeftOut)
{
  const view::Lights lights = view::parsed_lights(hemisphere, "dim.toml");
  EXPECT_TRUE(lights.lighting.lights.empty());
  EXPECT_FALSE(lights.background.has_value());
  EXPECT_EQ(lights.lighting.sky, Eigen::Vector3f(0.2F, 0.2F, 0.2F));
}

TEST(LightsFile, WhatIsWrongIsNamed)
{
  const std::string light = "[[light]]\ntowards = [0, 0, 1]\ncolour = [1, 1, 1]\n";
  const auto sky = [](const std::string& value) {
    return "[hemisphere]\nsky = " + value + "\nground = [0, 0, 0]\n";
  };
  struct Row {
    std::string text, field, found;
  };
  for (const Row& row : {
           Row{"", "hemisphere", "nothing"},
           Row{"hemisphere = 3", "hemisphere", "3"},
           Row{"[hemisphere]\nsky = [1, 1, 1]\n", "hemisphere.ground", "nothing"},
           Row{sky("[1, 1]"), "hemisphere.sky", "[1, 1]"},
           Row{sky("[1, 1, 11]"), "hemisphere.sky.2", "11"},
           Row{sky("[1, 1, \"x\"]"), "hemisphere.sky.2", "\"x\""},
           Row{hemisphere + "grund = [0, 0, 0]\n", "hemisphere.grund", "an unknown key"},
           Row{"light = 1\n" + hemisphere, "light", "1"},
           Row{hemisphere + light + "bright = 2\n", "light.0.bright", "an unknown key"},
           Row{hemisphere + light + "[[light]]\ntowards = [0, 0, 0]\ncolour = [1, 1, 1]\n", "light.1.towards",
               "no direction"},
           Row{hemisphere + light + light + light + light + light, "light", ""},
           Row{hemisphere + "[background]\ntop = [0, 0, 2]\nbottom = [0, 0, 0]\n", "background.top.2", "2"},
       }) {
    SCOPED_TRACE(row.text);
    EXPECT_THAT(test::input_error([&] { view::parsed_lights(row.text, "my.toml"); }),
                test::refuses({"my.toml", row.field, row.found}));
  }
  EXPECT_THAT(test::input_error([&] { view::parsed_lights(hemisphere + "grund = []", "a"); }),
              test::refuses({.field = "line 4, hemisphere.grund", .wanted = "\"hemisphere.ground\""}));
  EXPECT_THAT(test::input_error([] { view::parsed_lights("[hemisphere\n", "a"); }),
              test::refuses({.field = "line 1, column 12", .wanted = "TOML"}));
}

TEST(LightsFile, AFileThatIsNotThereOrEndlessIsRefused)
{
  const test::Scratch scratch;
  const std::string missing = (scratch.path() / "none.toml").string();
  EXPECT_EQ(test::input_error([&] { view::read_lights(missing); }).file, missing);
  const std::string huge = scratch.write("huge.toml", std::string(8000001, '\n')).string();
  EXPECT_THAT(test::input_error([&] { view::read_lights(huge); }), test::refuses({.found = "8000000"}));
}

}  // namespace vrda::lights_file_test
