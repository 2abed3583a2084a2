/// An image for surfaces.
#pragma once

#include <cstdint>
#include <vector>

namespace vrda {

/// Repeated over a surface, seen along each of the three axes of its mesh and mixed by the normal
/// (triplanar), so that it needs no coordinates of its own and moves with the mesh.
struct Texture {
  int width = 0;  ///< pixels; 0: no texture
  int height = 0;
  std::vector<std::uint8_t> rgb;  ///< [height * width * 3] sRGB, top row first
  double scale_mm = 40.0;         ///< width of one repeat

  bool is_empty() const { return rgb.empty(); }
};

}  // namespace vrda
