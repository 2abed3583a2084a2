/// OpenGL contexts for off-screen and window rendering, and the renderer that uses them.
#pragma once

#include <memory>

#include "view/renderer.hpp"

namespace vrda::view {

/// An OpenGL 3.3 core context.
class GlContext {
 public:
  using Function = void (*)();

  virtual ~GlContext() = default;
  /// Makes the context current in the calling thread.
  virtual void make_current() = 0;
  /// Address of an OpenGL function, or null.
  virtual Function function(const char* name) = 0;
  /// True if frame buffer 0 is displayed.
  virtual bool has_screen() const { return false; }
};

/// Throws InputError if the installed library does not support OpenGL 3.3 core.
std::unique_ptr<GlContext> make_osmesa_context();

/// Surfaceless, on the first graphics card, or in software if none exists.
/// Throws InputError if the installed library does not support OpenGL 3.3 core.
std::unique_ptr<GlContext> make_egl_context();

/// Takes ownership of the context. Renders to its own frame buffer, not to the context's.
std::unique_ptr<Renderer> make_gl_renderer(std::unique_ptr<GlContext> context, const RenderOptions& options);

}  // namespace vrda::view
