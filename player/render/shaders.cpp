#include "render/shaders.hpp"

namespace vrda {

const char* const surface_vertex_shader = R"(#version 330 core
layout(location = 0) in vec3 p_mesh;
layout(location = 1) in vec3 n_mesh;
uniform mat4 X_camera_mesh;
uniform mat4 projection;
out vec3 p_surface;  // mesh, mm: the mottling moves with the bone
out vec3 p_camera;
out vec3 n_camera;
void main()
{
  vec4 p = X_camera_mesh * vec4(p_mesh, 1.0);
  p_surface = p_mesh;
  p_camera = p.xyz;
  n_camera = mat3(X_camera_mesh) * n_mesh;
  gl_Position = projection * p;
}
)";

// Everything in linear light; the frame buffer encodes as sRGB.
const char* const surface_fragment_shader = R"(#version 330 core
in vec3 p_surface;
in vec3 p_camera;
in vec3 n_camera;
uniform vec3 colour;
uniform float opacity;
uniform float specular;
uniform float shininess;
uniform float mottling;
uniform vec3 up_camera;
uniform vec3 sky;
uniform vec3 ground;
uniform int n_lights;
uniform vec3 light_direction[4];
uniform vec3 light_colour[4];
out vec4 pixel;

// An integer hash (Jarzynski and Olano 2020, pcg3d) of a lattice point, on [0, 1].
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

// About zero; patches of 11 mm and grain of 2 mm.
float mottle(vec3 p_mm)
{
  return 1.2 * (value_noise(p_mm * 0.09) - 0.5) + 0.5 * (value_noise(p_mm * 0.5 + 17.0) - 0.5);
}

void main()
{
  vec3 n = normalize(n_camera);
  if (!gl_FrontFacing) n = -n;
  vec3 to_eye = normalize(-p_camera);
  vec3 diffuse = mix(ground, sky, 0.5 + 0.5 * dot(n, up_camera));
  vec3 shine = vec3(0.0);
  for (int i = 0; i < n_lights; ++i) {
    float facing = dot(n, light_direction[i]);
    if (facing <= 0.0) continue;
    diffuse += facing * light_colour[i];
    vec3 half_way = normalize(light_direction[i] + to_eye);
    shine += light_colour[i] * pow(max(dot(n, half_way), 0.0), shininess);
  }
  vec3 base = colour;
  if (mottling > 0.0) {
    // Darker patches are warmer: blue falls more than red.
    base *= vec3(1.0) + mottling * mottle(p_surface) * vec3(0.8, 1.1, 1.6);
  }
  pixel = vec4(base * diffuse + specular * shine, opacity);
}
)";

const char* const background_vertex_shader = R"(#version 330 core
out float height;
void main()
{
  // One triangle over the whole picture.
  vec2 p = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
  height = 0.5 + 0.5 * p.y;
  gl_Position = vec4(p, 0.0, 1.0);
}
)";

const char* const background_fragment_shader = R"(#version 330 core
in float height;
uniform vec3 top;
uniform vec3 bottom;
out vec4 pixel;
void main() { pixel = vec4(mix(bottom, top, height), 1.0); }
)";

}  // namespace vrda
