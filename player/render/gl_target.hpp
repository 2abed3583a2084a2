/// Frame buffers to draw to.
#pragma once

#include "render/gl_table.hpp"

namespace vrda {

struct TargetPlan {
  int width = 0, height = 0;
  int samples = 0;  ///< 0 for no multisampling
  bool has_depth = true;
};

/// Colour is a render buffer, sRGB; depth is a texture (32-bit), so that shaders may compare with it.
struct Target {
  unsigned frame = 0;
  unsigned colour = 0;  ///< 0: shares that of another
  unsigned depth = 0;   ///< 0: none
};

/// With colour of its own.
Target opened_target(const GlTable& gl, const TargetPlan& plan);
/// With depth of its own, drawing into the colour of `other`.
Target opened_layer(const GlTable& gl, const TargetPlan& plan, const Target& other);
void close_target(const GlTable& gl, Target& target);

}  // namespace vrda
