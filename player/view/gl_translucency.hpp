/// Order-independent transparency on the graphics card, by depth peeling or by lists of fragments per pixel.
/// In: a scene (mm) and the target with its opaque surfaces. Out: translucent surfaces blended into that
/// target.
#pragma once

#include <array>

#include "view/gl_surfaces.hpp"
#include "view/gl_table.hpp"

namespace vrda::view {

/// Depth peeling from the farthest layer: one pass finds the farthest translucent depth in front of the
/// previous layer, a second one blends the fragments of exactly that depth. Source: Everitt (2001),
/// "Interactive order-independent transparency"; here back to front, which needs no second colour buffer.
class LayerPeeler {
 public:
  /// Limit for malicious scenes; further (nearer) layers are omitted.
  static constexpr int most_layers = 64;

  LayerPeeler(const GlTable& gl, const TargetPlan& plan, const Target& drawn);
  ~LayerPeeler();
  LayerPeeler(const LayerPeeler&) = delete;
  LayerPeeler& operator=(const LayerPeeler&) = delete;

  /// Blends over the opaque surfaces in `drawn`, which stays bound.
  void draw(SurfacePainter& surfaces, const view::Scene& scene, const Target& drawn);

 private:
  bool is_found(unsigned query) const;
  /// Finds the farthest depths in front of `behind`; `query`, unless 0, records whether there are any.
  void peel(SurfacePainter& surfaces, const view::Scene& scene, unsigned behind, unsigned query);

  const GlTable& gl_;
  bool is_multisampled_;
  std::array<Target, 2> layers_{};       // the previous and the present layer
  int n_expected_ = 0;                   // layers of the previous frame
  unsigned query_ = 0, last_query_ = 0;  // for the layer after those, and for the last of those
};

/// Per-pixel linked lists: one pass stores all translucent fragments, a second one blends each list back to
/// front. Requires OpenGL 4.3 and one sample per pixel. Source: Yang et al. (2010), "Real-time concurrent
/// linked list construction on the GPU".
class FragmentLists {
 public:
  static bool is_supported(const GlTable& gl);

  explicit FragmentLists(const GlTable& gl);
  ~FragmentLists();
  FragmentLists(const FragmentLists&) = delete;
  FragmentLists& operator=(const FragmentLists&) = delete;

  /// Must be called before the first draw and after every change of size.
  void resize(int width, int height);
  /// Blends over the opaque surfaces in the bound frame buffer. `empty_array` is a vertex array without
  /// attributes. Returns false without drawing if the fragments exceed the largest buffer.
  bool draw(SurfacePainter& surfaces, const view::Scene& scene, unsigned empty_array);

 private:
  void open();
  void reserve(std::size_t n_nodes);
  void clear_heads();
  std::size_t store(SurfacePainter& surfaces, const view::Scene& scene);

  const GlTable& gl_;
  unsigned width_ = 0, height_ = 0;
  unsigned heads_ = 0, nodes_ = 0, count_ = 0;
  std::size_t capacity_ = 0, most_nodes_ = 0;
  unsigned blend_program_ = 0;
  bool is_open_ = false;  // buffers of the present size and the program exist; created on first use
};

}  // namespace vrda::view
