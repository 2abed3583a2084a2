#include "scene/layer_drawable.hpp"

#include <algorithm>

#include "core/step_status.hpp"
#include "scene/palette.hpp"

namespace vrda {

double sign_scale(const MotionModel& model)
{
  constexpr double width_of_knee_mm = 80.0;
  const Box box = bounding_box(model.moving.contact.mesh);
  const Eigen::Vector3d size_mm = box.max_mm - box.min_mm;
  const double width_mm = std::max(size_mm.x(), size_mm.z());
  return width_mm > 0.0 ? width_mm / width_of_knee_mm : 1.0;
}

std::vector<std::size_t> telling_cells(const MotionModel& model)
{
  std::vector<std::size_t> spine, all;
  for (Eigen::Index cell = 0; cell < model.status.size(); ++cell) {
    if (model.status.data()[cell] != status_stable) continue;
    all.push_back(static_cast<std::size_t>(cell));
    if (model.is_spine.size() > 0 && model.is_spine.data()[cell] == 1)
      spine.push_back(static_cast<std::size_t>(cell));
  }
  return spine.empty() ? all : spine;
}

std::size_t add_layer(Scene& scene, Layer layer, Owner owner, const std::string& name)
{
  Drawable drawable;
  drawable.name = name;
  drawable.layer = layer;
  drawable.owner = owner;
  drawable.is_shown = false;
  drawable.has_contact = false;
  scene.drawables.push_back(std::move(drawable));
  return scene.drawables.size() - 1;
}

Material sign_material(const VertexColour& colour)
{
  return {decoded(colour), 1.0F, 0.18F, 40.0F, 0.0F};
}

void update_box(Drawable& drawable)
{
  drawable.box_mm = {};
  bool is_first = true;
  for (const std::uint32_t index : drawable.mesh.triangles) {
    const std::array<float, 3>& p = drawable.mesh.vertices[index].position_mm;
    const Eigen::Vector3d p_mm(p[0], p[1], p[2]);
    drawable.box_mm.min_mm = is_first ? p_mm : Eigen::Vector3d(drawable.box_mm.min_mm.cwiseMin(p_mm));
    drawable.box_mm.max_mm = is_first ? p_mm : Eigen::Vector3d(drawable.box_mm.max_mm.cwiseMax(p_mm));
    is_first = false;
  }
}

}  // namespace vrda
