/// Translucent surfaces in their right order at every pixel, in one pass.
#pragma once

#include "render/gl_surfaces.hpp"
#include "render/gl_table.hpp"

namespace vrda {

/// A pass over the translucent surfaces keeps every fragment in a list of its pixel; a second one, over
/// pixels, blends each list from the farthest on. Wants OpenGL 4.3, and one sample a pixel. Source: Yang et
/// al. (2010), "Real-time concurrent linked list construction on the GPU".
class FragmentLists {
 public:
  static bool are_possible(const GlTable& gl);

  explicit FragmentLists(const GlTable& gl);
  ~FragmentLists();
  FragmentLists(const FragmentLists&) = delete;
  FragmentLists& operator=(const FragmentLists&) = delete;

  /// Wanted before anything is drawn, and when the picture's size changes.
  void resize(int width, int height);
  /// Over the opaque surfaces that stand in the frame buffer bound, by blending. `empty_array` is a vertex
  /// array without attributes. False, with nothing drawn, when there are more fragments than a buffer can
  /// hold.
  bool draw(SurfacePainter& surfaces, const Scene& scene, unsigned empty_array);

 private:
  void open();
  void reserve(std::size_t n_nodes);
  void clear_heads();
  std::size_t store(SurfacePainter& surfaces, const Scene& scene);

  const GlTable& gl_;
  unsigned width_ = 0, height_ = 0;
  unsigned heads_ = 0, nodes_ = 0, count_ = 0;
  std::size_t capacity_ = 0, most_nodes_ = 0;
  unsigned blend_program_ = 0;
  bool is_open_ = false;  // buffers for this size, the program for any: made when first used
};

}  // namespace vrda
