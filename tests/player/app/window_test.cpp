// The program in a window on a virtual screen, driven by simulated keys and mouse.
#include <array>
#include <chrono>
#include <functional>
#include <nlohmann/json.hpp>
#include <thread>

#include "bench/calibration_file.hpp"
#include "player/app/player_programs.hpp"
#include "player/view/screen.hpp"

namespace vrda::window_test {

using test::comes_true;

constexpr int width = 800, height = 600;

class InWindow : public test::PlayerPrograms {
 protected:
  test::Command show() const { return command({"show", model_, "--size", "800x600"}); }
  static void type(const std::string& keys)
  {
    EXPECT_EQ(test::run({"/usr/bin/xdotool", {"key", keys}, {}, {}}).exit_code, 0);
  }
  static void mouse(const std::vector<std::string>& arguments)
  {
    EXPECT_EQ(test::run({"/usr/bin/xdotool", arguments, {}, {}}).exit_code, 0);
  }
  /// Tests the dark panel's pixel in the lower right corner.
  bool is_panel_there() const
  {
    const view::Image image = screen_.picture(width, height);
    return image.rgba[image.rgba.size() - 4] == 26;
  }
  /// Waits until the screen differs from `before`.
  bool changes_from(const view::Image& before) const
  {
    return comes_true([&] { return screen_.picture(width, height).rgba != before.rgba; });
  }
  /// The panel is dark over less than half of the window, with the help page over more than half. The joint
  /// itself cannot tell: it is drawn coarser while it moves.
  bool is_page_over() const
  {
    const view::Image now = screen_.picture(width, height);
    std::size_t n_dark = 0;
    for (std::size_t i = 0; i < now.rgba.size(); i += 4)
      n_dark += static_cast<std::size_t>(now.rgba[i] == 26);
    return n_dark > static_cast<std::size_t>(width) * height / 2;
  }

