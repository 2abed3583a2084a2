// Layer of the gap along Delta, as colours on the moving object's upward surface.
#include "view/layers.hpp"

#include <algorithm>
#include <cstdint>
#include <utility>

#include "geometry/box_tree.hpp"
#include "view/scene.hpp"

namespace vrda::view {
namespace {

constexpr double range_mm = 6.0;    ///< about the height of a meniscus
constexpr double deepest_mm = 3.0;  ///< largest overlap of a smoothed motion; deeper hits are other surfaces
constexpr double above_mm =
    0.05;  ///< for a knee: far above the resolution of the depth buffer, far below visibility
constexpr double least_upward =
    0.3;  ///< smallest component of a face normal along Delta; steeper faces are omitted
constexpr double fades_from = 0.7;  ///< fraction of the range where the colours start to fade into the bone

Legend gap_legend()
{
  Legend legend;
  legend.title = "gap, mm";
  legend.highest = range_mm;
  legend.palette = gap_palette();
  legend.beyond_label = "no colour";
  return legend;
}

Eigen::Vector3d position_mm(const RenderVertex& vertex)
{
  return {vertex.position_mm[0], vertex.position_mm[1], vertex.position_mm[2]};
}

/// The faces oriented along `delta` and their vertices, with the normals of the whole mesh, so that the
/// shading matches the surface below.
RenderMesh upward_part(const RenderMesh& whole, const Eigen::Vector3d& delta)
{
  constexpr std::uint32_t unused = UINT32_MAX;
  RenderMesh part;
  std::vector<std::uint32_t> row(whole.vertices.size(), unused);
  for (std::size_t t = 0; t < whole.triangles.size(); t += 3) {
    const std::uint32_t* corner = &whole.triangles[t];
    const Eigen::Vector3d a = position_mm(whole.vertices[corner[0]]);
    const Eigen::Vector3d area =
        (position_mm(whole.vertices[corner[1]]) - a).cross(position_mm(whole.vertices[corner[2]]) - a);
    if (!(area.dot(delta) > least_upward * area.norm())) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      std::uint32_t& own = row[corner[k]];
      if (own == unused) {
        own = static_cast<std::uint32_t>(part.vertices.size());
        part.vertices.push_back(whole.vertices[corner[k]]);
      }
      part.triangles.push_back(own);
    }
  }
  return part;
}

}  // namespace

GapLayer::GapLayer(const store::MotionModel& model, Scene& scene)
    : legend_(gap_legend()), reference_(model.reference.contact.mesh), tree_(reference_)
{
  for (std::size_t c = 0; c < model.moving.components.size(); ++c) add_sheet(model, scene, c);
}

void GapLayer::add_sheet(const store::MotionModel& model, Scene& scene, std::size_t component)
{
  const Part& contact = model.moving.contact;
  const RenderMesh whole =
      make_render_mesh(contact.mesh, triangles_by_component(model.moving, contact)[component],
                       model.rotation_centre_mm, crease_rad_of(model.moving.components[component].material));
  RenderMesh upward = upward_part(whole, model.delta);
  if (upward.triangles.empty()) return;
  const Component& part = model.moving.components[component];
  Sheet sheet;
  sheet.drawable = add_layer(scene, Layer::gap_map, ParentFrame::moving, "gaps on " + part.name);
  Drawable& drawable = scene.drawables[sheet.drawable];
  drawable.origin_mm = model.rotation_centre_mm;
  drawable.mesh = std::move(upward);
  drawable.material = material_of(part.material);
  drawable.material.mottling = 0.0F;
  sheet.bone = srgb_from_linear(drawable.material.colour);
  const auto lift_mm = static_cast<float>(above_mm * marker_scale(model));
  for (RenderVertex& vertex : drawable.mesh.vertices) {
    sheet.point_mm.push_back(position_mm(vertex) + drawable.origin_mm);
    for (std::size_t k = 0; k < 3; ++k) vertex.position_mm[k] += lift_mm * vertex.normal[k];
  }
  update_box(drawable);
  drawable.colours.assign(drawable.mesh.vertices.size(), sheet.bone);
  sheet.gap_mm.resize(sheet.point_mm.size());
  sheet.triangles = drawable.mesh.triangles;
  sheets_.push_back(std::move(sheet));
}

void GapLayer::update_sheet(Drawable& drawable, Sheet& sheet, const Eigen::Vector3d& delta_moving) const
{
  // The rays are transformed to the reference's frame, so that its tree stays valid.
  geometry::Ray ray;
  ray.direction = X_reference_moving_.linear() * delta_moving;
  ray.max_length_mm = deepest_mm + range_mm;
  for (std::size_t v = 0; v < sheet.point_mm.size(); ++v) {
    ray.from_mm = X_reference_moving_ * sheet.point_mm[v] - deepest_mm * ray.direction;
    const double gap_mm = geometry::ray_distance_mm(reference_, tree_, ray) - deepest_mm;
    sheet.gap_mm[v] = gap_mm;
    const double fading = (gap_mm / range_mm - fades_from) / (1.0 - fades_from);
    drawable.colours[v] = interpolated_colour(colour_of(legend_, std::min(gap_mm, range_mm)), sheet.bone,
                                              std::clamp(fading, 0.0, 1.0));
  }
  auto next = drawable.mesh.triangles.begin();
  for (std::size_t t = 0; t < sheet.triangles.size(); t += 3) {
    const auto corner = sheet.triangles.begin() + static_cast<std::ptrdiff_t>(t);
    const bool is_near =
        std::any_of(corner, corner + 3, [&](std::uint32_t v) { return sheet.gap_mm[v] < range_mm; });
    if (is_near) next = std::copy(corner, corner + 3, next);
  }
  sheet.is_near = next != drawable.mesh.triangles.begin();
  // The number of triangles is constant: unused ones are degenerate.
  std::fill(next, drawable.mesh.triangles.end(), 0U);
}

void GapLayer::update(Scene& scene, const store::Motion& motion, const store::JointPose& pose)
{
  const bool is_same = is_made_ && X_reference_moving_.matrix() == pose.X_reference_moving.matrix();
  X_reference_moving_ = pose.X_reference_moving;
  is_made_ = true;
  // Theta rotates about Delta, so Delta has the same coordinates in the moving object.
  const Eigen::Vector3d delta_moving = motion.delta_of(pose);
  for (Sheet& sheet : sheets_) {
    Drawable& drawable = scene.drawables[sheet.drawable];
    if (!is_same) {
      update_sheet(drawable, sheet, delta_moving);
      ++drawable.revision;
    }
    drawable.is_shown = sheet.is_near;
  }
}

}  // namespace vrda::view
