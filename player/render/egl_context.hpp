/// OpenGL without a display by EGL.
#pragma once

#include <memory>

#include "render/gl_context.hpp"

namespace vrda {

/// Surfaceless, on the first graphics card, or on the processor where there is none.
/// Throws InputError when the installed library gives no OpenGL 3.3 core context.
std::unique_ptr<GlContext> make_egl_context();

}  // namespace vrda
