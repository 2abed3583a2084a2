/// What the tests of the renderer draw, and how they look at it.
#pragma once

#include <array>

#include "core/mesh.hpp"
#include "render/renderer.hpp"

namespace vrda::test {

/// Codes of 255: OpenGL allows an error of 0.6 in the conversion to sRGB; blending rounds once more.
inline constexpr int code_tolerance = 2;

using Codes = std::array<int, 4>;
Codes at(const Image& image, int x, int y);

/// IEC 61966-2-1.
int srgb_code(double linear);
double linear_value(int code);

/// Black, lit from everywhere: a surface shows its own colour.
Scene dark_scene();
Material plain(const Eigen::Vector3f& colour, float opacity = 1.0F);
void add(Scene& scene, const Mesh& mesh, const Material& material, const Eigen::Vector3d& at_mm = {0, 0, 0});
/// A square of 2 x 2 cells across the world's Z.
Mesh facing_sheet(double size_mm);

/// Looks along -Z of the world from (0, 0, distance); half the height is a quarter of it.
Camera camera_at(double distance_mm);

/// A ball on a box with a translucent plate between them, and a camera that sees all of it.
Scene joint_scene();
Camera joint_camera(const Scene& scene);

Image drawn(const Scene& scene, const Camera& camera, const RenderOptions& options = {320, 240});

}  // namespace vrda::test
