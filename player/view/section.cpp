#include "view/section.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "core/text.hpp"
#include "view/gl_mesh.hpp"
#include "view/keys.hpp"

namespace vrda::view {
namespace {

constexpr float line_brightness =
    0.3F;  ///< of that of a filled cut, to be seen before the inside of its sheet

/// A line of an outline in the plane, in rows of `row_mm` and mm along them.
struct Edge {
  double from_row = 0.0, to_row = 0.0, from_mm = 0.0, to_mm = 0.0;
  int winding = 1;  ///< of what is above it in the plane's second coordinate

  double at(double row) const { return from_mm + (to_mm - from_mm) * (row - from_row) / (to_row - from_row); }
};

/// Right-handed with the normal. Rows run across `u`, which is as horizontal as possible, so that the edges
/// of a gap between two bones are exact.
struct PlaneAxes {
  Eigen::Vector3d u, v;
};
PlaneAxes axes_of(const Eigen::Vector3d& normal)
{
  const Eigen::Vector3d up = Eigen::Vector3d::UnitY() - normal.y() * normal;
  const Eigen::Vector3d v = up.norm() > 0.1 ? up.normalized() : normal.unitOrthogonal();
  return {v.cross(normal), v};
}

Eigen::Vector3d position_of(const RenderVertex& vertex)
{
  return {vertex.position_mm[0], vertex.position_mm[1], vertex.position_mm[2]};
}

/// Calls `use` with the two ends of the cut of each triangle of a mesh, in rows and mm: first where its
/// border goes down through the plane.
template <class Use>
void for_each_cut(const Drawable& body, const SectionPlane& plane, const PlaneAxes& axes, const Use& use)
{
  const Pose& X = body.X_world_mesh;
  std::vector<double> above_mm(body.mesh.vertices.size());
  const Eigen::Vector3d normal = X.linear().transpose() * plane.normal;
  const double at_mm = plane.at_mm - plane.normal.dot(X.translation());
  for (std::size_t k = 0; k < above_mm.size(); ++k)
    above_mm[k] = normal.dot(position_of(body.mesh.vertices[k])) - at_mm;
  // From the upper to the lower corner, so that the two triangles of a side have equal points.
  const auto crossing = [&](std::uint32_t high, std::uint32_t low) {
    const Eigen::Vector3d a = position_of(body.mesh.vertices[high]), b = position_of(body.mesh.vertices[low]);
    const Eigen::Vector3d p_mm = X * (a + above_mm[high] / (above_mm[high] - above_mm[low]) * (b - a));
    return Eigen::Vector2d(std::round(axes.u.dot(p_mm) / SectionCaps::row_mm), axes.v.dot(p_mm));
  };
  for (std::size_t t = 0; t + 2 < body.mesh.triangles.size(); t += 3) {
    const std::array<std::uint32_t, 3> corner{body.mesh.triangles[t], body.mesh.triangles[t + 1],
                                              body.mesh.triangles[t + 2]};
    const auto is_above = [&](std::size_t k) { return above_mm[corner.at(k % 3)] > 0.0; };
    const int n_above = int{is_above(0)} + int{is_above(1)} + int{is_above(2)};
    if (n_above == 0 || n_above == 3) continue;
    // The side that goes down, then the one that comes up.
    Eigen::Vector2d down, up;
    for (std::size_t k = 0; k < 3; ++k) {
      if (is_above(k) && !is_above(k + 1)) down = crossing(corner.at(k), corner.at((k + 1) % 3));
      if (!is_above(k) && is_above(k + 1)) up = crossing(corner.at((k + 1) % 3), corner.at(k));
    }
    use(down, up);
  }
}

/// The outline of one solid, to be appended to that of its structure.
void add_edges(const Drawable& solid, const SectionPlane& plane, const PlaneAxes& axes,
               std::vector<Edge>& edges)
{
  for_each_cut(solid, plane, axes, [&](const Eigen::Vector2d& down, const Eigen::Vector2d& up) {
    if (down.x() == up.x()) return;
    const bool is_forward = down.x() < up.x();
    const Eigen::Vector2d &first = is_forward ? down : up, &last = is_forward ? up : down;
    edges.push_back({first.x(), last.x(), first.y(), last.y(), is_forward ? 1 : -1});
  });
}

class CapMesh {
 public:
  CapMesh(Drawable& cap, const SectionPlane& plane, const PlaneAxes& axes)
      : mesh_(cap.mesh), plane_(plane), axes_(axes)
  {
    mesh_.vertices.clear();
    mesh_.triangles.clear();
  }
  /// Of two edges between two rows.
  void add(const Edge& low, const Edge& high, double first_row, double last_row)
  {
    const auto corner = [&](const Edge& edge, double row) {
      return Eigen::Vector2d(row * SectionCaps::row_mm, edge.at(row));
    };
    add_quad(
        {corner(low, first_row), corner(high, first_row), corner(low, last_row), corner(high, last_row)});
  }
  /// A line between two points in rows and mm, with square ends, so that a bent line has no gaps.
  void add_line(const Eigen::Vector2d& from, const Eigen::Vector2d& to)
  {
    const Eigen::Vector2d scale(SectionCaps::row_mm, 1.0), a = from.cwiseProduct(scale),
                                                           b = to.cwiseProduct(scale);
    const Eigen::Vector2d along = 0.5 * SectionCaps::line_mm * (b - a).normalized(),
                          across(-along.y(), along.x());
    add_quad({a - along - across, a - along + across, b + along - across, b + along + across});
  }

