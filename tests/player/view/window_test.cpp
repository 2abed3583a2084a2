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

namespace vrda::view::window_test {

constexpr int width = 640, height = 480;

WindowOptions quiet_window(int samples)
{
  WindowOptions options;
  options.width = width;
  options.height = height;
  options.title = "test";
  options.samples = samples;
  options.is_vsynced = false;
  return options;
}

/// The joint on a virtual screen.
class OnScreen : public testing::Test {
 protected:
  test::Screen screen_;
  Scene scene_ = test::joint_scene();
  Shot shot_{test::joint_camera(scene_), {0, 0, width, height}};
};

/// Fraction of the pixels with a channel that differs by more than `code_tolerance`.
double differing_share(const Image& a, const Image& b)
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

Image from_backend(Backend backend, const Scene& scene, int samples)
{
  const std::unique_ptr<Renderer> renderer = make_offscreen_renderer({width, height, samples}, backend);
  renderer->load(scene);
  return renderer->draw(scene, test::joint_camera(scene));
}

/// The screen's content, polled for up to a minute until it equals `expected`.
Image shown(const test::Screen& screen, const Image& expected)
{
  Image found;
  test::comes_true([&] {
    found = screen.picture(width, height);
    return differing_share(found, expected) <= agreed_share;
  });
  return found;
}

TEST_F(OnScreen, BackendsAgree)
{
  for (const int samples : {1, 4}) {
    SCOPED_TRACE(samples);
    const Image osmesa = from_backend(Backend::osmesa, scene_, samples);
    EXPECT_LE(differing_share(osmesa, from_backend(Backend::egl, scene_, samples)), agreed_share);
    const std::unique_ptr<Window> window = open_window(quiet_window(samples));
    // The comparison can fail: the empty screen is a different image.
    EXPECT_GT(differing_share(osmesa, screen_.picture(width, height)), 0.5);
    window->renderer().load(scene_);
    window->events();
    window->show(scene_, {&shot_, 1}, nullptr);
    EXPECT_LE(differing_share(osmesa, shown(screen_, osmesa)), agreed_share);
    EXPECT_LE(differing_share(osmesa, window->renderer().draw(scene_, {&shot_, 1}, nullptr)), agreed_share);
  }
}

/// White over the left half of the window.
Overlay half_overlay()
{
  constexpr VertexColour white{255, 255, 255, 255};
  Overlay overlay;
  overlay.vertices = {{0, 0, 0, 0, white},
                      {width / 2.0F, 0, 0, 0, white},
                      {width / 2.0F, height, 0, 0, white},
                      {0, height, 0, 0, white}};
  overlay.indices = {0, 1, 2, 0, 2, 3};
  overlay.commands = {{{0, 0, width, height}, 0, 6, 0}};
  return overlay;
}

// Shows a kept picture again with another overlay.
TEST_F(OnScreen, KeptPicture)
{
  const Overlay overlay = half_overlay();
  const std::unique_ptr<Window> window = open_window(quiet_window(4));
  window->renderer().load(scene_);
  window->renderer().load(OverlayFont{1, 1, {255}});
  EXPECT_FALSE(window->show_again(nullptr)) << "before the first picture";
  const Image expected = window->renderer().draw(scene_, {&shot_, 1}, &overlay);
  window->show(scene_, {&shot_, 1}, nullptr);
  ASSERT_TRUE(window->show_again(&overlay));
  EXPECT_LE(differing_share(shown(screen_, expected), expected), agreed_share);
  ASSERT_TRUE(window->show_again(nullptr));
  const Image bare = window->renderer().draw(scene_, {&shot_, 1}, nullptr);
  EXPECT_LE(differing_share(shown(screen_, bare), bare), agreed_share) << "the first overlay is gone";
  window->renderer().set_samples(1);
  window->show(scene_, {&shot_, 1}, nullptr);
  EXPECT_FALSE(window->show_again(&overlay));
}

TEST_F(OnScreen, Warp)
{
  scene_.background = {{0, 0, 0}, {0, 0, 0}};
  const Overlay overlay = half_overlay();
  // Turned upside down and reduced to the middle.
  Warp warp{width, height, 0, 0, {}};
  warp.mesh.vertices = {{160, 120, 0, 1}, {480, 120, 1, 1}, {480, 360, 1, 0}, {160, 360, 0, 0}};
  warp.mesh.triangles = {0, 1, 2, 0, 2, 3};
  for (const int samples : {1, 4}) {
    const std::unique_ptr<Window> window = open_window(quiet_window(samples));
    window->renderer().load(scene_);
    window->renderer().load(OverlayFont{1, 1, {255}});
    window->renderer().load(warp);
    const Image expected = window->renderer().draw(scene_, {&shot_, 1}, &overlay);
    EXPECT_EQ(test::at(expected, 10, 10), (test::Codes{255, 255, 255, 255}));
    EXPECT_EQ(test::at(expected, width - 10, 10), (test::Codes{0, 0, 0, 255}));
    EXPECT_NE(test::at(expected, width / 2 + 20, height / 2), (test::Codes{0, 0, 0, 255}));
    window->show(scene_, {&shot_, 1}, &overlay);
    EXPECT_LE(differing_share(shown(screen_, expected), expected), agreed_share);
  }
}

/// The events of one call of xdotool, up to an event of kind `last` with key `key`; waits up to a minute.
std::vector<InputEvent> heard(Window& window, const std::vector<std::string>& arguments, InputKind last,
                              Key key)
{
  EXPECT_EQ(test::run({"/usr/bin/xdotool", arguments, {}, {}}).exit_code, 0);
  std::vector<InputEvent> all;
  for (int i = 0; i < 600; ++i) {
    for (const InputEvent& event : window.events(0.1)) {
      all.push_back(event);
      if (event.kind == last && event.key == key) return all;
    }
  }
  ADD_FAILURE() << "the last event did not arrive";
  return all;
}

std::vector<InputEvent> of_kind(const std::vector<InputEvent>& events, InputKind kind)
{
  std::vector<InputEvent> found;
  std::copy_if(events.begin(), events.end(), std::back_inserter(found),
               [&](const InputEvent& event) { return event.kind == kind; });
  return found;
}

TEST_F(OnScreen, Mouse)
{
  const std::unique_ptr<Window> window = open_window(quiet_window(1));
  window->events();
  // "z" ends each sequence: key events arrive after earlier events.
  std::vector<InputEvent> events =
      heard(*window, {"mousemove", "100", "50", "click", "--repeat", "2", "--delay", "20", "1", "key", "z"},
            InputKind::key_release, key_of('Z'));
  std::vector<InputEvent> presses = of_kind(events, InputKind::press);
  ASSERT_EQ(presses.size(), 2U);
  EXPECT_EQ(presses[0].n_clicks, 1);
  EXPECT_EQ(presses[1].n_clicks, 2);
  for (const InputEvent& press : presses) {
    EXPECT_EQ(press.button, MouseButton::left);
    EXPECT_EQ(press.x_px, 100.0);
    EXPECT_EQ(press.y_px, 50.0);
  }
  EXPECT_EQ(of_kind(events, InputKind::release).size(), 2U);
  events = heard(
      *window, {"mousemove", "200", "60", "click", "3", "click", "2", "click", "4", "click", "5", "key", "z"},
      InputKind::key_release, key_of('Z'));
  presses = of_kind(events, InputKind::press);
  ASSERT_EQ(presses.size(), 2U);
  EXPECT_EQ(presses[0].button, MouseButton::right);
  EXPECT_EQ(presses[1].button, MouseButton::middle);
  EXPECT_EQ(presses[1].n_clicks, 1);
  const std::vector<InputEvent> wheel = of_kind(events, InputKind::wheel);
  ASSERT_EQ(wheel.size(), 2U);
  EXPECT_EQ(wheel[0].wheel, 1.0);
  EXPECT_EQ(wheel[1].wheel, -1.0);
}

TEST_F(OnScreen, Keys)
{
  const std::unique_ptr<Window> window = open_window(quiet_window(1));
  window->events();
  const std::vector<InputEvent> events = heard(
      *window, {"mousemove", "100", "50", "key", "a", "key", "shift+a", "key", "ctrl+Right", "key", "F3"},
      InputKind::key_release, Key::f3);
  const std::vector<InputEvent> presses = of_kind(events, InputKind::key_press);
  std::vector<Key> keys;
  std::transform(presses.begin(), presses.end(), std::back_inserter(keys),
                 [](const InputEvent& press) { return press.key; });
  ASSERT_THAT(keys,
              testing::ElementsAre(key_of('A'), Key::none, key_of('A'), Key::none, Key::right, Key::f3));
  EXPECT_FALSE(presses[0].has_shift);
  EXPECT_TRUE(presses[2].has_shift);
  EXPECT_TRUE(presses[4].has_control);
}

}  // namespace vrda::view::window_test
