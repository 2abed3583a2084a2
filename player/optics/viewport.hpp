/// Parts of pictures, and triangles that carry a picture to other places.
#pragma once

#include <cstdint>
#include <vector>

namespace vrda {

/// Part of a picture, in pixels from its top left corner.
struct Viewport {
  int x = 0, y = 0, width = 0, height = 0;

  bool operator==(const Viewport&) const = default;
};

/// Triangles that carry the picture to other places: what takes the distortion of optics back.
struct WarpVertex {
  float x_px = 0.0F, y_px = 0.0F;  ///< where it is drawn, from the warped picture's top left corner
  float u = 0.0F, v = 0.0F;        ///< of the picture, from its top left corner, on [0, 1]
};
struct WarpMesh {
  std::vector<WarpVertex> vertices;
  std::vector<std::uint32_t> triangles;  ///< three indices of `vertices` each
};
struct Warp {
  int width = 0, height = 0;                  ///< of the warped picture; black where no triangle is
  int picture_width = 0, picture_height = 0;  ///< of the picture that is warped; 0: the renderer's
  WarpMesh mesh;
};

}  // namespace vrda
