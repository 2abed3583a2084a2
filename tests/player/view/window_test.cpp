#include "view/window.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <iterator>
#include <thread>

#include "core/text.hpp"
#include "player/view/pictures.hpp"
#include "player/view/screen.hpp"
#include "support/process.hpp"

namespace vrda::window_test {

constexpr int width = 640, height = 480;

view::WindowOptions quiet_window(int samples)
{
  view::WindowOptions options;
  options.width = width;
  options.height = height;
  options.title = "test";
  options.samples = samples;
  options.is_vsynced = false;
  return options;
}

/// Fraction of the pixels with a channel that differs by more than `code_tolerance`.
double differing_share(const view::Image& a, const view::Image& b)
{
  EXPECT_EQ(a.rgba.size(), b.rgba.size());
  int n_differing = 0;
  for (std::size_t i = 0; i < a.rgba.size(); i += 4) {
    int most = 0;
    for (std::size_t k = i; k < i + 4; ++k) most = std::max(most, std::abs(int{a.rgba[k]} - int{b.rgba[k]}));
    n_differing += most > test::code_tolerance ? 1 : 0;
  }
  return static_cast<double>(n_differing) / (a.width * a.height);
}

/// OpenGL defines the covered samples up to the rounding of vertices to (at least) 1/16 pixel, and colours up
/// to `code_tolerance`. A border pixel whose sample is within that rounding may differ: 1 in 16 of about
/// 4,000 border pixels of the joint, out of 307,200 pixels.
constexpr double agreed_share = 4000.0 / 16.0 / (width * height);

view::Image from_backend(view::Backend backend, const view::Scene& scene, int samples)
{
  const std::unique_ptr<view::Renderer> renderer =
      view::make_offscreen_renderer({width, height, samples}, backend);
  renderer->load(scene);
  return renderer->draw(scene, test::joint_camera(scene));
}

/// The screen's content, polled for up to a minute until it equals `expected`.
view::Image shown(const test::Screen& screen, const view::Image& expected)
{
  view::Image found;
  test::comes_true([&] {
    found = screen.picture(width, height);
    return differing_share(found, expected) <= agreed_share;
  });
  return found;
}

TEST(Backends, OsmesaEglAndAWindowAgree)
{
  const test::Screen screen;
  const view::Scene scene = test::joint_scene();
  const view::Shot shot{test::joint_camera(scene), {0, 0, width, height}};
  for (const int samples : {1, 4}) {
    SCOPED_TRACE(samples);
    const view::Image osmesa = from_backend(view::Backend::osmesa, scene, samples);
    EXPECT_LE(differing_share(osmesa, from_backend(view::Backend::egl, scene, samples)), agreed_share);
    view::Window window(quiet_window(samples));
    // The comparison can fail: the empty screen is a different image.
    EXPECT_GT(differing_share(osmesa, screen.picture(width, height)), 0.5);
    window.renderer().load(scene);
    window.events();
    window.show(scene, {&shot, 1}, nullptr);
    EXPECT_LE(differing_share(osmesa, shown(screen, osmesa)), agreed_share);
    EXPECT_LE(differing_share(osmesa, window.renderer().draw(scene, {&shot, 1}, nullptr)), agreed_share);
  }
}

TEST(Window, WhereTheProcessorDrawsASampleAPixelIsChosen)
{
  const test::Screen screen;
  const view::Scene scene = test::joint_scene();
  const view::Shot shot{test::joint_camera(scene), {0, 0, width, height}};
  const auto drawn = [&](int samples) {
    view::Window window(quiet_window(samples));
    window.renderer().load(scene);
    return window.renderer().draw(scene, {&shot, 1}, nullptr).rgba;
  };
  const std::vector<std::uint8_t> chosen = drawn(0);
  EXPECT_EQ(chosen, drawn(1));  // Xvfb has no graphics card
  EXPECT_NE(chosen, drawn(4));
}

/// White over the left half of the window.
view::Overlay half_overlay()
{
  constexpr view::VertexColour white{255, 255, 255, 255};
  view::Overlay overlay;
  overlay.vertices = {{0, 0, 0, 0, white},
                      {width / 2.0F, 0, 0, 0, white},
                      {width / 2.0F, height, 0, 0, white},
                      {0, height, 0, 0, white}};
  overlay.indices = {0, 1, 2, 0, 2, 3};
  overlay.commands = {{{0, 0, width, height}, 0, 6, 0}};
  return overlay;
}

TEST(Window, ShowsAKeptPictureAgainWithAnotherOverlay)
{
  const test::Screen screen;
  const view::Scene scene = test::joint_scene();
  const view::Shot shot{test::joint_camera(scene), {0, 0, width, height}};
  const view::Overlay overlay = half_overlay();
  view::Window window(quiet_window(4));
  window.renderer().load(scene);
  window.renderer().load(view::OverlayFont{1, 1, {255}});
  EXPECT_FALSE(window.show_again(nullptr)) << "before the first picture";
  const view::Image expected = window.renderer().draw(scene, {&shot, 1}, &overlay);
  window.show(scene, {&shot, 1}, nullptr);
  ASSERT_TRUE(window.show_again(&overlay));
  EXPECT_LE(differing_share(shown(screen, expected), expected), agreed_share);
  ASSERT_TRUE(window.show_again(nullptr));
  const view::Image bare = window.renderer().draw(scene, {&shot, 1}, nullptr);
  EXPECT_LE(differing_share(shown(screen, bare), bare), agreed_share) << "the first overlay is gone";
  window.renderer().set_samples(1);
  window.show(scene, {&shot, 1}, nullptr);
  EXPECT_FALSE(window.show_again(&overlay));
}

TEST(Window, AWarpedPictureIsThatOfMemory)
{
  const test::Screen screen;
  view::Scene scene = test::joint_scene();
  scene.background = {{0, 0, 0}, {0, 0, 0}};
  const view::Shot shot{test::joint_camera(scene), {0, 0, width, height}};
  const view::Overlay overlay = half_overlay();
  // Turned upside down and reduced to the middle.
  view::Warp warp{width, height, 0, 0, {}};
  warp.mesh.vertices = {{160, 120, 0, 1}, {480, 120, 1, 1}, {480, 360, 1, 0}, {160, 360, 0, 0}};
  warp.mesh.triangles = {0, 1, 2, 0, 2, 3};
  for (const int samples : {1, 4}) {
    view::Window window(quiet_window(samples));
    window.renderer().load(scene);
    window.renderer().load(view::OverlayFont{1, 1, {255}});
    window.renderer().load(warp);
    const view::Image expected = window.renderer().draw(scene, {&shot, 1}, &overlay);
    EXPECT_EQ(test::at(expected, 10, 10), (test::Codes{255, 255, 255, 255}));
    EXPECT_EQ(test::at(expected, width - 10, 10), (test::Codes{0, 0, 0, 255}));
    EXPECT_NE(test::at(expected, width / 2 + 20, height / 2), (test::Codes{0, 0, 0, 255}));
    window.show(scene, {&shot, 1}, &overlay);
    EXPECT_LE(differing_share(shown(screen, expected), expected), agreed_share);
  }
}

/// A part of it.
view::Image cut_out(const view::Image& image, int x, int y)
{
  view::Image part{width, height, {}};
  for (int row = y; row < y + height; ++row) {
    const auto begin = image.rgba.begin() + 4 * (row * image.width + x);
    part.rgba.insert(part.rgba.end(), begin, begin + 4 * width);
  }
  return part;
}

TEST(Window, ItIsAtTheRequestedPosition)
{
  const test::Screen screen;
  const view::Scene scene = test::joint_scene();
  const view::Shot shot{test::joint_camera(scene), {0, 0, width, height}};
  view::WindowOptions options = quiet_window(1);
  options.at = {311, 207};
  options.is_resizable = false;
  view::Window window(options);
  window.renderer().load(scene);
  window.events();
  const view::WindowGeometry place = window.geometry();
  EXPECT_EQ(place.x, 311);
  EXPECT_EQ(place.y, 207);
  EXPECT_EQ(place.width, width);
  EXPECT_EQ(place.height, height);
  const view::Image drawn = window.renderer().draw(scene, {&shot, 1}, nullptr);
  const auto differs = [&] {
    return differing_share(drawn, cut_out(screen.picture(1280, 1024), 311, 207)) > 0.0;
  };
  EXPECT_TRUE(differs());
  EXPECT_TRUE(test::comes_true([&] {
    if (differs()) window.show(scene, {&shot, 1}, nullptr);
    return !differs();
  }));
}

TEST(Window, ItClosesOnRequest)
{
  const test::Screen screen;
  view::Window window(quiet_window(1));
  EXPECT_FALSE(window.should_close());
  window.close();
  EXPECT_TRUE(window.should_close());
}

/// The events of one call of xdotool, up to an event of kind `last` with key `key`; waits up to a minute.
std::vector<view::InputEvent> heard(view::Window& window, const std::vector<std::string>& arguments,
                                    view::InputKind last, view::Key key)
{
  EXPECT_EQ(test::run({"/usr/bin/xdotool", arguments, {}, {}}).exit_code, 0);
  std::vector<view::InputEvent> all;
  for (int i = 0; i < 600; ++i) {
    for (const view::InputEvent& event : window.events(0.1)) {
      all.push_back(event);
      if (event.kind == last && event.key == key) return all;
    }
  }
  ADD_FAILURE() << "the last event did not arrive";
  return all;
}

std::vector<view::InputEvent> of_kind(const std::vector<view::InputEvent>& events, view::InputKind kind)
{
  std::vector<view::InputEvent> found;
  std::copy_if(events.begin(), events.end(), std::back_inserter(found),
               [&](const view::InputEvent& event) { return event.kind == kind; });
  return found;
}

TEST(Window, EventsOfTheMouseAreReceived)
{
  const test::Screen screen;
  view::Window window(quiet_window(1));
  window.events();
  // "z" ends each sequence: key events arrive after earlier events.
  std::vector<view::InputEvent> events =
      heard(window, {"mousemove", "100", "50", "click", "--repeat", "2", "--delay", "20", "1", "key", "z"},
            view::InputKind::key_release, view::key_of('Z'));
  std::vector<view::InputEvent> presses = of_kind(events, view::InputKind::press);
  ASSERT_EQ(presses.size(), 2U);
  EXPECT_EQ(presses[0].n_clicks, 1);
  EXPECT_EQ(presses[1].n_clicks, 2);
  for (const view::InputEvent& press : presses) {
    EXPECT_EQ(press.button, view::MouseButton::left);
    EXPECT_EQ(press.x_px, 100.0);
    EXPECT_EQ(press.y_px, 50.0);
  }
  EXPECT_EQ(of_kind(events, view::InputKind::release).size(), 2U);
  events = heard(
      window, {"mousemove", "200", "60", "click", "3", "click", "2", "click", "4", "click", "5", "key", "z"},
      view::InputKind::key_release, view::key_of('Z'));
  presses = of_kind(events, view::InputKind::press);
  ASSERT_EQ(presses.size(), 2U);
  EXPECT_EQ(presses[0].button, view::MouseButton::right);
  EXPECT_EQ(presses[1].button, view::MouseButton::middle);
  EXPECT_EQ(presses[1].n_clicks, 1);
  const std::vector<view::InputEvent> wheel = of_kind(events, view::InputKind::wheel);
  ASSERT_EQ(wheel.size(), 2U);
  EXPECT_EQ(wheel[0].wheel, 1.0);
  EXPECT_EQ(wheel[1].wheel, -1.0);
}

TEST(Window, KeysAreReceivedWithTheirModifiers)
{
  const test::Screen screen;
  view::Window window(quiet_window(1));
  window.events();
  const std::vector<view::InputEvent> events = heard(
      window, {"mousemove", "100", "50", "key", "a", "key", "shift+a", "key", "ctrl+Right", "key", "F3"},
      view::InputKind::key_release, view::Key::f3);
  const std::vector<view::InputEvent> presses = of_kind(events, view::InputKind::key_press);
  std::vector<view::Key> keys;
  std::transform(presses.begin(), presses.end(), std::back_inserter(keys),
                 [](const view::InputEvent& press) { return press.key; });
  ASSERT_THAT(keys, testing::ElementsAre(view::key_of('A'), view::Key::none, view::key_of('A'),
                                         view::Key::none, view::Key::right, view::Key::f3));
  EXPECT_FALSE(presses[0].has_shift);
  EXPECT_TRUE(presses[2].has_shift);
  EXPECT_TRUE(presses[4].has_control);
}

TEST(Window, OneAfterTheOther)
{
  const test::Screen screen;
  for (int i = 0; i < 3; ++i) {
    view::Window window(quiet_window(1));
    window.set_title("another");
    window.events();
    EXPECT_EQ(window.renderer().width(), width);
    EXPECT_EQ(window.renderer().height(), height);
    EXPECT_GT(window.content_scale(), 0.0);
    EXPECT_FALSE(window.is_iconified());
  }
}

TEST(Window, WithoutAScreenThatIsSaid)
{
  for (const char* const display : {"", ":98765"}) {
    setenv("DISPLAY", display, 1);
    try {
      const view::Window window(quiet_window(1));
      ADD_FAILURE() << "opened";
    } catch (const InputError& error) {
      EXPECT_EQ(error.facts().file, "window");
      EXPECT_EQ(error.facts().field, "display");
      EXPECT_THAT(error.facts().wanted, testing::HasSubstr("--offscreen"));
    }
  }
  unsetenv("DISPLAY");
}

}  // namespace vrda::window_test
