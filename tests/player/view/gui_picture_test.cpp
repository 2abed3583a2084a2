// The interface as pixels, drawn without a screen.
#include <gtest/gtest.h>

#include <algorithm>

#include "view/gui.hpp"

namespace vrda::gui_picture_test {

constexpr int width = 800, height = 600;

std::array<int, 3> pixel(const view::Image& image, int x, int y)
{
  const std::size_t i = 4 * static_cast<std::size_t>(y * image.width + x);
  return {image.rgba[i], image.rgba[i + 1], image.rgba[i + 2]};
}

/// A frame of the interface over an empty, white scene.
class Drawn {
 public:
  Drawn() : gui_({"A knee", {"raw"}, 1.0}), renderer_(view::make_offscreen_renderer({width, height, 1}))
  {
    scene_.background = {Eigen::Vector3f::Ones(), Eigen::Vector3f::Ones()};
    renderer_->load(scene_);
    renderer_->load(gui_.font());
  }
  view::Image picture(const view::PlayerState& state)
  {
    view::GuiFrame frame;
    frame.width = width;
    frame.height = height;
    frame.elapsed_s = 0.02;
    view::Readout readout;
    readout.pose.status = store::PoseStatus::solved;
    for (int i = 0; i < 3; ++i) gui_.frame(frame, state, {}, readout);
    const view::Shot shot{{}, {0, 0, width, height}};
    return renderer_->draw(scene_, {&shot, 1}, &gui_.overlay());
  }

  view::Gui gui_;
  view::Scene scene_;
  std::unique_ptr<view::Renderer> renderer_;
};

/// Pixels of the rectangle brighter than `level` in every channel.
int n_bright(const view::Image& image, const view::Viewport& area, int level)
{
  int n = 0;
  for (int y = area.y; y < area.y + area.height; ++y) {
    for (int x = area.x; x < area.x + area.width; ++x) {
      const std::array<int, 3> colour = pixel(image, x, y);
      n += *std::ranges::min_element(colour) > level ? 1 : 0;
    }
  }
  return n;
}

TEST(GuiPicture, PanelIsOpaqueNumbersAreReadableAndThePictureIsFree)
{
  Drawn drawn;
  view::PlayerState state;
  const view::Image image = drawn.picture(state);
  const view::Viewport free = drawn.gui_.free_area(width, height, state);
  // The panel's colour, sRGB 0.10, 0.11, 0.13, to within one code.
  const std::array<int, 3> ground = pixel(image, width - 2, 590);
  EXPECT_NEAR(ground[0], 26, 1);
  EXPECT_NEAR(ground[1], 28, 1);
  EXPECT_NEAR(ground[2], 33, 1);
  EXPECT_EQ(pixel(image, free.width - 20, free.height - 20), (std::array<int, 3>{255, 255, 255}));
  // White text has enough contrast: its backing hides most of a white scene.
  const std::array<int, 3> backing = pixel(image, 2, 2);
  EXPECT_LT(backing[0], 120);
  EXPECT_GT(n_bright(image, {8, 6, 60, 20}, 230), 40);
}

TEST(GuiPicture, WithoutPanelAndNumbersThereIsOnlyTheScene)
{
  Drawn drawn;
  view::PlayerState state;
  state.shows_panel = state.shows_numbers = false;
  EXPECT_EQ(n_bright(drawn.picture(state), {0, 0, width, height}, 254), width * height);
}

}  // namespace vrda::gui_picture_test
