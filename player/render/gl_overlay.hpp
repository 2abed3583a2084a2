/// Draws overlays: flat triangles with glyphs, clipped to rectangles.
#pragma once

#include <array>

#include "render/gl_table.hpp"
#include "render/renderer.hpp"

namespace vrda {

class OverlayPainter {
 public:
  explicit OverlayPainter(const GlTable& gl);
  ~OverlayPainter();
  OverlayPainter(const OverlayPainter&) = delete;
  OverlayPainter& operator=(const OverlayPainter&) = delete;

  void load(const OverlayFont& font);
  /// Onto the bound frame buffer, of `width` x `height` pixels.
  void draw(const Overlay& overlay, int width, int height);

 private:
  void upload(const Overlay& overlay);

  const GlTable& gl_;
  unsigned program_ = 0, vertex_array_ = 0, font_ = 0;
  std::array<unsigned, 2> buffers_{};           // vertices, indices
  std::array<std::ptrdiff_t, 2> room_bytes_{};  // of the buffers
  int size_px_ = -1;
};

}  // namespace vrda
