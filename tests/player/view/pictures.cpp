#include "player/view/pictures.hpp"

#include <cmath>

#include "support/meshes.hpp"
#include "support/models.hpp"

namespace vrda::test {

Codes at(const view::Image& image, int x, int y)
{
  const std::size_t i =
      4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) + static_cast<std::size_t>(x));
  return {image.rgba[i], image.rgba[i + 1], image.rgba[i + 2], image.rgba[i + 3]};
}

// IEC 61966-2-1.
int srgb_code(double linear)
{
  const double value = linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1.0 / 2.4) - 0.055;
  return static_cast<int>(std::lround(255.0 * value));
}

double linear_value(int code)
{
  const double value = code / 255.0;
  return value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
}

view::Scene dark_scene()
{
  view::Scene scene;
  scene.background = view::background_of(view::Backdrop::black);
  // Uniform ambient light: a surface shows its own colour.
  scene.lighting.sky = scene.lighting.ground = Eigen::Vector3f::Ones();
  scene.lighting.lights.clear();
  return scene;
}

Material plain(const Eigen::Vector3f& colour, float opacity)
{
  return {colour, opacity, 0.0F, 1.0F, 0.0F};
}

void add(view::Scene& scene, const Mesh& mesh, const Material& material, const Eigen::Vector3d& at_mm)
{
  Body body;
  body.components.push_back({"made by code", "none"});
  body.contact.mesh = mesh;
  body.contact.component.resize(static_cast<std::size_t>(mesh.triangles.rows()), 0);
  view::Scene made = view::scene_of(body, {}, {0, 0, 0});
  made.drawables[0].structure.clear();  // each sheet and box for itself, with its inner surfaces
  made.drawables[0].material = material;
  made.drawables[0].X_world_mesh.translation() = at_mm;
  scene.drawables.push_back(made.drawables[0]);
}

/// Looks along -Z of the world from (0, 0, distance).
view::Camera camera_at(double distance_mm)
{
  view::Camera camera;
  camera.X_world_camera.translation() = Eigen::Vector3d(0, 0, distance_mm);
  camera.half_height_tangent = 0.25;
  camera.near_mm = 1.0;
  camera.far_mm = 2.0 * distance_mm;
  return camera;
}

Mesh facing_sheet(double size_mm)
{
  Mesh mesh = sheet(size_mm, 2);
  Pose X = Pose::Identity();
  X.linear() = rotation_x(rad_from_deg(90.0));  // +Y to +Z
  return transformed(mesh, X);
}

view::Image drawn(const view::Scene& scene, const view::Camera& camera, const view::RenderOptions& options)
{
  const std::unique_ptr<view::Renderer> renderer = view::make_offscreen_renderer(options);
  renderer->load(scene);
  return renderer->draw(scene, camera);
}

view::Scene joint_scene()
{
  store::MotionModel model = model_of({});
  add_bodies(model);
  view::Scene scene = view::scene_of(model.reference, model.moving, model.rotation_centre_mm);
  view::place(scene, view::frames_of(store::Motion(model, "raw").at({0.4, 0.0})));
  return scene;
}

view::Camera joint_camera(const view::Scene& scene)
{
  view::CameraFit fit(view::view_rotation(view::View::oblique, Side::right));
  fit.include(view::points_within(scene, {}));
  return view::with_depth_range(fit.camera(), scene);
}

}  // namespace vrda::test
