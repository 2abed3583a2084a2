/// OpenGL in memory by OSMesa.
#pragma once

#include <memory>

#include "render/gl_context.hpp"

namespace vrda {

/// Throws InputError when the installed library gives no OpenGL 3.3 core context.
std::unique_ptr<GlContext> make_osmesa_context();

}  // namespace vrda
