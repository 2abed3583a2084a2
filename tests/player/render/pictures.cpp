#include "pictures.hpp"

#include <cmath>

#include "motion/support/models.hpp"
#include "support/meshes.hpp"

namespace vrda::test {

Codes at(const render::Image& image, int x, int y)
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

scene::Scene dark_scene()
{
  scene::Scene scene;
  scene.background = scene::background_of(scene::Backdrop::black);
  // Uniform ambient light: a surface shows its own colour.
  scene.lighting.sky = scene.lighting.ground = Eigen::Vector3f::Ones();
  scene.lighting.lights.clear();
  return scene;
}

Material plain(const Eigen::Vector3f& colour, float opacity)
{
  return {colour, opacity, 0.0F, 1.0F, 0.0F};
}

void add(scene::Scene& scene, const Mesh& mesh, const Material& material, const Eigen::Vector3d& at_mm)
{
  Body body;
  body.components.push_back({"made by code", "none"});
  body.contact.mesh = mesh;
  body.contact.component.resize(static_cast<std::size_t>(mesh.triangles.rows()), 0);
  scene::Scene made = scene::scene_of(body, {}, {0, 0, 0});
  made.drawables[0].material = material;
  made.drawables[0].X_world_mesh.translation() = at_mm;
  scene.drawables.push_back(made.drawables[0]);
}

/// Looks along -Z of the world from (0, 0, distance).
scene::Camera camera_at(double distance_mm)
{
  scene::Camera camera;
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

render::Image drawn(const scene::Scene& scene, const scene::Camera& camera,
                    const render::RenderOptions& options)
{
  const std::unique_ptr<render::Renderer> renderer = render::make_offscreen_renderer(options);
  renderer->load(scene);
  return renderer->draw(scene, camera);
}

scene::Scene joint_scene()
{
  store::MotionModel model = model_of({});
  add_bodies(model);
  scene::Scene scene = scene::scene_of(model.reference, model.moving, model.rotation_centre_mm);
  scene::place(scene, scene::frames_of(motion::Motion(model, "raw").at({0.4, 0.0})));
  return scene;
}

scene::Camera joint_camera(const scene::Scene& scene)
{
  scene::CameraFit fit(scene::view_rotation(scene::View::oblique, Side::right));
  fit.include(scene::points_within(scene, {}));
  return scene::with_depth_range(fit.camera(), scene);
}

}  // namespace vrda::test
