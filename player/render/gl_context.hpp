/// Where OpenGL comes from, which alone differs between off-screen and window, and the renderer over it.
#pragma once

#include <memory>

#include "render/renderer.hpp"

namespace vrda {

/// An OpenGL 3.3 core context.
class GlContext {
 public:
  using Function = void (*)();

  virtual ~GlContext() = default;
  /// Makes it the calling thread's context.
  virtual void make_current() = 0;
  /// Address of an OpenGL function, or null.
  virtual Function function(const char* name) = 0;
  /// Whether frame buffer 0 is somewhere to be seen.
  virtual bool has_screen() const { return false; }
};

/// Throws InputError when the installed library gives no OpenGL 3.3 core context.
std::unique_ptr<GlContext> make_osmesa_context();

/// Surfaceless, on the first graphics card, or on the processor where there is none.
/// Throws InputError when the installed library gives no OpenGL 3.3 core context.
std::unique_ptr<GlContext> make_egl_context();

/// Takes the context over. Draws into a frame buffer of its own, never into the context's.
std::unique_ptr<Renderer> make_gl_renderer(std::unique_ptr<GlContext> context, const RenderOptions& options);

}  // namespace vrda
