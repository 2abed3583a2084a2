#include "render/gl_target.hpp"

#include <GL/glcorearb.h>

#include "core/error.hpp"

namespace vrda {
namespace {

void attach_colour(const GlTable& gl, const TargetPlan& plan, Target& target)
{
  gl.GenRenderbuffers(1, &target.colour);
  gl.BindRenderbuffer(GL_RENDERBUFFER, target.colour);
  gl.RenderbufferStorageMultisample(GL_RENDERBUFFER, plan.samples, GL_SRGB8_ALPHA8, plan.width, plan.height);
  gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, target.colour);
}

void attach_depth(const GlTable& gl, const TargetPlan& plan, Target& target)
{
  const GLenum kind = plan.samples > 0 ? GL_TEXTURE_2D_MULTISAMPLE : GL_TEXTURE_2D;
  gl.GenTextures(1, &target.depth);
  gl.BindTexture(kind, target.depth);
  if (plan.samples > 0) {
    // Fixed sample locations: render buffers, which colour is, have no others.
    gl.TexImage2DMultisample(kind, plan.samples, GL_DEPTH_COMPONENT32F, plan.width, plan.height, GL_TRUE);
  } else {
    gl.TexImage2D(kind, 0, GL_DEPTH_COMPONENT32F, plan.width, plan.height, 0, GL_DEPTH_COMPONENT, GL_FLOAT,
                  nullptr);
    gl.TexParameteri(kind, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    gl.TexParameteri(kind, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  }
  gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, kind, target.depth, 0);
}

Target framed(const GlTable& gl)
{
  Target target;
  gl.GenFramebuffers(1, &target.frame);
  gl.BindFramebuffer(GL_FRAMEBUFFER, target.frame);
  return target;
}

void check_complete(const GlTable& gl)
{
  check(gl.CheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE, "a frame buffer is complete");
}

}  // namespace

Target opened_target(const GlTable& gl, const TargetPlan& plan)
{
  Target target = framed(gl);
  attach_colour(gl, plan, target);
  if (plan.has_depth) attach_depth(gl, plan, target);
  check_complete(gl);
  return target;
}

Target opened_layer(const GlTable& gl, const TargetPlan& plan, const Target& other)
{
  Target target = framed(gl);
  gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, other.colour);
  attach_depth(gl, plan, target);
  check_complete(gl);
  return target;
}

void close_target(const GlTable& gl, Target& target)
{
  // Zero names nothing and is ignored.
  gl.DeleteFramebuffers(1, &target.frame);
  gl.DeleteRenderbuffers(1, &target.colour);
  gl.DeleteTextures(1, &target.depth);
  target = {};
}

}  // namespace vrda
