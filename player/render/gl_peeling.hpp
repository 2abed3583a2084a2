/// Translucent surfaces in their right order at every sample, by peeling depths from the back.
#pragma once

#include <array>

#include "render/gl_surfaces.hpp"
#include "render/gl_table.hpp"
#include "render/gl_target.hpp"

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

}  // namespace vrda
