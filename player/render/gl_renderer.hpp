/// The renderer over any OpenGL context.
#pragma once

#include <memory>

#include "render/gl_context.hpp"
#include "render/renderer.hpp"

namespace vrda {

/// Takes the context over. Draws into a frame buffer of its own, never into the context's.
std::unique_ptr<Renderer> make_gl_renderer(std::unique_ptr<GlContext> context, const RenderOptions& options);

}  // namespace vrda
