#include "render/gl_peeling.hpp"

#include <GL/glcorearb.h>

#include <utility>

namespace vrda {

LayerPeeler::LayerPeeler(const GlTable& gl, const TargetPlan& plan, const Target& drawn)
    : gl_(gl), is_multisampled_(plan.samples > 0)
{
  for (Target& layer : layers_) layer = opened_layer(gl_, plan, drawn);
  gl_.GenQueries(1, &query_);
  gl_.GenQueries(1, &last_query_);
}

LayerPeeler::~LayerPeeler()
{
  for (Target& layer : layers_) close_target(gl_, layer);
  gl_.DeleteQueries(1, &query_);
  gl_.DeleteQueries(1, &last_query_);
}

bool LayerPeeler::is_found(unsigned query) const
{
  GLuint is_found = 0;
  gl_.GetQueryObjectuiv(query, GL_QUERY_RESULT, &is_found);
  return is_found != 0;
}

void LayerPeeler::peel(SurfacePainter& surfaces, const Scene& scene, unsigned behind, unsigned query)
{
  gl_.BindTexture(is_multisampled_ ? GL_TEXTURE_2D_MULTISAMPLE : GL_TEXTURE_2D, behind);
  gl_.ColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
  gl_.DepthMask(GL_TRUE);
  gl_.DepthFunc(GL_GREATER);
  gl_.Clear(GL_DEPTH_BUFFER_BIT);
  if (query != 0) gl_.BeginQuery(GL_ANY_SAMPLES_PASSED, query);
  surfaces.draw(scene, SurfacePass::translucent_depth);
  if (query != 0) gl_.EndQuery(GL_ANY_SAMPLES_PASSED);
  gl_.ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
}

void LayerPeeler::draw(SurfacePainter& surfaces, const Scene& scene, const Target& drawn)
{
  const PixelBox& box = surfaces.translucent_box();
  if (box.width <= 0 || box.height <= 0) return;
  gl_.Enable(GL_SCISSOR_TEST);
  gl_.Scissor(box.x, box.y, box.width, box.height);
  gl_.ClearDepth(0.0);
  gl_.BlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  // Asking whether a layer held anything waits for it to be drawn. So as many layers as the last time are
  // drawn without asking, one that turns out empty draws nothing; whether the last of them was needed is
  // asked a frame later.
  if (n_expected_ > 0 && !is_found(last_query_)) --n_expected_;
  unsigned behind = drawn.depth;
  for (int i = 0; i < most_layers; ++i) {
    const Target& layer = layers_[static_cast<std::size_t>(i % 2)];
    gl_.BindFramebuffer(GL_FRAMEBUFFER, layer.frame);
    const bool is_expected = i < n_expected_;
    const bool is_last_expected = i + 1 == n_expected_;
    peel(surfaces, scene, behind, is_last_expected ? last_query_ : is_expected ? 0 : query_);
    if (!is_expected) {
      if (!is_found(query_)) break;
      n_expected_ = i + 1;
      std::swap(query_, last_query_);
    }
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