  test::Screen screen_;
};

TEST_F(InWindow, OpensPlaysTakesAPictureAndQuits)
{
  test::Process program(show());
  ASSERT_TRUE(comes_true([&] { return is_panel_there(); })) << program.said();
  mouse({"mousemove", "300", "300"});
  view::Image before = screen_.picture(width, height);
  type("Right");
  EXPECT_TRUE(changes_from(before));
  before = screen_.picture(width, height);
  type("space");
  EXPECT_TRUE(changes_from(before));
  type("space");
  type("p");
  const std::function<bool()> has_picture = [&] {
    for (const auto& entry : std::filesystem::directory_iterator(scratch_.path())) {
      if (entry.path().extension() == ".png") return true;
    }
    return false;
  };
  EXPECT_TRUE(comes_true(has_picture));
  type("q");
  const test::Ended ended = program.wait();
  EXPECT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_EQ(ended.err, "");
}

// Desktops give the monitor's scale as a resource; controls and texts follow it.
TEST_F(InWindow, ControlsHaveTheMonitorsScale)
{
  constexpr int wide = 1280, tall = 1024;
  const auto panel_height_px = [&] {  // of the slider's, lower left
    const view::Image image = screen_.picture(wide, tall);
    int n = 0;
    while (n < tall && image.rgba[4 * static_cast<std::size_t>((tall - 1 - n) * wide)] == 26) ++n;
    return n;
  };
  std::array<int, 2> heights_px{};
  for (int& height_px : heights_px) {
    test::Process program(command({"show", model_, "--size", "1280x1024"}));
    ASSERT_TRUE(comes_true([&] { return (height_px = panel_height_px()) > 0; })) << program.said();
    mouse({"mousemove", "300", "300"});  // a key goes to the window below the pointer
    type("q");
    EXPECT_EQ(program.wait().exit_code, 0);
    const std::vector<std::string> twice{
        "-root", "-f", "RESOURCE_MANAGER", "8s", "-set", "RESOURCE_MANAGER", "Xft.dpi: 192"};
    EXPECT_EQ(test::run({"/usr/bin/xprop", twice, {}, {}}).exit_code, 0);
  }
  EXPECT_GT(heights_px[1], heights_px[0] * 9 / 5);
}

TEST_F(InWindow, TheMouseTurnsTheJointAndPressesButtons)
{
  test::Process program(show());
  ASSERT_TRUE(comes_true([&] { return is_panel_there(); })) << program.said();
  const view::Image before = screen_.picture(width, height);
  mouse({"mousemove", "300", "300", "mousedown", "2", "mousemove", "360", "330", "mouseup", "2"});
  EXPECT_TRUE(changes_from(before));
  type("t");
  EXPECT_TRUE(comes_true([&] { return !is_panel_there(); }));
  type("t");
  EXPECT_TRUE(comes_true([&] { return is_panel_there(); }));
  // "help", the last button of the panel, opens the page; Escape closes it, not the window.
  mouse({"mousemove", "740", "560", "click", "1"});
  ASSERT_TRUE(comes_true([&] { return is_page_over(); }));
  type("Escape");
  EXPECT_TRUE(comes_true([&] { return !is_page_over(); }));
  type("Escape");
  type("h");  // the window takes keys: it is still there
  ASSERT_TRUE(comes_true([&] { return is_page_over(); }));
  type("q");
  EXPECT_EQ(program.wait().exit_code, 0);
}

/// In the layout "quarters" the left half is the operator's area, with a dark background.
bool is_operators_area_at(const view::Image& image, int x, int y)
{
  constexpr int red = 24;
  return image.rgba[static_cast<std::size_t>(4 * (y * width + x))] == red;
}

bool is_operators_area_there(const view::Image& image)
{
  return is_operators_area_at(image, 10, height - 1);
}

constexpr int place_x = 220, place_y = 130;

/// A bench file without a reachable tracker, with a display of 640 x 512 at a given position.
std::string placed_bench_text()
{
  return test::bench_text(
      {.leg = "rigid",
       .display = "at = [" + std::to_string(place_x) + ", " + std::to_string(place_y) + "]\n",
       .width = 640,
       .height = 512,
       .tables = "[calibration]\n"});
}

/// Checks position and size of the window with that title.
bool is_at_its_place(const std::string& title)
{
  const std::string reported =
      test::run(
          {"/usr/bin/xdotool", {"search", "--onlyvisible", "--name", title, "getwindowgeometry"}, {}, {}})
          .out;
  const std::string place = "Position: " + std::to_string(place_x) + "," + std::to_string(place_y) + " ";
  return reported.find(place) != std::string::npos && reported.find("Geometry: 640x512") != std::string::npos;
}

TEST_F(InWindow, ABenchsDisplayIsAtItsPositionAndReportsDeviationsFromTheBenchFile)
{
  const std::string bench = scratch_.write("bench.toml", placed_bench_text()).string();
  const std::string kept = path("calibration.toml");
  struct Row {
    std::vector<std::string> arguments;
    std::string title;
  };
  for (const Row& row :
       {Row{{"bench", model_, "--bench", bench, "--quiet"}, "Test - vrda-player"},
        Row{{"calibrate", "viewport", "--bench", bench, "--calibration", kept}, "Test - calibrate"}}) {
    SCOPED_TRACE(row.title);
    test::Process program(command(row.arguments));
    ASSERT_TRUE(comes_true([&] { return is_at_its_place(row.title); })) << program.said();
    EXPECT_EQ(program.said().find("frame buffer"), std::string::npos);
    EXPECT_TRUE(comes_true(
        [&] { return is_operators_area_at(screen_.picture(width, height), place_x + 10, place_y + 300); }));
    // Keys go to the window under the pointer, in the middle of the screen.
    mouse({"search", "--name", row.title, "windowsize", "600", "500"});
    const std::string reported =
        bench + ": display.width, display.height: found a frame buffer of 600 x 500, wanted 640 x 512\n";
    EXPECT_TRUE(comes_true([&] { return program.said().find(reported) != std::string::npos; }))
        << program.said();
    type("q");
    EXPECT_NE(program.wait().exit_code, -1);
  }
}

TEST_F(InWindow, WhatKeysAdjustedIsWrittenToTheCalibrationOnRequest)
{
  const std::string bench = scratch_.write("bench.toml", placed_bench_text()).string();
  const std::string kept = path("anna.toml");
  test::Process program(
      {VRDA_PLAYER_PROGRAM, {"bench", model_, "--bench", bench, "--calibration", kept, "--quiet"}, {}, {}});
  ASSERT_TRUE(comes_true([&] { return is_at_its_place("Test - vrda-player"); })) << program.said();
  type("i");
  type("shift+Right");
  EXPECT_FALSE(std::filesystem::exists(kept));
  type("w");
  EXPECT_TRUE(comes_true([&] { return std::filesystem::exists(kept); })) << program.said();
  type("q");
  EXPECT_EQ(program.wait().exit_code, 0);
  const bench::BenchFile file = bench::read_bench_file(bench);
  bench::Calibration wanted = bench::nominal_calibration(file);
  constexpr double nominal_mm = 64.0, ten_steps_mm = 2.5;
  view::set_ipd(wanted.eyes, nominal_mm + ten_steps_mm);
  EXPECT_EQ(bench::read_calibration(kept, file).eyes, wanted.eyes);
}

TEST_F(InWindow, AnOperatorPractisesOnAVirtualBenchAndLeaves)
{
  const std::string kept = path("calibration.toml");
  test::Process program(
      {VRDA_PLAYER_PROGRAM, {"calibrate", "all", "--virtual", "--calibration", kept}, {}, scratch_.path()});
  ASSERT_TRUE(comes_true([&] { return is_operators_area_there(screen_.picture(width, height)); }))
      << program.said();
  view::Image before = screen_.picture(width, height);
  type("shift+Right");
  EXPECT_TRUE(changes_from(before));
  EXPECT_FALSE(std::filesystem::exists(kept));
  type("Return");
  EXPECT_TRUE(comes_true([&] { return std::filesystem::exists(kept); }));
  before = screen_.picture(width, height);
  type("h");
  EXPECT_TRUE(changes_from(before));
  const view::Image helped = screen_.picture(width, height);
  type("Escape");
  EXPECT_TRUE(changes_from(helped));
  type("q");
  const test::Ended ended = program.wait();
  EXPECT_EQ(ended.exit_code, 4) << ended.err;
  EXPECT_NE(ended.out.find("begun: 1 mark so far"), std::string::npos) << ended.out;
}

TEST_F(InWindow, DevicesListsTheMonitors)
{
  const std::string bench = scratch_.write("bench.toml", test::bench_text({.leg = "rigid"})).string();
  const auto monitors = [&] {
    const test::Ended ended = test::run(
        {VRDA_PLAYER_PROGRAM, {"devices", bench, "--json", "--seconds", "0.1"}, {}, scratch_.path()});
    return nlohmann::json::parse(ended.out).at("monitors");
  };
  const nlohmann::json one = monitors();
  ASSERT_EQ(one.size(), 1U);
  EXPECT_FALSE(one[0]["name"].get<std::string>().empty());
  EXPECT_EQ(one[0]["x"], 0);
  EXPECT_EQ(one[0]["y"], 0);
  EXPECT_EQ(one[0]["width"], 1280);
  EXPECT_EQ(one[0]["height"], 1024);
  unsetenv("DISPLAY");
  EXPECT_EQ(monitors(), nlohmann::json::array());
}

}  // namespace vrda::window_test
