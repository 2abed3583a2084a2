#include "view/shaders.hpp"

namespace vrda::view {

// Hemisphere, diffuse and specular light of a point with unit normal `n`, camera axes.
const char* const lighting_functions = R"(
uniform vec3 up_camera;
uniform vec3 sky;
uniform vec3 ground;
uniform float shininess;
#if N_LIGHTS > 0
uniform vec3 light_direction[N_LIGHTS];
uniform vec3 light_colour[N_LIGHTS];
#endif
void add_light(vec3 n, vec3 to_eye, out vec3 diffuse, out vec3 shine)
{
  diffuse = mix(ground, sky, 0.5 + 0.5 * dot(n, up_camera));
  shine = vec3(0.0);
#if N_LIGHTS > 0
  for (int i = 0; i < N_LIGHTS; ++i) {
    float facing = dot(n, light_direction[i]);
    vec3 half_way = normalize(light_direction[i] + to_eye);
    float glint = facing > 0.0 ? pow(max(dot(n, half_way), 0.0), shininess) : 0.0;
    diffuse += max(facing, 0.0) * light_colour[i];
    shine += glint * light_colour[i];
  }
#endif
}
)";

// `invariant`: passes over the same triangles give bitwise equal depths.
const char* const surface_vertex_shader = R"(
layout(location = 0) in vec3 p_mesh;
layout(location = 1) in vec3 n_mesh;
uniform mat4 X_camera_mesh;
uniform mat4 projection;
uniform float depth_offset_mm;
uniform vec3 section_normal;  // camera axes, towards what is removed
uniform float section_at_mm;
invariant gl_Position;
out float gl_ClipDistance[1];
out vec3 p_surface;  // mesh frame, mm: the pattern moves with the bone
out vec3 n_surface;
out vec3 p_camera;
out vec3 n_camera;
#ifdef VERTEX_LIT
out vec3 diffuse;
out vec3 shine;
#endif
#ifdef COLOURED
layout(location = 2) in vec4 colour_srgb;
out vec4 tint;
vec3 linear(vec3 c) { return mix(c / 12.92, pow((c + 0.055) / 1.055, vec3(2.4)), step(0.04045, c)); }
#endif
void main()
{
  vec4 p = X_camera_mesh * vec4(p_mesh, 1.0);
  gl_ClipDistance[0] = section_at_mm - dot(section_normal, p.xyz);
  p_surface = p_mesh;
  n_surface = n_mesh;
  p_camera = p.xyz;
  n_camera = mat3(X_camera_mesh) * n_mesh;
#ifdef VERTEX_LIT
  add_light(normalize(n_camera), normalize(-p_camera), diffuse, shine);
#endif
#ifdef COLOURED
  tint = vec4(linear(colour_srgb.rgb), colour_srgb.a);
#endif
  gl_Position = projection * p;
  if (depth_offset_mm > 0.0) {
    vec4 behind = projection * vec4(p.xy, p.z - depth_offset_mm, 1.0);
    gl_Position.z = behind.z / behind.w * gl_Position.w;
  }
}
)";

// Linear light; the frame buffer encodes as sRGB.
const char* const surface_fragment_shader = R"(
in vec3 p_surface;
in vec3 n_surface;
in vec3 p_camera;
in vec3 n_camera;
uniform vec3 colour;
uniform float opacity;
uniform float specular;
uniform float mottling;
uniform float highlight;
uniform float unlit;
#ifdef VERTEX_LIT
in vec3 diffuse;
in vec3 shine;
#endif
#ifdef STORED
uniform sampler2D front;
uniform float behind_front;
// Fragment lists (gl_renderer.cpp): heads is the last node of each pixel; a node holds its predecessor.
layout(early_fragment_tests) in;
layout(std430, binding = 0) buffer Heads { uint heads[]; };
layout(std430, binding = 1) buffer Nodes { uvec4 nodes[]; };
layout(std430, binding = 2) buffer Count { uint n_nodes; uint width; };
void give(vec4 c)
{
  if (gl_FragCoord.z > texelFetch(front, ivec2(gl_FragCoord.xy), 0).r + behind_front) return;
  uint node = atomicAdd(n_nodes, 1u);
  if (node >= uint(nodes.length())) return;
  uint at = uint(gl_FragCoord.y) * width + uint(gl_FragCoord.x);
  uint before = atomicExchange(heads[at], node);
  nodes[node] = uvec4(before, floatBitsToUint(gl_FragCoord.z), packUnorm2x16(c.rg), packUnorm2x16(c.ba));
}
#else
out vec4 pixel;
void give(vec4 c) { pixel = c; }
#endif
#ifdef COLOURED
in vec4 tint;
#endif

