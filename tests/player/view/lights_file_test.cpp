#include "view/scene.hpp"

#include <gmock/gmock.h>

#include "support/refusal.hpp"
#include "support/scratch.hpp"

namespace vrda::view::lights_file_test {

const std::string hemisphere = "[hemisphere]\nsky = [0.2, 0.2, 0.2]\nground = [0.1, 0.1, 0.1]\n";

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
    EXPECT_THAT(test::input_error([&] { parsed_lights(row.text, "my.toml"); }),
                test::refuses({"my.toml", row.field, row.found}));
  }
  EXPECT_THAT(test::input_error([&] { parsed_lights(hemisphere + "grund = []", "a"); }),
              test::refuses({.field = "line 4, hemisphere.grund", .wanted = "\"hemisphere.ground\""}));
  EXPECT_THAT(test::input_error([] { parsed_lights("[hemisphere\n", "a"); }),
              test::refuses({.field = "line 1, column 12", .wanted = "TOML"}));
}

}  // namespace vrda::view::lights_file_test
