#include <gtest/gtest.h>

#include "player/view/pictures.hpp"
#include "support/allocation_count.hpp"

namespace vrda::view::allocation_test {

class RendererAllocation : public testing::TestWithParam<int> {
};  // samples: they select the transparency algorithm

TEST_P(RendererAllocation, HundredFrames)
{
  VRDA_REQUIRE_ALLOCATION_COUNT();
  Scene scene = test::joint_scene();
  Overlay overlay;
  overlay.vertices.resize(3);
  overlay.indices = {0, 1, 2};
  overlay.commands.push_back({{0, 0, 64, 48}, 0, 3, 0});
  const std::unique_ptr<Renderer> renderer = make_offscreen_renderer({64, 48, GetParam()});
  renderer->load(scene);
  renderer->load(OverlayFont{1, 1, {255}});
  const Shot shot{test::joint_camera(scene), {0, 0, 64, 48}};
  const auto draw_all_modes = [&] {
    for (const DrawMode mode :
         {DrawMode::wire, DrawMode::hidden_line, DrawMode::flat, DrawMode::smooth, DrawMode::textured}) {
      scene.mode = mode;
      ++scene.drawables[0].revision;
      renderer->draw(scene, {&shot, 1}, &overlay);
    }
  };
  draw_all_modes();  // shaders of each mode are compiled on first use
  const long n_before = test::allocations_of_thread();
  for (int i = 0; i < 20; ++i) draw_all_modes();
  EXPECT_EQ(test::allocations_of_thread(), n_before);
  // The counter works.
  const std::vector<int> counted(10);
  EXPECT_EQ(test::allocations_of_thread(), n_before + 1);
}

INSTANTIATE_TEST_SUITE_P(OneAndMoreSamples, RendererAllocation, testing::Values(1, 4));

}  // namespace vrda::view::allocation_test