#ifdef MOTTLED
// Integer hash (Jarzynski and Olano 2020, pcg3d) of a lattice point, on [0, 1].
float lattice(ivec3 cell)
{
  uvec3 v = uvec3(cell) * 1664525u + 1013904223u;
  v.x += v.y * v.z; v.y += v.z * v.x; v.z += v.x * v.y;
  v ^= v >> 16u;
  v.x += v.y * v.z;
  return float(v.x >> 8u) * (1.0 / 16777216.0);
}

float value_noise(vec3 p)
{
  vec3 whole = floor(p), s = p - whole;
  ivec3 c = ivec3(whole);
  s = s * s * (3.0 - 2.0 * s);
  vec4 x0 = vec4(lattice(c), lattice(c + ivec3(0, 1, 0)), lattice(c + ivec3(0, 0, 1)), lattice(c + ivec3(0, 1, 1)));
  vec4 x1 = vec4(lattice(c + ivec3(1, 0, 0)), lattice(c + ivec3(1, 1, 0)), lattice(c + ivec3(1, 0, 1)),
                 lattice(c + ivec3(1, 1, 1)));
  vec4 x = mix(x0, x1, s.x);
  vec2 y = mix(x.xz, x.yw, s.y);
  return mix(y.x, y.y, s.z);
}

// Mean zero; patches of 11 mm and grain of 2 mm.
float mottle(vec3 p_mm)
{
  return 1.2 * (value_noise(p_mm * 0.09) - 0.5) + 0.5 * (value_noise(p_mm * 0.5 + 17.0) - 0.5);
}
#endif

#ifdef TEXTURED
uniform sampler2D image;
uniform float repeats_by_mm;
vec3 triplanar()
{
  vec3 p = p_surface * repeats_by_mm;
  vec3 weight = n_surface * n_surface;
  weight *= weight;
  weight /= weight.x + weight.y + weight.z;
  return weight.x * texture(image, p.zy).rgb + weight.y * texture(image, p.xz).rgb + weight.z * texture(image, p.xy).rgb;
}
#endif

vec4 base()
{
#ifdef COLOURED
  return vec4(tint.rgb, tint.a * opacity);
#elif defined(TEXTURED)
  return vec4(triplanar(), opacity);
#elif defined(MOTTLED)
  // Darker patches are warmer: blue falls more than red.
  return vec4(colour * (vec3(1.0) + mottling * mottle(p_surface) * vec3(0.8, 1.1, 1.6)), opacity);
#else
  return vec4(colour, opacity);
#endif
}

void main()
{
#ifdef LINES
  give(vec4(base().rgb, 1.0));
#else
#ifndef VERTEX_LIT
#ifdef FLAT
  // Face normal and a constant view direction give one shade per triangle.
  vec3 n = normalize(cross(dFdx(p_camera), dFdy(p_camera)));
  vec3 to_eye = vec3(0.0, 0.0, 1.0);
#else
  vec3 n = normalize(n_camera);
  if (!gl_FrontFacing) n = -n;
  vec3 to_eye = normalize(-p_camera);
#endif
  vec3 diffuse, shine;
  add_light(n, to_eye, diffuse, shine);
#endif
  vec4 own = base();
  vec3 lit = own.rgb * diffuse + specular * shine;
  lit = mix(lit, 0.8 * own.rgb, unlit);
  if (highlight > 0.0) {
    float aside = 1.0 - abs(dot(normalize(n_camera), normalize(p_camera)));
    lit += highlight * vec3(0.0, 0.35, 0.6) * (0.25 + aside * aside);
  }
  give(vec4(lit, own.a));
#endif
}
)";

const char* const peel_fragment_shader = R"(
#ifdef MULTISAMPLED
#extension GL_ARB_sample_shading : enable
#endif
#ifdef FRONT
void main() {}
#else
uniform float behind_front;
#ifdef MULTISAMPLED
uniform sampler2DMS behind, front;
#ifdef GL_ARB_sample_shading
#define SAMPLE gl_SampleID
#else
#define SAMPLE 0
#endif
#else
uniform sampler2D behind, front;
#define SAMPLE 0
#endif
void main()
{
  ivec2 at = ivec2(gl_FragCoord.xy);
  float z = gl_FragCoord.z;
  if (z >= texelFetch(behind, at, SAMPLE).r || z > texelFetch(front, at, SAMPLE).r + behind_front) discard;
}
#endif
)";

