/// Scenes and cameras for the tests of the renderer.
#pragma once

#include <array>

#include "model/mesh.hpp"
#include "view/renderer.hpp"

namespace vrda::test {

/// In codes of 255: OpenGL allows an error of 0.6 in the conversion to sRGB; blending rounds again.
inline constexpr int code_tolerance = 2;

using Codes = std::array<int, 4>;
Codes at(const view::Image& image, int x, int y);

/// IEC 61966-2-1.
int srgb_code(double linear);
double linear_value(int code);

/// Black background and uniform ambient light: a surface shows its own colour.
view::Scene dark_scene();
Material plain(const Eigen::Vector3f& colour, float opacity = 1.0F);
void add(view::Scene& scene, const Mesh& mesh, const Material& material,
         const Eigen::Vector3d& at_mm = {0, 0, 0});
/// A square of 2 x 2 cells normal to world Z.
Mesh facing_sheet(double size_mm);

/// A camera at (0, 0, distance) that looks along world -Z; half the image height is a quarter of the
/// distance.
view::Camera camera_at(double distance_mm);

/// A ball on a box with a translucent plate between them, and a camera that sees all of it.
view::Scene joint_scene();
view::Camera joint_camera(const view::Scene& scene);

view::Image drawn(const view::Scene& scene, const view::Camera& camera,
                  const view::RenderOptions& options = {320, 240});

}  // namespace vrda::test
