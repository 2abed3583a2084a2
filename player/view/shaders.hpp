/// Shader sources (GLSL 3.30) without their #version line. Variants are selected by #define, since software
/// rendering executes both sides of a branch at every pixel.
#pragma once

namespace vrda::view {

// Surfaces: N_LIGHTS n, COLOURED (vertex colours), STORED (to fragment lists), VERTEX_LIT (lights at the
// vertices) and at most one of MOTTLED, TEXTURED, FLAT, LINES. lighting_functions precedes both shaders.
extern const char* const lighting_functions;
extern const char* const surface_vertex_shader;
extern const char* const surface_fragment_shader;
/// Discards fragments not in front of the depth in `behind`; MULTISAMPLED compares per sample.
extern const char* const peel_fragment_shader;

/// Blends the fragment lists, at most MOST_LAYERS fragments each; used with background_vertex_shader.
extern const char* const blend_fragment_shader;

extern const char* const background_vertex_shader;
extern const char* const background_fragment_shader;

extern const char *const occlusion_fragment_shader, *const smoothing_fragment_shader,
                                                        *const darkening_fragment_shader;
extern const char* const overlay_vertex_shader;
extern const char* const overlay_fragment_shader;
extern const char* const warp_vertex_shader;
extern const char* const warp_fragment_shader;

}  // namespace vrda::view
