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
/// A point is behind its own body, or fibres behind any, if that is nearer by more: several times the
/// distance between contact and visual parts and levels of detail, and half the thickness of a band of
/// fibres.
constexpr double behind_mm = 1.0;
constexpr double touching_mm = 0.1;  // of other surfaces
/// Of the moving body's contact part: the outer part of its width, and its upper edge, on a knee.
constexpr double outer_part = 0.2, edge_mm = 14.0;

Eigen::Vector3d vertex_mm(const Drawable& drawable, std::uint32_t vertex)
{
  const std::array<float, 3>& p = drawable.mesh.vertices[vertex].position_mm;
  return {p[0], p[1], p[2]};
}

bool is_side(const std::string& text)
{
  return text == "medial" || text == "lateral";
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

/// Whether fibres of another label than that of `own` are in front of a point.
bool is_behind_fibres(const Scene& scene, const std::vector<std::pair<std::size_t, std::uint32_t>>& own,
                      const Eigen::Vector3d& p_mm, const Eigen::Vector3d& eye_mm)
{
  const Eigen::Vector3d direction = (p_mm - eye_mm).normalized();
  const double length_mm = (p_mm - eye_mm).norm() - touching_mm;
  for (std::size_t k = 0; k < scene.drawables.size(); ++k) {
    const Drawable& band = scene.drawables[k];
    if (band.layer != Layer::ligaments || !band.is_shown || band.material.opacity < 0.5F) continue;
    if (std::ranges::any_of(own, [&](const auto& point) { return point.first == k; })) continue;
    const Pose X_mesh_world = band.X_world_mesh.inverse();
    const Eigen::Vector3d from_mm = X_mesh_world * eye_mm, along = X_mesh_world.linear() * direction;
    const Eigen::Vector3d to_middle_mm = band.box_mm.center() - from_mm;
    if (to_middle_mm.cross(along).norm() > 0.5 * band.box_mm.diagonal().norm()) continue;
    const double at_mm = nearest_hit(band.mesh, from_mm, along);
    const bool is_cut =
        scene.section && at_mm < length_mm && is_removed(*scene.section, eye_mm + at_mm * direction, eye_mm);
    if (at_mm < length_mm && !is_cut) return true;
  }
  return false;
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
    const bool has_side = model.has_compartments && is_side(label.text);
    const double side = !has_side ? 0.0 : label.text == "medial" ? -lateral : lateral;
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
    surfaces_.push_back({std::move(mesh), tree, k, is_solid(body.mesh)});
  }
}

bool LabelAnchors::is_visible(const Scene& scene, std::size_t label, const Drawable& own,
                              const Eigen::Vector3d& p_mm, const Eigen::Vector3d& eye_mm) const
{
  if (scene.section && is_removed(*scene.section, p_mm, eye_mm)) return false;
  const Eigen::Vector3d direction = (p_mm - eye_mm).normalized();
  Eigen::Vector3d from_mm = eye_mm;
  if (scene.section) {
    const SectionPlane& plane = *scene.section;
    from_mm += (plane.at_mm - plane.normal.dot(eye_mm)) / plane.normal.dot(direction) * direction;
  }
  const bool is_fibre = own.layer != Layer::bodies;
  const double distance_mm = (p_mm - from_mm).norm();
  return std::ranges::none_of(surfaces_, [&](const Surface& surface) {
    const Drawable& body = scene.drawables[surface.drawable];
    if (!body.is_shown || body.material.opacity < 0.5F) return false;
    // Of two surfaces in contact the other one hides the point.
    const double nearer_mm = is_fibre || own.parent == body.parent ? behind_mm : -touching_mm;
    const double length_mm = distance_mm - nearer_mm;
    geometry::Ray ray;
    ray.from_mm = body.X_world_mesh.inverse() * from_mm;
    ray.direction = body.X_world_mesh.linear().transpose() * direction;
    ray.max_length_mm = length_mm;
    if (!(length_mm > 0.0)) return false;
    if (geometry::ray_distance_mm(surface.mesh, surface.tree, ray) < length_mm) return true;
    // A filled cut hides all but its own object, of which a side is behind it.
    const bool is_own = !is_fibre && own.parent == body.parent && !is_side(texts_[label]);
    if (surface.is_closed) return scene.section && !is_own && starts_inside(surface.mesh, surface.tree, ray);
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
      if (!is_visible(scene, i, drawable, p_mm, eye_mm)) continue;
      const Eigen::Vector2d px(view.x + 0.5 * (1.0 + device.x()) * view.width,
                               view.y + 0.5 * (1.0 - device.y()) * view.height);
      seen.at(n_seen++) = {p_mm, px};
      sum_px += px;
    }
    // In the middle of what is visible; few points are behind fibres.
    const Eigen::Vector2d middle_px = sum_px / static_cast<double>(n_seen);
    std::ranges::sort(std::span(seen).first(n_seen), {},
                      [&](const auto& point) { return (point.second - middle_px).squaredNorm(); });
    shown[i].is_shown = false;
    for (const auto& [p_mm, px] : std::span(seen).first(n_seen)) {
      if (is_behind_fibres(scene, points_[i], p_mm, eye_mm)) continue;
      shown[i].anchor_world_mm = p_mm;
      shown[i].anchor_px = px;
      shown[i].is_shown = true;
      break;
    }
    shown[i].picture = view;
  }
}

}  // namespace vrda::view
