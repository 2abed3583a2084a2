/// Translucent surfaces in their right order.
#pragma once

#include <array>

#include "render/gl_surfaces.hpp"
#include "render/gl_table.hpp"

namespace vrda {

/// Layer by layer from the farthest: a first pass finds the farthest translucent depth before the last
/// layer's, a second one blends what has exactly that depth over the picture.
/// Source: Everitt (2001), "Interactive order-independent transparency"; here from the back, which needs no
/// second colour buffer.
class LayerPeeler {
 public:
  /// Layers beyond this many are left out, the nearest ones: a bound for hostile scenes.
  static constexpr int most_layers = 64;

  LayerPeeler(const GlTable& gl, const TargetPlan& plan, const Target& drawn);
  ~LayerPeeler();
  LayerPeeler(const LayerPeeler&) = delete;
  LayerPeeler& operator=(const LayerPeeler&) = delete;

  /// Over the opaque surfaces that stand in `drawn`, which stays bound.
  void draw(SurfacePainter& surfaces, const Scene& scene, const Target& drawn);

 private:
  bool is_found(unsigned query) const;
  /// The farthest depths before `behind`; `query` then tells whether there were any, unless it is 0.
  void peel(SurfacePainter& surfaces, const Scene& scene, unsigned behind, unsigned query);

  const GlTable& gl_;
  bool is_multisampled_;
  std::array<Target, 2> layers_{};       // the last one and the one being found
  int n_expected_ = 0;                   // layers of the last picture
  unsigned query_ = 0, last_query_ = 0;  // of a layer beyond them, and of the last of them
};

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
