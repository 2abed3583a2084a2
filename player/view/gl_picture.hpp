/// Post-processing of a rendered image: overlay and warp.
#pragma once

#include <array>
#include <span>

#include "view/gl_surfaces.hpp"
#include "view/gl_table.hpp"
#include "view/renderer.hpp"

namespace vrda::view {

class OverlayPainter {
 public:
  explicit OverlayPainter(const GlTable& gl);
  ~OverlayPainter();
  OverlayPainter(const OverlayPainter&) = delete;
  OverlayPainter& operator=(const OverlayPainter&) = delete;

  void load(const OverlayFont& font);
  /// Draws onto the bound frame buffer of `width` x `height` pixels.
  void draw(const Overlay& overlay, int width, int height);

 private:
  void upload(const Overlay& overlay);

  const GlTable& gl_;
  unsigned program_ = 0, vertex_array_ = 0, font_ = 0;
  std::array<unsigned, 2> buffers_{};           // vertices, indices
  std::array<std::ptrdiff_t, 2> room_bytes_{};  // of the buffers
  int size_px_ = -1;
};

/// Warps a rendered image by a mesh.
class WarpPainter {
 public:
  WarpPainter(const GlTable& gl, const view::Warp& warp, int picture_width, int picture_height);
  ~WarpPainter();
  WarpPainter(const WarpPainter&) = delete;
  WarpPainter& operator=(const WarpPainter&) = delete;

  /// Reads the boxes `changed` of the frame buffer `picture`, which may be multisampled, and warps the boxes
  /// `used`, outside which it is black, to the frame buffer `to`, which is bound afterwards.
  void draw(unsigned picture, std::span<const PixelBox> changed, std::span<const PixelBox> used, unsigned to);
  const Target& warped() const { return warped_; }
  int width() const { return width_; }
  int height() const { return height_; }

 private:
  void upload(const view::WarpMesh& mesh);
  PixelBox warped_box(const PixelBox& used) const;

  const GlTable& gl_;
  view::WarpMesh mesh_;
  int width_ = 0, height_ = 0, picture_width_ = 0, picture_height_ = 0;
  int n_indices_ = 0;
  bool is_encoded_ = false;  ///< interpolates sRGB values, without decoding and encoding
  unsigned program_ = 0, vertex_array_ = 0;
  std::array<unsigned, 2> buffers_{};           // vertices, indices
  unsigned picture_ = 0, picture_texture_ = 0;  // frame buffer and its colour texture
  Target warped_;
};

}  // namespace vrda::view
