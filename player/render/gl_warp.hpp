/// Carries a finished picture over into another by a mesh.
#pragma once

#include <array>

#include "render/gl_target.hpp"
#include "render/renderer.hpp"

namespace vrda {

class WarpPainter {
 public:
  WarpPainter(const GlTable& gl, const Warp& warp, int picture_width, int picture_height);
  ~WarpPainter();
  WarpPainter(const WarpPainter&) = delete;
  WarpPainter& operator=(const WarpPainter&) = delete;

  /// Reads the frame buffer `picture`, which has no samples; draws into warped(), which is bound afterwards.
  void draw(unsigned picture);
  const Target& warped() const { return warped_; }
  int width() const { return width_; }
  int height() const { return height_; }

 private:
  void upload(const WarpMesh& mesh);

  const GlTable& gl_;
  int width_ = 0, height_ = 0, picture_width_ = 0, picture_height_ = 0;
  int n_indices_ = 0;
  unsigned program_ = 0, vertex_array_ = 0;
  std::array<unsigned, 2> buffers_{};           // vertices, indices
  unsigned picture_ = 0, picture_texture_ = 0;  // frame buffer and its colour
  Target warped_;
};

}  // namespace vrda
