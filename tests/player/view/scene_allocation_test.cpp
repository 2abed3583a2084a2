#include <gtest/gtest.h>

#include "player/view/layer_models.hpp"
#include "support/allocation_count.hpp"

namespace vrda::view::allocation_test {

TEST(LayersAllocation, EveryLayer)
{
  VRDA_REQUIRE_ALLOCATION_COUNT();
  for (const std::string side : {"right", "left"}) {
    test::Stage stage(test::layered_model(side));
    const LayerSet all = test::every_layer();
    stage.show(test::Degrees{0.0, 0.0}, all);  // creates the static circle table of the solids
    const long before = test::allocations_of_program();
    int n_shown = 0;
    for (int k = 0; k < 200; ++k) {
      stage.show(test::Degrees{0.45 * k, 0.02 * k - 2.0}, all);
      for (const Drawable& drawable : stage.scene.drawables) n_shown += drawable.is_shown ? 1 : 0;
    }
    EXPECT_EQ(test::allocations_of_program() - before, 0);
    EXPECT_GT(n_shown, 200 * 10);
  }
  // The counter works.
  const long before = test::allocations_of_program();
  ::operator delete(::operator new(1));
  EXPECT_GE(test::allocations_of_program() - before, 1);
}

}  // namespace vrda::view::allocation_test
