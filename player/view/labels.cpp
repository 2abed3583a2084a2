#include "view/labels.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "core/text.hpp"
#include "model/ligaments.hpp"
#include "store/motion.hpp"
#include "view/gl_mesh.hpp"

namespace vrda::view {
namespace {

constexpr std::size_t n_points = 40;  // a label; enough for the visible parts of a bone
/// A point is behind a body if that is nearer by more: several times the distance of a level of detail, and
/// half the thickness of a band of fibres.
constexpr double behind_mm = 1.0;
/// Of the moving body's contact part: the outer part of its width, and its upper edge, on a knee.
constexpr double outer_part = 0.2, edge_mm = 14.0;

Eigen::Vector3d vertex_mm(const Drawable& drawable, std::uint32_t vertex)
{
  const std::array<float, 3>& p = drawable.mesh.vertices[vertex].position_mm;
  return {p[0], p[1], p[2]};
}

/// Times that a ray enters a solid.
int n_entries(const Mesh& mesh, const geometry::BoxTree& tree, geometry::Ray ray)
{
  constexpr double beyond_mm = 1e-6;
  int n = 0;
  while (true) {
    const double mm = geometry::ray_distance_mm(mesh, tree, ray) + beyond_mm;
    if (!(mm < ray.max_length_mm)) return n;
    ++n;
    ray.from_mm += mm * ray.direction;
    ray.max_length_mm -= mm;
  }
}

bool starts_inside(const Mesh& mesh, const geometry::BoxTree& tree, geometry::Ray ray)
{
  ray.max_length_mm = 1000.0;  // beyond any bone
  geometry::Ray back = ray;
  back.from_mm += ray.max_length_mm * ray.direction;
  back.direction = -ray.direction;
  return n_entries(mesh, tree, back) > n_entries(mesh, tree, ray);
}

/// At most `n_points` of all.
std::vector<std::pair<std::size_t, std::uint32_t>> thinned(
    std::vector<std::pair<std::size_t, std::uint32_t>> all)
{
  if (all.size() <= n_points) return all;
  for (std::size_t k = 0; k < n_points; ++k) all[k] = all[k * all.size() / n_points];
  all.resize(n_points);
  return all;
}

}  // namespace

LabelAnchors::LabelAnchors(const store::MotionModel& model, const Scene& scene)
{
  const Box box = bounding_box(model.moving.contact.mesh);
  const double lateral = side_named(model.side) == Side::right ? 1.0 : -1.0;
  const double middle_mm = 0.5 * (box.min_mm + box.max_mm).z(), half_mm = 0.5 * (box.max_mm - box.min_mm).z();
  for (const store::JointLabel& label : store::joint_labels(model)) {
    const double side = !model.has_compartments   ? 0.0
                        : label.text == "medial"  ? -lateral
                        : label.text == "lateral" ? lateral
                                                  : 0.0;
    const bool is_ligament = label.first != label.second;
    Points all;
    for (std::size_t k = 0; k < scene.drawables.size(); ++k) {
      const Drawable& drawable = scene.drawables[k];
      if (is_ligament) {
        const std::string bundle = drawable.structure.substr(drawable.structure.rfind('/') + 1);
        if (drawable.layer != Layer::ligaments || model::ligament_of(bundle) != label.text) continue;
      } else if (drawable.layer != Layer::bodies || drawable.parent != label.first) {
        continue;
      }
      for (std::uint32_t v = 0; v < drawable.mesh.vertices.size(); ++v) {
        const Eigen::Vector3d p_mm = vertex_mm(drawable, v) + drawable.origin_mm;
        const bool is_at_side = side * (p_mm.z() - middle_mm) > (1.0 - outer_part) * half_mm &&
                                p_mm.y() > box.max_mm.y() - edge_mm * store::width_ratio(model.moving);
        if (side == 0.0 || is_at_side) all.emplace_back(k, v);
      }
    }
    texts_.push_back(label.text);
    points_.push_back(thinned(std::move(all)));
  }
}

void LabelAnchors::find_surfaces(const Scene& scene)
{
  for (std::size_t k = 0; k < scene.drawables.size(); ++k) {
    const Drawable& body = scene.drawables[k];
    if (body.layer != Layer::bodies || body.mesh.triangles.empty()) continue;
    Mesh mesh;
    mesh.vertices_mm.resize(static_cast<Eigen::Index>(body.mesh.vertices.size()), 3);
    for (std::uint32_t v = 0; v < body.mesh.vertices.size(); ++v)
      mesh.vertices_mm.row(v) = vertex_mm(body, v).transpose();
    mesh.triangles.resize(static_cast<Eigen::Index>(body.mesh.triangles.size() / 3), 3);
    for (std::size_t i = 0; i < body.mesh.triangles.size(); ++i)
      mesh.triangles(static_cast<Eigen::Index>(i / 3), static_cast<Eigen::Index>(i % 3)) =
          static_cast<int>(body.mesh.triangles[i]);
    const geometry::BoxTree tree(mesh);
    surfaces_.push_back({std::move(mesh), tree, k, is_closed(body.mesh)});
  }
}

bool LabelAnchors::is_visible(const Scene& scene, const Drawable& own, const Eigen::Vector3d& p_mm,
                              const Eigen::Vector3d& eye_mm) const
{
  if (scene.section && is_removed(*scene.section, p_mm, eye_mm)) return false;
  const Eigen::Vector3d direction = (p_mm - eye_mm).normalized();
  Eigen::Vector3d from_mm = eye_mm;
  if (scene.section) {
    const SectionPlane& plane = *scene.section;
    from_mm += (plane.at_mm - plane.normal.dot(eye_mm)) / plane.normal.dot(direction) * direction;
  }
  const double length_mm = (p_mm - from_mm).norm() - behind_mm;
  return std::ranges::none_of(surfaces_, [&](const Surface& surface) {
    const Drawable& body = scene.drawables[surface.drawable];
    if (!body.is_shown || body.material.opacity < 0.5F) return false;
    geometry::Ray ray;
    ray.from_mm = body.X_world_mesh.inverse() * from_mm;
    ray.direction = body.X_world_mesh.linear().transpose() * direction;
    ray.max_length_mm = length_mm;
    if (!(length_mm > 0.0)) return false;
    if (geometry::ray_distance_mm(surface.mesh, surface.tree, ray) < length_mm) return true;
    if (!scene.section) return false;
    // A filled cut hides all but its own object.
    const bool is_own = own.layer == Layer::bodies && own.parent == body.parent;
    if (surface.is_closed) return !is_own && starts_inside(surface.mesh, surface.tree, ray);
    // The inner side of a sheet.
    ray.from_mm += length_mm * ray.direction;
    ray.direction = -ray.direction;
    return geometry::ray_distance_mm(surface.mesh, surface.tree, ray) < length_mm;
  });
}

void LabelAnchors::place(std::span<ScreenLabel> shown, const Scene& scene, const Shot& shot)
{
  check(shown.size() == points_.size(), "there is a screen label for each label");
  if (surfaces_.empty()) find_surfaces(scene);
  const Eigen::Matrix4d X_clip_world =
      projection(shot.camera) * shot.camera.X_world_camera.inverse().matrix();
  const Eigen::Vector3d eye_mm = shot.camera.X_world_camera.translation();
  const Viewport& view = shot.viewport;
  for (std::size_t i = 0; i < shown.size(); ++i) {
    std::array<std::pair<Eigen::Vector3d, Eigen::Vector2d>, n_points> seen;
    std::size_t n_seen = 0;
    Eigen::Vector2d sum_px(0, 0);
    for (const auto& [k, vertex] : points_[i]) {
      const Drawable& drawable = scene.drawables[k];
      if (!drawable.is_shown) continue;
      const Eigen::Vector3d p_mm = drawable.X_world_mesh * vertex_mm(drawable, vertex);
      const Eigen::Vector4d p_clip = X_clip_world * p_mm.homogeneous();
      const Eigen::Vector2d device = p_clip.head<2>() / p_clip.w();
      if (!(p_clip.w() > 0.0) || device.cwiseAbs().maxCoeff() > 1.0) continue;
      if (!is_visible(scene, drawable, p_mm, eye_mm)) continue;
      const Eigen::Vector2d px(view.x + 0.5 * (1.0 + device.x()) * view.width,
                               view.y + 0.5 * (1.0 - device.y()) * view.height);
      seen.at(n_seen++) = {p_mm, px};
      sum_px += px;
    }
    // In the middle of what is visible.
    double nearest_px = std::numeric_limits<double>::infinity();
    for (const auto& [p_mm, px] : std::span(seen).first(n_seen)) {
      const double from_middle_px = (px - sum_px / static_cast<double>(n_seen)).norm();
      if (from_middle_px >= nearest_px) continue;
      nearest_px = from_middle_px;
      shown[i].anchor_world_mm = p_mm;
      shown[i].anchor_px = px;
    }
    shown[i].is_shown = n_seen > 0;
    shown[i].picture = view;
  }
}

}  // namespace vrda::view
