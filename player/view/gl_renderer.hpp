/// Post-processing of a rendered image: overlay and warp.
#pragma once

#include <Eigen/Core>

#include <array>
#include <span>

#include "view/gl_mesh.hpp"
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

// Ambient occlusion in screen space: darkens opaque surfaces in clefts and where bodies touch.

/// The occlusion is computed at every second pixel in both directions. Source: McGuire, Mara and Luebke
/// (2012), Scalable ambient obscurance; without its mip levels.
class OcclusionPainter {
 public:
  /// `drawn` is the target to be darkened; all of its samples get the value of the first one.
  OcclusionPainter(const GlTable& gl, const TargetPlan& plan, const Target& drawn);
  ~OcclusionPainter();
  OcclusionPainter(const OcclusionPainter&) = delete;
  OcclusionPainter& operator=(const OcclusionPainter&) = delete;

  struct View {
    PixelBox box;                ///< of the shot, also the scissor box
    Eigen::Matrix4f projection;  ///< of its camera
    float radius_mm = 0.0F;      ///< above 0
  };
  /// Requires the scissor test and the depth of `drawn`; leaves `drawn` bound. `empty_array`: a vertex array
  /// without attributes.
  void draw(const View& view, const Target& drawn, unsigned empty_array);

 private:
  struct Layer {
    unsigned frame = 0, texture = 0;
  };
  Layer create_half_layer() const;
  void pass(unsigned program, const View& view, unsigned texture, unsigned empty_array) const;

  const GlTable& gl_;
  TargetPlan plan_;
  int half_width_ = 0, half_height_ = 0;
  Target depth_;               ///< the first sample's; empty without multisampling
  unsigned colour_frame_ = 0;  ///< the colour of the target without its depth
  Layer found_, smoothed_;     ///< part of the light and depth in mm
  unsigned find_program_ = 0, smooth_program_ = 0, apply_program_ = 0;
};

// Order-independent transparency on the graphics card, by depth peeling or by lists of fragments per pixel.
// In: a scene (mm) and the target with its opaque surfaces. Out: translucent surfaces blended into that
// target.

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
