#include "proximity/directional_gap.hpp"

#include <algorithm>
#include <array>

namespace vrda {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
// Unit normal's height below which a face projects to a sliver (DESIGN.md 5.2).
constexpr double vertical_normal = 1e-6;
// Barycentric slack: a vertex over a shared edge must belong to at least one of both faces.
constexpr double edge_slack = 1e-12;
// Sine between projected edges below which their crossing is left to the vertices over faces.
constexpr double parallel_sine = 1e-12;

// y component of (b - a) x (c - a): twice the signed area of the projection.
double projected_area(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c)
{
  return (b.z() - a.z()) * (c.x() - a.x()) - (b.x() - a.x()) * (c.z() - a.z());
}

struct Facing {
  double projected = 0.0;  // twice the projected area, signed as the normal's y
  bool is_vertical = true;
};

Facing facing_of(const Corners& t)
{
  Facing facing;
  facing.projected = projected_area(t[0], t[1], t[2]);
  const double doubled = (t[1] - t[0]).cross(t[2] - t[0]).norm();
  facing.is_vertical = !(std::abs(facing.projected) >= vertical_normal * doubled) || doubled == 0.0;
  return facing;
}

// Keeps the smallest travel that counts.
struct Least {
  GapKind kind = GapKind::from_here;
  double travel_mm = infinity;
  void offer(double travel)
  {
    if (kind == GapKind::from_here && travel < 0.0) return;
    travel_mm = std::min(travel_mm, travel);
  }
};

// Height of the face over p's projection, if p lies over it.
bool height_over(const Corners& face, double projected, const Eigen::Vector3d& p, double& height)
{
  const double u = projected_area(p, face[1], face[2]) / projected;
  const double v = projected_area(face[0], p, face[2]) / projected;
  const double w = projected_area(face[0], face[1], p) / projected;
  if (u < -edge_slack || v < -edge_slack || w < -edge_slack) return false;
  height = u * face[0].y() + v * face[1].y() + w * face[2].y();
  return true;
}

void offer_edges(const Corners& r, const Corners& m, Least& least)
{
  for (std::size_t i = 0; i < 3; ++i) {
    const Eigen::Vector3d& a = r[i];
    const Eigen::Vector3d d = r[(i + 1) % 3] - a;
    for (std::size_t k = 0; k < 3; ++k) {
      const Eigen::Vector3d& b = m[k];
      const Eigen::Vector3d e = m[(k + 1) % 3] - b;
      const double cross = d.x() * e.z() - d.z() * e.x();
      const double scale = (std::abs(d.x()) + std::abs(d.z())) * (std::abs(e.x()) + std::abs(e.z()));
      if (std::abs(cross) <= parallel_sine * scale) continue;
      const double wx = b.x() - a.x(), wz = b.z() - a.z();
      const double s = (wx * e.z() - wz * e.x()) / cross;
      const double t = (wx * d.z() - wz * d.x()) / cross;
      if (s < -edge_slack || s > 1.0 + edge_slack || t < -edge_slack || t > 1.0 + edge_slack) continue;
      least.offer((a.y() + s * d.y()) - (b.y() + t * e.y()));
    }
  }
}

double travel_of(const Corners& r, const Corners& m, GapKind kind)
{
  const Facing facing_r = facing_of(r);
  const Facing facing_m = facing_of(m);
  // Coming from afar only a face that looks down can be met, and only by one that looks up.
  if (kind == GapKind::from_afar && (facing_r.is_vertical || facing_m.is_vertical ||
                                     facing_r.projected > 0.0 || facing_m.projected < 0.0)) {
    return infinity;
  }
  Least least{kind};
  double height = 0.0;
  if (!facing_r.is_vertical) {
    for (const Eigen::Vector3d& p : m) {
      if (height_over(r, facing_r.projected, p, height)) least.offer(height - p.y());
    }
  }
  if (!facing_m.is_vertical) {
    for (const Eigen::Vector3d& p : r) {
      if (height_over(m, facing_m.projected, p, height)) least.offer(p.y() - height);
    }
  }
  offer_edges(r, m, least);
  return least.travel_mm;
}

bool projections_overlap(const BoxTree::Node& r, const BoxTree::Node& m)
{
  return r.min_mm[0] <= m.max_mm[0] && m.min_mm[0] <= r.max_mm[0] && r.min_mm[2] <= m.max_mm[2] &&
         m.min_mm[2] <= r.max_mm[2];
}

// One dual-tree branch and bound.
class Query {
 public:
  Query(const TreeMesh& reference, const Mesh& moving_mesh, const BoxTree& moving, const MovingPose& pose,
        GapKind kind)
      : reference_(reference), moving_mesh_(moving_mesh), moving_(moving), place_(pose), kind_(kind)
  {
  }

