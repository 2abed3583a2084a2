// Counts every operator new of a thread, so it stands in a file of its own.
#include <gtest/gtest.h>

#include <cstdlib>
#include <new>

#include "pictures.hpp"

namespace {
thread_local long n_allocations = 0;
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

TEST(RendererAllocation, AHundredFramesAllocateNothing)
{
  Scene scene = test::joint_scene();
  Overlay overlay;
  overlay.vertices.resize(3);
  overlay.indices = {0, 1, 2};
  overlay.commands.push_back({{0, 0, 64, 48}, 0, 3, 0});
  const std::unique_ptr<Renderer> renderer = make_offscreen_renderer({64, 48});
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
  draw_all_modes();  // each mode's programs are compiled when first used
  const long n_before = n_allocations;
  for (int i = 0; i < 20; ++i) draw_all_modes();
  EXPECT_EQ(n_allocations, n_before);
  // The counter counts.
  const std::vector<int> counted(10);
  EXPECT_EQ(n_allocations, n_before + 1);
}

}  // namespace
}  // namespace vrda
