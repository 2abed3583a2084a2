/// The programs that run at every vertex and pixel (GLSL 3.30).
#pragma once

namespace vrda {

extern const char* const surface_vertex_shader;
extern const char* const surface_fragment_shader;
extern const char* const background_vertex_shader;
extern const char* const background_fragment_shader;

}  // namespace vrda