  void try_pair(const TrianglePair& pair)
  {
    if (pair.reference < 0 || pair.moving < 0) return;
    offer(pair);
  }

  Gap run()
  {
    push({0, 0});
    while (!tasks_.empty()) {
      const Task task = tasks_.back();
      tasks_.pop_back();
      // Equal bounds are still walked, so that ties end in the smallest pair whatever the hint.
      if (task.bound > best_.travel_mm) continue;
      descend(task);
    }
    return best_;
  }

 private:
  struct Task {
    std::int32_t reference = 0;
    std::int32_t moving = 0;
    double bound = 0.0;
  };

  void push(Task task)
  {
    const BoxTree::Node& r = reference_.tree.nodes()[static_cast<std::size_t>(task.reference)];
    const BoxTree::Node m = place_(moving_.nodes()[static_cast<std::size_t>(task.moving)]);
    if (!projections_overlap(r, m)) return;
    task.bound = r.min_mm[1] - m.max_mm[1];
    if (kind_ == GapKind::from_here) {
      if (r.max_mm[1] < m.min_mm[1]) return;
      task.bound = std::max(task.bound, 0.0);
    }
    if (task.bound <= best_.travel_mm) tasks_.push_back(task);
  }

  void descend(const Task& task)
  {
    const BoxTree::Node& r = reference_.tree.nodes()[static_cast<std::size_t>(task.reference)];
    const BoxTree::Node& m = moving_.nodes()[static_cast<std::size_t>(task.moving)];
    if (r.is_leaf() && m.is_leaf()) {
      for (std::int32_t i = r.first; i < r.first + r.count; ++i) {
        for (std::int32_t k = m.first; k < m.first + m.count; ++k) {
          offer({reference_.tree.order()[static_cast<std::size_t>(i)],
                 moving_.order()[static_cast<std::size_t>(k)]});
        }
      }
      return;
    }
    const double size_r = r.max_mm[0] - r.min_mm[0] + r.max_mm[2] - r.min_mm[2];
    const double size_m = m.max_mm[0] - m.min_mm[0] + m.max_mm[2] - m.min_mm[2];
    const std::size_t before = tasks_.size();
    if (m.is_leaf() || (!r.is_leaf() && size_r >= size_m)) {
      push({task.reference + 1, task.moving});
      push({r.first, task.moving});
    } else {
      push({task.reference, task.moving + 1});
      push({task.reference, m.first});
    }
    // The nearer child on top.
    if (tasks_.size() == before + 2 && tasks_[before].bound < tasks_[before + 1].bound) {
      std::swap(tasks_[before], tasks_[before + 1]);
    }
  }

  void offer(const TrianglePair& pair)
  {
    const double travel = travel_of(corners(reference_.mesh, pair.reference),
                                    place_(corners(moving_mesh_, pair.moving)), kind_);
    if (travel < best_.travel_mm || (travel == best_.travel_mm && travel < infinity && pair < best_.pair)) {
      best_ = {travel, pair};
    }
  }

  // The bounds of descend() for the two triangles alone: spares most pairs of a leaf the exact kernel.
  bool can_improve(const Corners& r, const Corners& m) const
  {
    const Extent rx = extent(r, 0), mx = extent(m, 0), rz = extent(r, 2), mz = extent(m, 2);
    if (rx.least > mx.most || mx.least > rx.most || rz.least > mz.most || mz.least > rz.most) return false;
    const Extent ry = extent(r, 1), my = extent(m, 1);
    if (kind_ == GapKind::from_here && ry.most < my.least) return false;
    return ry.least - my.most <= best_.travel_mm;
  }

  const TreeMesh& reference_;
  const Mesh& moving_mesh_;
  const BoxTree& moving_;
  Placement place_;
  GapKind kind_;
  Gap best_;
  std::vector<Task> tasks_;
};

}  // namespace

double pair_travel_mm(const Corners& reference, const Corners& moving, GapKind kind)
{
  return travel_of(reference, moving, kind);
}

Gap directional_gap(const TreeMesh& reference, const Mesh& moving_mesh, const BoxTree& moving,
                    const MovingPose& pose, const GapOptions& options)
{
  if (reference.tree.is_empty() || moving.is_empty()) return {};
  Query query(reference, moving_mesh, moving, pose, options.kind);
  query.try_pair(options.hint);
  return query.run();
}

}  // namespace vrda
