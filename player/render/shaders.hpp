/// The programs that run at every vertex and pixel (GLSL 3.30), without their #version line.
/// A variant is chosen by #define: on a processor a branch not taken is paid for at every pixel.
#pragma once

namespace vrda {

// Surfaces: N_LIGHTS n, COLOURED (a colour a vertex), STORED (into lists of fragments) and one of MOTTLED,
// TEXTURED, FLAT, LINES or none.
extern const char* const surface_vertex_shader;
extern const char* const surface_fragment_shader;
/// Drops what does not lie before the depth in `behind`; MULTISAMPLED compares sample by sample.
extern const char* const peel_fragment_shader;

/// Blends the lists of fragments, at most MOST_LAYERS of each; over the whole picture, as the background.
extern const char* const blend_fragment_shader;

extern const char* const background_vertex_shader;
extern const char* const background_fragment_shader;

extern const char* const overlay_vertex_shader;
extern const char* const overlay_fragment_shader;
extern const char* const warp_vertex_shader;
extern const char* const warp_fragment_shader;

}  // namespace vrda