// Back to front; at equal depth in drawing order. Clears the lists.
const char* const blend_fragment_shader = R"(
layout(std430, binding = 0) buffer Heads { uint heads[]; };
layout(std430, binding = 1) readonly buffer Nodes { uvec4 nodes[]; };
layout(std430, binding = 2) readonly buffer Count { uint n_nodes; uint width; };
out vec4 pixel;
void main()
{
  uint at = uint(gl_FragCoord.y) * width + uint(gl_FragCoord.x);
  uint head = heads[at];
  if (head == 0u) discard;
  heads[at] = 0u;
  vec4 sum = vec4(0.0, 0.0, 0.0, 1.0);
  uint last_depth = 0xffffffffu, last = 0u;
  for (int layer = 0; layer < MOST_LAYERS; ++layer) {
    uint found = 0u;
    uvec4 best = uvec4(0u);
    for (uint i = head; i != 0u;) {
      uvec4 node = nodes[i];
      bool is_next = node.y < last_depth || (node.y == last_depth && i > last);
      bool is_better = found == 0u || node.y > best.y || (node.y == best.y && i < found);
      if (is_next && is_better) { found = i; best = node; }
      i = node.x;
    }
    if (found == 0u) break;
    vec4 c = vec4(unpackUnorm2x16(best.z), unpackUnorm2x16(best.w));
    sum = vec4(mix(sum.rgb, c.rgb, c.a), sum.a * (1.0 - c.a));
    last_depth = best.y;
    last = found;
  }
  pixel = sum;
}
)";

const char* const background_vertex_shader = R"(
out float height;
void main()
{
  // One triangle that covers the viewport.
  vec2 p = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
  height = 0.5 + 0.5 * p.y;
  gl_Position = vec4(p, 0.0, 1.0);
}
)";

const char* const background_fragment_shader = R"(
in float height;
uniform vec3 top;
uniform vec3 bottom;
out vec4 pixel;
void main() { pixel = vec4(mix(bottom, top, height), 1.0); }
)";

// The part of the light that arrives, and the depth in mm, at every second pixel. Lengths in units of the
// radius.
const char* const occlusion_fragment_shader = R"(
uniform sampler2D source;  // depth
uniform mat4 projection;
uniform vec2 corner_px;
uniform vec2 size_px;
uniform float radius_mm;
out vec4 pixel;
const int N_TAPS = 14;
const float TURNS = 5.0;
vec3 point(vec2 px)
{
  vec2 at = clamp(floor(px), corner_px, corner_px + size_px - 1.0);
  float z_device = 2.0 * texelFetch(source, ivec2(at), 0).r - 1.0;
  float depth = projection[3][2] / (z_device + projection[2][2]);
  vec2 device = (at + 0.5 - corner_px) / size_px * 2.0 - 1.0;
  vec2 tangent = (device + projection[2].xy) / vec2(projection[0][0], projection[1][1]);
  return vec3(tangent * depth, -depth);
}
vec3 nearer(vec3 a, vec3 b) { return abs(a.z) < abs(b.z) ? a : b; }
void main()
{
  vec2 px = 2.0 * floor(gl_FragCoord.xy) + 0.5;
  vec3 p = point(px);
  float depth = -p.z;
  if (texelFetch(source, ivec2(clamp(px, corner_px, corner_px + size_px - 1.0)), 0).r == 1.0) {
    pixel = vec4(1.0, 60000.0, 0.0, 1.0);
    return;
  }
  vec3 right = nearer(point(px + vec2(1, 0)) - p, p - point(px - vec2(1, 0)));
  vec3 up = nearer(point(px + vec2(0, 1)) - p, p - point(px - vec2(0, 1)));
  vec3 n = normalize(cross(right, up));
  float radius_px = 0.5 * radius_mm * projection[1][1] * size_px.y / depth;
  // A pattern of 4 by 4 directions, which the smoothing averages.
  ivec2 cell = ivec2(gl_FragCoord.xy) & 3;
  float turn = float((5 * cell.x + 7 * cell.y + 2 * cell.x * cell.y) & 15) * (6.2831853 / 16.0);
  float sum = 0.0;
  vec2 direction = vec2(cos(turn), sin(turn));
  for (int i = 0; i < N_TAPS; ++i) {
    float part = (float(i) + 0.5) / float(N_TAPS);
    float angle = part * TURNS * 6.2831853;  // constant: its cosine takes no time
    vec2 by = vec2(cos(angle) * direction.x - sin(angle) * direction.y,
                   cos(angle) * direction.y + sin(angle) * direction.x);
    vec3 v = (point(px + part * radius_px * by) - p) / radius_mm;
    float distance_sq = dot(v, v);
    float near = max(1.0 - distance_sq, 0.0);
    sum += near * near * near * max((dot(v, n) - 0.02) / (distance_sq + 0.01), 0.0);
  }
  pixel = vec4(max(0.0, 1.0 - sum * 3.0 / float(N_TAPS)), depth, 0.0, 1.0);
}
)";

