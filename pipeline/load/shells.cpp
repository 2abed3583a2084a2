#include "load/shells.hpp"

#include <algorithm>
#include <numeric>

namespace vrda::load {
namespace {

struct EdgeUse {
  std::int32_t low = 0;
  std::int32_t high = 0;
  bool is_forward = true;
  Eigen::Index triangle = 0;
};

std::vector<EdgeUse> sorted_edges(const Mesh& mesh)
{
  std::vector<EdgeUse> edges;
  edges.reserve(static_cast<std::size_t>(3 * mesh.triangles.rows()));
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const std::int32_t from = mesh.triangles(t, k), to = mesh.triangles(t, (k + 1) % 3);
      edges.push_back({std::min(from, to), std::max(from, to), from < to, t});
    }
  }
  std::sort(edges.begin(), edges.end(), [](const EdgeUse& a, const EdgeUse& b) {
    if (a.low != b.low) return a.low < b.low;
    return a.high != b.high ? a.high < b.high : a.triangle < b.triangle;
  });
  return edges;
}

class Groups {
 public:
  explicit Groups(Eigen::Index n) : parent_(static_cast<std::size_t>(n))
  {
    std::iota(parent_.begin(), parent_.end(), 0);
  }

  Eigen::Index root(Eigen::Index i)
  {
    while (at(i) != i) i = at(i) = at(at(i));
    return i;
  }
  // The root is the smallest index: the first triangle of the group.
  void join(Eigen::Index a, Eigen::Index b)
  {
    a = root(a);
    b = root(b);
    at(std::max(a, b)) = std::min(a, b);
  }

 private:
  Eigen::Index& at(Eigen::Index i) { return parent_[static_cast<std::size_t>(i)]; }
  std::vector<Eigen::Index> parent_;
};

void measure(const Mesh& mesh, Shell& shell)
{
  const Eigen::Vector3d origin = corners(mesh, shell.triangles.front())[0];
  Eigen::AlignedBox3d box;
  double six_volumes = 0.0;
  for (const Eigen::Index t : shell.triangles) {
    const auto [a, b, c] = corners(mesh, t);
    six_volumes += (a - origin).dot((b - origin).cross(c - origin));
    box.extend(a).extend(b).extend(c);
  }
  shell.signed_volume = six_volumes / 6.0;
  shell.box = {box.min(), box.max()};
}

bool box_contains(const Box& outer, const Box& inner)
{
  return (outer.min_mm.array() < inner.min_mm.array()).all() &&
         (inner.max_mm.array() < outer.max_mm.array()).all();
}

// Whether the ray hits the triangle (Moeller and Trumbore 1997, J Graphics Tools 2:21-28).
bool ray_hits(const Eigen::Vector3d& from, const Eigen::Vector3d& along,
              const std::array<Eigen::Vector3d, 3>& corner)
{
  const Eigen::Vector3d e1 = corner[1] - corner[0], e2 = corner[2] - corner[0];
  const Eigen::Vector3d p = along.cross(e2);
  const double det = e1.dot(p);
  if (det == 0.0) return false;
  const Eigen::Vector3d s = from - corner[0];
  const double u = s.dot(p) / det;
  const Eigen::Vector3d q = s.cross(e1);
  const double v = along.dot(q) / det;
  return u >= 0.0 && v >= 0.0 && u + v <= 1.0 && e2.dot(q) / det > 0.0;
}

bool shell_contains(const Mesh& mesh, const Shell& outer, const Shell& inner)
{
  if (!box_contains(outer.box, inner.box)) return false;
  const Eigen::Vector3d from = corners(mesh, inner.triangles.front())[0];
  // An arbitrary direction, unlikely to be parallel to a face or an axis of a mesh.
  const Eigen::Vector3d along(0.8137, 0.4683, 0.3441);
  bool is_inside = false;
  for (const Eigen::Index t : outer.triangles) {
    if (ray_hits(from, along, corners(mesh, t))) is_inside = !is_inside;
  }
  return is_inside;
}

}  // namespace

std::vector<Shell> shells_of(const Mesh& mesh)
{
  const std::vector<EdgeUse> edges = sorted_edges(mesh);
  Groups groups(mesh.triangles.rows());
  std::vector<Eigen::Index> open_triangles;
  for (std::size_t first = 0; first < edges.size();) {
    std::size_t last = first;
    int n_forward = 0;
    for (;
         last < edges.size() && edges[last].low == edges[first].low && edges[last].high == edges[first].high;
         ++last) {
      n_forward += edges[last].is_forward ? 1 : 0;
      groups.join(edges[first].triangle, edges[last].triangle);
    }
    if (last - first != 2 || n_forward != 1) open_triangles.push_back(edges[first].triangle);
    first = last;
  }
  std::vector<Shell> shells;
  std::vector<std::size_t> shell_of(static_cast<std::size_t>(mesh.triangles.rows()));
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    const Eigen::Index root = groups.root(t);
    if (root == t) shells.emplace_back();
    const std::size_t shell = root == t ? shells.size() - 1 : shell_of[static_cast<std::size_t>(root)];
    shell_of[static_cast<std::size_t>(t)] = shell;
    shells[shell].triangles.push_back(t);
  }
  for (const Eigen::Index t : open_triangles) shells[shell_of[static_cast<std::size_t>(t)]].is_closed = false;
  for (Shell& shell : shells) measure(mesh, shell);
  return shells;
}

std::vector<bool> inward_shells(const Mesh& mesh, const std::vector<Shell>& shells)
{
  const auto is_negative = [](const Shell& shell) { return shell.is_closed && shell.signed_volume < 0.0; };
  std::vector<bool> is_inward(shells.size(), false);
  // Usual case: no negative volume, so no shell is reversed.
  if (std::none_of(shells.begin(), shells.end(), is_negative)) return is_inward;
  for (std::size_t i = 0; i < shells.size(); ++i) {
    if (!shells[i].is_closed) continue;
    // The outermost enclosing shell is the largest that contains this one.
    std::size_t outermost = i;
    for (std::size_t k = 0; k < shells.size(); ++k) {
      const bool is_larger = std::abs(shells[k].signed_volume) > std::abs(shells[outermost].signed_volume);
      if (shells[k].is_closed && is_larger && shell_contains(mesh, shells[k], shells[i])) outermost = k;
    }
    is_inward[i] = shells[outermost].signed_volume < 0.0;
  }
  return is_inward;
}

}  // namespace vrda::load
