#include "view/gl_occlusion.hpp"

#include <GL/glcorearb.h>

#include <array>

#include "view/shaders.hpp"

namespace vrda::view {

OcclusionPainter::OcclusionPainter(const GlTable& gl, const TargetPlan& plan, const Target& drawn)
    : gl_(gl), plan_(plan), half_width_((plan.width + 1) / 2), half_height_((plan.height + 1) / 2)
{
  if (plan.samples > 0) depth_ = create_target(gl_, {plan.width, plan.height, 0});
  gl_.GenFramebuffers(1, &colour_frame_);
  gl_.BindFramebuffer(GL_FRAMEBUFFER, colour_frame_);
  gl_.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, drawn.colour);
  found_ = create_half_layer();
  smoothed_ = create_half_layer();
  const char* const first = "#version 330 core\n";
  find_program_ = linked_program(gl_, first, background_vertex_shader, occlusion_fragment_shader);
  smooth_program_ = linked_program(gl_, first, background_vertex_shader, smoothing_fragment_shader);
  apply_program_ = linked_program(gl_, first, background_vertex_shader, darkening_fragment_shader);
}

OcclusionPainter::~OcclusionPainter()
{
  destroy_target(gl_, depth_);
  gl_.DeleteFramebuffers(1, &colour_frame_);
  for (const Layer& layer : {found_, smoothed_}) {
    gl_.DeleteFramebuffers(1, &layer.frame);
    gl_.DeleteTextures(1, &layer.texture);
  }
  for (const unsigned program : {find_program_, smooth_program_, apply_program_}) gl_.DeleteProgram(program);
}

OcclusionPainter::Layer OcclusionPainter::create_half_layer() const
{
  Layer layer;
  gl_.GenTextures(1, &layer.texture);
  gl_.BindTexture(GL_TEXTURE_2D, layer.texture);
  gl_.TexImage2D(GL_TEXTURE_2D, 0, GL_RG16F, half_width_, half_height_, 0, GL_RG, GL_FLOAT, nullptr);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  gl_.GenFramebuffers(1, &layer.frame);
  gl_.BindFramebuffer(GL_FRAMEBUFFER, layer.frame);
  gl_.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, layer.texture, 0);
  return layer;
}

void OcclusionPainter::pass(unsigned program, const View& view, unsigned texture, unsigned empty_array) const
{
  const auto at = [&](const char* name) { return gl_.GetUniformLocation(program, name); };
  gl_.UseProgram(program);
  gl_.BindTexture(GL_TEXTURE_2D, texture);
  gl_.Uniform1i(at("source"), 0);
  gl_.Uniform1f(at("radius_mm"), view.radius_mm);
  gl_.Uniform2f(at("corner_px"), static_cast<float>(view.box.x), static_cast<float>(view.box.y));
  gl_.Uniform2f(at("size_px"), static_cast<float>(view.box.width), static_cast<float>(view.box.height));
  gl_.UniformMatrix4fv(at("projection"), 1, GL_FALSE, view.projection.data());
  gl_.BindVertexArray(empty_array);
  gl_.DrawArrays(GL_TRIANGLES, 0, 3);
}

void OcclusionPainter::draw(const View& view, const Target& drawn, unsigned empty_array)
{
  const PixelBox& box = view.box;
  gl_.ActiveTexture(GL_TEXTURE0);
  gl_.Disable(GL_DEPTH_TEST);
  if (plan_.samples > 0) {
    gl_.BindFramebuffer(GL_READ_FRAMEBUFFER, drawn.frame);
    gl_.BindFramebuffer(GL_DRAW_FRAMEBUFFER, depth_.frame);
    gl_.BlitFramebuffer(0, 0, plan_.width, plan_.height, 0, 0, plan_.width, plan_.height, GL_DEPTH_BUFFER_BIT,
                        GL_NEAREST);
  }
  const PixelBox half{box.x / 2, box.y / 2, (box.x + box.width + 1) / 2 - box.x / 2,
                      (box.y + box.height + 1) / 2 - box.y / 2};
  gl_.Viewport(half.x, half.y, half.width, half.height);
  gl_.Scissor(half.x, half.y, half.width, half.height);
  gl_.BindFramebuffer(GL_FRAMEBUFFER, found_.frame);
  pass(find_program_, view, plan_.samples > 0 ? depth_.depth : drawn.depth, empty_array);
  gl_.BindFramebuffer(GL_FRAMEBUFFER, smoothed_.frame);
  pass(smooth_program_, view, found_.texture, empty_array);
  gl_.Viewport(box.x, box.y, box.width, box.height);
  gl_.Scissor(box.x, box.y, box.width, box.height);
  gl_.BindFramebuffer(GL_FRAMEBUFFER, colour_frame_);
  gl_.Enable(GL_BLEND);
  gl_.BlendFuncSeparate(GL_ZERO, GL_SRC_COLOR, GL_ZERO, GL_ONE);
  pass(apply_program_, view, smoothed_.texture, empty_array);
  gl_.Disable(GL_BLEND);
  gl_.Enable(GL_DEPTH_TEST);
  gl_.BindFramebuffer(GL_FRAMEBUFFER, drawn.frame);
}

}  // namespace vrda::view
