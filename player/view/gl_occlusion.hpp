/// Ambient occlusion in screen space: darkens opaque surfaces in clefts and where bodies touch.
#pragma once

#include <Eigen/Core>

#include "view/gl_surfaces.hpp"
#include "view/gl_table.hpp"

namespace vrda::view {

/// The occlusion is computed at every second pixel in both directions. Source: McGuire, Mara and Luebke (2012),
/// Scalable ambient obscurance; without its mip levels.
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

}  // namespace vrda::view
