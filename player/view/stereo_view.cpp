#include "view/stereo_view.hpp"

#include <algorithm>

namespace vrda::view {
namespace {

/// `box` enlarged to whole pixels.
ShownBox on_whole_pixels(const ShownBox& box)
{
  return {box.low_px.array().floor(), box.high_px.array().ceil()};
}

void append(WarpMesh& all, const WarpMesh& eye, const Viewport& part, int width, int height)
{
  const auto first = static_cast<std::uint32_t>(all.vertices.size());
  for (WarpVertex vertex : eye.vertices) {
    vertex.u =
        (static_cast<float>(part.x) + vertex.u * static_cast<float>(part.width)) / static_cast<float>(width);
    vertex.v = (static_cast<float>(part.y) + vertex.v * static_cast<float>(part.height)) /
               static_cast<float>(height);
    all.vertices.push_back(vertex);
  }
  for (const std::uint32_t k : eye.triangles) all.triangles.push_back(first + k);
}

}  // namespace

Camera camera_of(const Eye& eye, const Pose& X_world_head, const ShownBox& box)
{
  const Eigen::Vector2d size_px = box.high_px - box.low_px;
  const Eigen::Vector2d middle_px = 0.5 * (box.low_px + box.high_px);
  Camera camera;
  camera.X_world_camera = X_world_head;
  camera.X_world_camera.translation() = X_world_head * eye.position_head_mm;
  camera.half_height_tangent = 0.5 * size_px.y() / distance_y_px(eye);
  camera.aspect = size_px.x() / eye.distance_px / (size_px.y() / distance_y_px(eye));
  camera.middle_tangent = {(middle_px.x() - eye.sight_px.x()) / eye.distance_px,
                           (eye.sight_px.y() - middle_px.y()) / distance_y_px(eye)};
  return camera;
}

StereoPlan stereo_plan(const EyePair& eyes, int display_width, int display_height, const std::string& file,
                       const Reflection& reflection)
{
  require_usable(eyes, file);
  StereoPlan plan;
  const std::array<const Eye*, 2> both{&eyes.left, &eyes.right};
  for (std::size_t k = 0; k < both.size(); ++k) {
    plan.boxes[k] = on_whole_pixels(shown_box(*both[k]));
    const Eigen::Vector2i size = (plan.boxes[k].high_px - plan.boxes[k].low_px).cast<int>();
    plan.viewports[k] = {plan.width, 0, size.x(), size.y()};
    plan.width += size.x();
    plan.height = std::max(plan.height, size.y());
  }
  plan.warp.source_width = plan.width;
  plan.warp.source_height = plan.height;
  plan.warp.width = display_width;
  plan.warp.height = display_height;
  for (std::size_t k = 0; k < both.size(); ++k) {
    WarpMesh mesh = warp_mesh(*both[k], plan.boxes[k]);
    for (WarpVertex& vertex : mesh.vertices) {
      const Eigen::Vector2f at = reflected_px(reflection, both[k]->window, {vertex.x_px, vertex.y_px});
      vertex.x_px = at.x();
      vertex.y_px = at.y();
    }
    append(plan.warp.mesh, mesh, plan.viewports[k], plan.width, plan.height);
  }
  return plan;
}

std::array<Shot, 2> shots_of(const StereoPlan& plan, const EyePair& eyes, const Pose& X_world_head,
                             const Scene& scene)
{
  return {
      Shot{with_depth_range(camera_of(eyes.left, X_world_head, plan.boxes[0]), scene), plan.viewports[0]},
      Shot{with_depth_range(camera_of(eyes.right, X_world_head, plan.boxes[1]), scene), plan.viewports[1]}};
}

}  // namespace vrda::view