 private:
  void add_quad(const std::array<Eigen::Vector2d, 4>& corners_mm)
  {
    const auto begin = static_cast<std::uint32_t>(mesh_.vertices.size());
    const Eigen::Vector3f n = plane_.normal.cast<float>();
    for (const Eigen::Vector2d& c : corners_mm) {
      const Eigen::Vector3f p =
          (c.x() * axes_.u + c.y() * axes_.v + plane_.at_mm * plane_.normal).cast<float>();
      mesh_.vertices.push_back({{p.x(), p.y(), p.z()}, {n.x(), n.y(), n.z()}});
    }
    for (const std::uint32_t k : {0U, 2U, 1U, 1U, 2U, 3U}) mesh_.triangles.push_back(begin + k);
  }

  RenderMesh& mesh_;
  const SectionPlane& plane_;
  const PlaneAxes& axes_;
};

/// Fills what the edges wind around, from row to row.
void fill(std::vector<Edge>& edges, CapMesh& cap)
{
  std::vector<double> rows;
  for (const Edge& edge : edges) rows.insert(rows.end(), {edge.from_row, edge.to_row});
  std::ranges::sort(rows);
  rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
  std::ranges::sort(edges, {}, &Edge::from_row);
  std::vector<const Edge*> active;
  auto next = edges.cbegin();
  for (std::size_t k = 0; k + 1 < rows.size(); ++k) {
    const double first = rows[k], last = rows[k + 1], middle = 0.5 * (first + last);
    std::erase_if(active, [&](const Edge* edge) { return edge->to_row <= first; });
    for (; next != edges.cend() && next->from_row <= first; ++next) active.push_back(&*next);
    std::ranges::sort(active, {}, [&](const Edge* edge) { return edge->at(middle); });
    int winding = 0;
    const Edge* low = nullptr;
    for (const Edge* edge : active) {
      if (winding == 0) low = edge;
      winding += edge->winding;
      if (winding == 0) cap.add(*low, *edge, first, last);
    }
  }
}

}  // namespace

const char* name_of(SectionKind kind)
{
  return std::array{"none", "sagittal", "coronal", "axial", "free"}.at(static_cast<std::size_t>(kind));
}

std::optional<SectionPlane> plane_of(const Section& section)
{
  switch (section.kind) {
    case SectionKind::none:
      return std::nullopt;
    case SectionKind::sagittal:
      return SectionPlane{Eigen::Vector3d::UnitZ(), section.at_mm};
    case SectionKind::coronal:
      return SectionPlane{Eigen::Vector3d::UnitX(), section.at_mm};
    case SectionKind::axial:
      return SectionPlane{Eigen::Vector3d::UnitY(), section.at_mm};
    case SectionKind::free:
      return SectionPlane{section.normal, section.at_mm};
  }
  throw InternalError("unknown section");
}

Section parsed_section(const std::string& option, const std::string& text)
{
  const auto refuse = [&] {
    throw InputError({option, "", "\"" + text + "\"",
                      "PLANE=MM, where PLANE is sagittal, coronal, axial or a normal X,Y,Z, such as "
                      "sagittal=0"});
  };
  const std::vector<std::string> parts = split(text, '=');
  if (parts.size() != 2) refuse();
  const auto number = [&](const std::string& part) {
    const std::optional<double> value = parsed_number(part);
    if (!value || !(std::abs(*value) <= 1e5)) refuse();
    return *value;
  };
  Section section;
  section.at_mm = number(parts[1]);
  for (const SectionKind kind : {SectionKind::sagittal, SectionKind::coronal, SectionKind::axial})
    if (parts[0] == name_of(kind)) section.kind = kind;
  if (section.kind != SectionKind::none) return section;
  const std::vector<std::string> normal = split(parts[0], ',');
  if (normal.size() != 3) refuse();
  section.kind = SectionKind::free;
  section.normal = {number(normal[0]), number(normal[1]), number(normal[2])};
  if (section.normal.norm() < 1e-6) refuse();
  section.normal.normalize();
  return section;
}

SectionCaps::SectionCaps(Scene& scene)
{
  const std::size_t n_solids = scene.drawables.size();
  for (std::size_t k = 0; k < n_solids; ++k) {
    if (scene.drawables[k].layer != Layer::bodies) continue;
    const std::string structure = scene.drawables[k].structure;
    auto found = std::ranges::find_if(
        cuts_, [&](const Cut& cut) { return scene.drawables[cut.drawable].structure == structure; });
    if (found == cuts_.end()) {
      const std::size_t drawable = add_layer(scene, Layer::caps, BodyIndex::world, "cut of " + structure);
      scene.drawables[drawable].structure = structure;
      scene.drawables[drawable].material = scene.drawables[k].material;
      scene.drawables[drawable].material.specular = 0.0F;
      scene.drawables[drawable].material.mottling = 0.0F;
      found = cuts_.insert(cuts_.end(), Cut{drawable, {}, {}, {}});
    }
    found->bodies.push_back({k, is_solid(scene.drawables[k].mesh)});
  }
  for (const Cut& cut : cuts_)
    if (std::ranges::none_of(cut.bodies, &Cut::Body::is_solid))
      scene.drawables[cut.drawable].material.colour *= line_brightness;
}

void SectionCaps::update(Scene& scene)
{
  const bool is_new = scene.section != last_;
  last_ = scene.section;
  for (Cut& cut : cuts_) {
    Drawable& cap = scene.drawables[cut.drawable];
    cap.is_shown = false;
    if (!scene.section) continue;
    std::vector<Pose> placed;
    std::vector<bool> is_cut;
    for (const Cut::Body& body : cut.bodies) {
      placed.push_back(scene.drawables[body.drawable].X_world_mesh);
      is_cut.push_back(scene.drawables[body.drawable].is_shown);
      cap.is_shown = cap.is_shown || is_cut.back();
    }
    const auto is_same = [](const Pose& a, const Pose& b) { return a.matrix() == b.matrix(); };
    if (!is_new && is_cut == cut.is_cut && std::ranges::equal(placed, cut.X_world_mesh, is_same)) continue;
    cut.X_world_mesh = placed;
    cut.is_cut = is_cut;
    const PlaneAxes axes = axes_of(scene.section->normal);
    std::vector<Edge> edges;
    CapMesh mesh(cap, *scene.section, axes);
    for (std::size_t i = 0; i < cut.bodies.size(); ++i) {
      if (!is_cut[i]) continue;
      const Drawable& body = scene.drawables[cut.bodies[i].drawable];
      if (cut.bodies[i].is_solid)
        add_edges(body, *scene.section, axes, edges);
      else
        for_each_cut(body, *scene.section, axes, [&](const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
          mesh.add_line(from, to);
        });
    }
    fill(edges, mesh);
    update_box(cap);
    ++cap.revision;
  }
}

}  // namespace vrda::view