const char* const smoothing_fragment_shader = R"(
uniform sampler2D source;
uniform vec2 corner_px;
uniform vec2 size_px;
uniform float radius_mm;
out vec4 pixel;
void main()
{
  ivec2 at = ivec2(gl_FragCoord.xy), first = ivec2(corner_px) / 2, last = ivec2(corner_px + size_px - 1.0) / 2;
  vec2 own = texelFetch(source, at, 0).rg;
  float sum = 0.0, weights = 0.0;
  for (int y = -2; y < 2; ++y) {
    for (int x = -2; x < 2; ++x) {
      vec2 other = texelFetch(source, clamp(at + ivec2(x, y), first, last), 0).rg;
      float weight = max(1.0 - 4.0 * abs(other.g - own.g) / radius_mm, 0.0);
      sum += weight * other.r;
      weights += weight;
    }
  }
  pixel = vec4(sum / weights, own.g, 0.0, 1.0);
}
)";

// Multiplied into the picture.
const char* const darkening_fragment_shader = R"(
uniform sampler2D source;
uniform vec2 corner_px;
uniform vec2 size_px;
uniform float radius_mm;
out vec4 pixel;
void main()
{
  // Pixel 2 k has the value k, pixel 2 k + 1 is between two values: of the nearer surface, if they differ.
  ivec2 a = ivec2(gl_FragCoord.xy) / 2,
        b = min((ivec2(gl_FragCoord.xy) + 1) / 2, ivec2(corner_px + size_px - 1.0) / 2);
  vec2 four[4] = vec2[](texelFetch(source, a, 0).rg, texelFetch(source, ivec2(b.x, a.y), 0).rg,
                        texelFetch(source, ivec2(a.x, b.y), 0).rg, texelFetch(source, b, 0).rg);
  float nearest = min(min(four[0].g, four[1].g), min(four[2].g, four[3].g));
  float sum = 0.0, weights = 0.0;
  for (int i = 0; i < 4; ++i) {
    float weight = max(1.0 - abs(four[i].g - nearest) / radius_mm, 0.0);
    sum += weight * four[i].r;
    weights += weight;
  }
  pixel = vec4(vec3(sum / weights), 1.0);
}
)";

const char* const overlay_vertex_shader = R"(
layout(location = 0) in vec2 p_px;
layout(location = 1) in vec2 p_font;
layout(location = 2) in vec4 colour_srgb;
uniform vec2 size_px;
out vec2 at;
out vec4 tint;
vec3 linear(vec3 c) { return mix(c / 12.92, pow((c + 0.055) / 1.055, vec3(2.4)), step(0.04045, c)); }
void main()
{
  at = p_font;
  tint = vec4(linear(colour_srgb.rgb), colour_srgb.a);
  gl_Position = vec4(2.0 * p_px.x / size_px.x - 1.0, 1.0 - 2.0 * p_px.y / size_px.y, 0.0, 1.0);
}
)";

const char* const overlay_fragment_shader = R"(
in vec2 at;
in vec4 tint;
uniform sampler2D font;
out vec4 pixel;
void main() { pixel = vec4(tint.rgb, tint.a * texture(font, at).r); }
)";

const char* const warp_vertex_shader = R"(
layout(location = 0) in vec2 p_px;
layout(location = 1) in vec2 p_picture;
uniform vec2 size_px;
out vec2 at;
void main()
{
  at = vec2(p_picture.x, 1.0 - p_picture.y);
  gl_Position = vec4(2.0 * p_px.x / size_px.x - 1.0, 1.0 - 2.0 * p_px.y / size_px.y, 0.0, 1.0);
}
)";

const char* const warp_fragment_shader = R"(
in vec2 at;
uniform sampler2D picture;
out vec4 pixel;
void main() { pixel = texture(picture, at); }
)";

}  // namespace vrda::view
