#include "render/gl_peeling.hpp"

#include <GL/glcorearb.h>

namespace vrda {

LayerPeeler::LayerPeeler(const GlTable& gl, const TargetPlan& plan, const Target& drawn)
    : gl_(gl), is_multisampled_(plan.samples > 0)
{
  for (Target& layer : layers_) layer = opened_layer(gl_, plan, drawn);
  gl_.GenQueries(1, &query_);
}

LayerPeeler::~LayerPeeler()
{
  for (Target& layer : layers_) close_target(gl_, layer);
  gl_.DeleteQueries(1, &query_);
}

bool LayerPeeler::found_layer(SurfacePainter& surfaces, const Scene& scene, unsigned behind)
{
  gl_.BindTexture(is_multisampled_ ? GL_TEXTURE_2D_MULTISAMPLE : GL_TEXTURE_2D, behind);
  gl_.ColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
  gl_.DepthMask(GL_TRUE);
  gl_.DepthFunc(GL_GREATER);
  gl_.Clear(GL_DEPTH_BUFFER_BIT);
  gl_.BeginQuery(GL_ANY_SAMPLES_PASSED, query_);
  surfaces.draw(scene, SurfacePass::translucent_depth);
  gl_.EndQuery(GL_ANY_SAMPLES_PASSED);
  gl_.ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  GLuint is_found = 0;
  gl_.GetQueryObjectuiv(query_, GL_QUERY_RESULT, &is_found);
  return is_found != 0;
}

void LayerPeeler::draw(SurfacePainter& surfaces, const Scene& scene, const Target& drawn)
{
  const PixelBox& box = surfaces.translucent_box();
  if (box.width <= 0 || box.height <= 0) return;
  gl_.Enable(GL_SCISSOR_TEST);
  gl_.Scissor(box.x, box.y, box.width, box.height);
  gl_.ClearDepth(0.0);
  gl_.BlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  unsigned behind = drawn.depth;
  for (int i = 0; i < most_layers; ++i) {
    const Target& layer = layers_[static_cast<std::size_t>(i % 2)];
    gl_.BindFramebuffer(GL_FRAMEBUFFER, layer.frame);
    if (!found_layer(surfaces, scene, behind)) break;
    gl_.DepthMask(GL_FALSE);
    gl_.DepthFunc(GL_EQUAL);
    gl_.Enable(GL_BLEND);
    surfaces.draw(scene, SurfacePass::translucent_colour);
    gl_.Disable(GL_BLEND);
    behind = layer.depth;
  }
  gl_.DepthMask(GL_TRUE);
  gl_.DepthFunc(GL_LESS);
  gl_.ClearDepth(1.0);
  gl_.BindFramebuffer(GL_FRAMEBUFFER, drawn.frame);
}

}  // namespace vrda
