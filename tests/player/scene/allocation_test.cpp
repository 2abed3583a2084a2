// Counts every operator new of this test program, so it stands in a file of its own.
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <new>

#include "player/scene/layer_models.hpp"

namespace {
std::atomic<long> n_allocations{0};
}

// Not inlined: GCC would see malloc and delete, or new and free, and call them mismatched.
[[gnu::noinline]] void* operator new(std::size_t size)
{
  ++n_allocations;
  if (void* memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void* operator new(std::size_t size, std::align_val_t alignment)
{
  ++n_allocations;
  const auto step = static_cast<std::size_t>(alignment);
  if (void* memory = std::aligned_alloc(step, (size + step - 1) / step * step)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept
{
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept
{
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::align_val_t) noexcept
{
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t, std::align_val_t) noexcept
{
  std::free(memory);
}

namespace vrda {
namespace {

TEST(LayersAllocation, AFrameOfEveryLayerAllocatesNothing)
{
  for (const std::string side : {"right", "left"}) {
    test::Stage stage(test::layered_model(side));
    const LayerSet all = test::every_layer();
    stage.show(test::Degrees{0.0, 0.0}, all);  // what is made once: the circle that solids are turned on
    const long before = n_allocations;
    int n_shown = 0;
    for (int k = 0; k < 200; ++k) {
      stage.show(test::Degrees{0.45 * k, 0.02 * k - 2.0}, all);
      for (const Drawable& drawable : stage.scene.drawables) n_shown += drawable.is_shown ? 1 : 0;
    }
    EXPECT_EQ(n_allocations - before, 0);
    EXPECT_GT(n_shown, 200 * 10);
  }
  // The counter counts.
  const long before = n_allocations;
  ::operator delete(::operator new(1));
  EXPECT_GE(n_allocations - before, 1);
}

}  // namespace
}  // namespace vrda
