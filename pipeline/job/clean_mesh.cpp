#include "job/clean_mesh.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

#include "core/bucket_sort.hpp"
#include "core/units.hpp"

namespace vrda::job {
namespace {

// The corners of a face after welding, without consecutive duplicates.
std::vector<std::int32_t> distinct_corners(const std::vector<std::int32_t>& of_raw,
                                           const std::int32_t* corner, std::int32_t n)
{
  std::vector<std::int32_t> corners;
  for (std::int32_t k = 0; k < n; ++k) {
    const std::int32_t v = of_raw[static_cast<std::size_t>(corner[k])];
    if (corners.empty() || corners.back() != v) corners.push_back(v);
  }
  while (corners.size() > 1 && corners.front() == corners.back()) corners.pop_back();
  return corners;
}

using Triangle = std::array<std::int32_t, 3>;

bool has_area(const Points& vertices, const Triangle& t)
{
  const Eigen::Vector3d a = vertices.row(t[0]), b = vertices.row(t[1]), c = vertices.row(t[2]);
  return (b - a).cross(c - a).squaredNorm() > 0.0;
}

// Polygons by their corners from the smallest on, in the direction of its smaller neighbour; with the
// triangles of the first one. A copy must not be divided along other diagonals.
class Polygons {
 public:
  const std::vector<Triangle>& triangles_of(const std::vector<std::int32_t>& face, const Points& vertices)
  {
    std::vector<std::int32_t> key = face;
    std::rotate(key.begin(), std::min_element(key.begin(), key.end()), key.end());
    const bool is_reversed = key.back() < key[1];
    if (is_reversed) std::reverse(key.begin() + 1, key.end());
    const auto [at, is_new] = first_.try_emplace(std::move(key), First{is_reversed, {}});
    if (is_new) at->second.triangles = triangulated(face, vertices);
    triangles_ = at->second.triangles;
    if (at->second.is_reversed == is_reversed) return triangles_;
    for (Triangle& triangle : triangles_) std::swap(triangle[1], triangle[2]);
    return triangles_;
  }

  static std::vector<Triangle> triangulated(const std::vector<std::int32_t>& face, const Points& vertices)
  {
    Points corners(static_cast<Eigen::Index>(face.size()), 3);
    for (std::size_t k = 0; k < face.size(); ++k)
      corners.row(static_cast<Eigen::Index>(k)) = vertices.row(face[k]);
    std::vector<Triangle> triangles = triangulate(corners);
    for (Triangle& triangle : triangles) {
      for (std::int32_t& corner : triangle) corner = face[static_cast<std::size_t>(corner)];
    }
    return triangles;
  }

 private:
  struct First {
    bool is_reversed = false;
    std::vector<Triangle> triangles;
  };
  std::map<std::vector<std::int32_t>, First> first_;
  std::vector<Triangle> triangles_;
};

std::vector<Triangle> triangles_of(const RawMesh& raw, const WeldedVertices& merged, CleanMesh& counts)
{
  std::vector<Triangle> kept;
  Polygons polygons;
  std::size_t first = 0;
  for (const std::int32_t size : raw.size) {
    const std::vector<std::int32_t> face =
        distinct_corners(merged.index_of_raw, raw.corner.data() + first, size);
    first += static_cast<std::size_t>(size);
    const std::size_t n_before = kept.size();
    const auto keep = [&](const std::vector<Triangle>& triangles) {
      for (const Triangle& triangle : triangles) {
        if (has_area(merged.vertices, triangle)) kept.push_back(triangle);
      }
    };
    if (face.size() == 3) keep(Polygons::triangulated(face, merged.vertices));
    if (face.size() > 3) keep(polygons.triangles_of(face, merged.vertices));
    // A polygon of n corners has n - 2 triangles. If none is kept, one degenerate face is counted.
    const std::size_t n_kept = kept.size() - n_before;
    const std::size_t n_lost = n_kept == 0 ? 1 : face.size() - 2 - n_kept;
    counts.n_degenerate += static_cast<Eigen::Index>(n_lost);
    if (n_lost > 0) counts.degenerate_at.emplace_back(merged.vertices.row(face.front()));
  }
  return kept;
}

Triangles matrix_of(const std::vector<Triangle>& triangles)
{
  Triangles matrix(static_cast<Eigen::Index>(triangles.size()), 3);
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k)
      matrix(static_cast<Eigen::Index>(t), static_cast<Eigen::Index>(k)) = triangles[t][k];
  }
  return matrix;
}

// Vertices in the order of first use; unused vertices are removed.
Mesh renumbered(const Mesh& mesh, Side side)
{
  constexpr std::int32_t unused = -1;
  std::vector<std::int32_t> place(static_cast<std::size_t>(mesh.vertices_mm.rows()), unused);
  const std::array<int, 3> corner_order = side == Side::right ? std::array{0, 1, 2} : std::array{0, 2, 1};
  Mesh out = mesh;
  std::int32_t n_used = 0;
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    for (const int k : corner_order) {
      const std::int32_t from = mesh.triangles(t, k);
      std::int32_t& to = place[static_cast<std::size_t>(from)];
      if (to == unused) {
        to = n_used++;
        out.vertices_mm.row(to) = mesh.vertices_mm.row(from);
        if (mesh.normals.rows() > 0) out.normals.row(to) = mesh.normals.row(from);
      }
      out.triangles(t, k) = to;
    }
  }
  out.vertices_mm.conservativeResize(n_used, 3);
  if (mesh.normals.rows() > 0) out.normals.conservativeResize(n_used, 3);
  return out;
}

// Reverses shells to point outward and lists the small ones.
void survey_shells(CleanMesh& out, Mesh& mesh, Winding winding)
{
  const std::vector<Shell> shells = shells_of(mesh);
  const std::vector<std::size_t> outermost = outermost_shells(mesh, shells);
  out.small_shells = small_shells(shells, outermost);
  for (std::size_t s = 0; s < shells.size(); ++s) {
    const Shell& shell = shells[s];
    out.fold_at.insert(out.fold_at.end(), shell.fold_at.begin(), shell.fold_at.end());
    out.needle_at.insert(out.needle_at.end(), shell.needle_at.begin(), shell.needle_at.end());
    if (!shell.has_inside) out.has_sheet = true;
    const bool is_reversed =
        shell.has_inside ? shells[outermost[s]].signed_volume < 0.0 : winding == Winding::inward;
    if (!is_reversed) continue;
    out.was_flipped = true;
    for (const Eigen::Index t : shell.triangles) std::swap(mesh.triangles(t, 1), mesh.triangles(t, 2));
  }
}

// The file's normals as outward unit vectors; computed normals if any of the file's is zero or not finite.
Points outward_normals(const Mesh& mesh)
{
  Points computed = vertex_normals(mesh);
  Points normals = mesh.normals;
  for (Eigen::Index v = 0; v < normals.rows(); ++v) {
    const double length = normals.row(v).norm();
    if (!std::isfinite(length) || length == 0.0) return computed;
    normals.row(v) /= normals.row(v).dot(computed.row(v)) < 0.0 ? -length : length;
  }
  return normals.rows() == 0 ? computed : normals;
}

}  // namespace

CleanMesh clean_mesh(const RawMesh& raw, Winding winding, Side side)
{
  CleanMesh out;
  WeldedVertices merged = weld_vertices(raw);
  out.n_welded = raw.vertices.rows() - merged.vertices.rows();
  Mesh mesh;
  const std::vector<Triangle> all = triangles_of(raw, merged, out);
  const std::vector<Triangle> each_once = without_copies(all);
  out.n_identical = static_cast<Eigen::Index>(all.size() - each_once.size());
  mesh.triangles = matrix_of(each_once);
  mesh.vertices_mm = std::move(merged.vertices);
  mesh.normals = std::move(merged.normal_sums);
  survey_shells(out, mesh, winding);
  out.mesh = renumbered(mesh, side);
  out.mesh.normals = outward_normals(out.mesh);
  return out;
}

// Merges vertices with equal coordinates.

namespace {

std::size_t hash_of(const Eigen::RowVector3d& p)
{
  std::uint64_t hash = 0;
  for (const double x : p) {
    hash = (hash ^ std::bit_cast<std::uint64_t>(x + 0.0)) * 0x9E3779B97F4A7C15U;  // -0 is 0
    hash ^= hash >> 32U;
  }
  return hash;
}

// For each vertex the first one with its coordinates, by a table of rows with linear probing.
std::vector<std::int32_t> first_of_equal(const Points& vertices)
{
  const auto n = static_cast<std::size_t>(vertices.rows());
  const std::size_t mask = std::bit_ceil(2 * n + 1) - 1;
  std::vector<std::int32_t> table(mask + 1, -1), first(n);
  for (std::size_t v = 0; v < n; ++v) {
    const auto row = static_cast<Eigen::Index>(v);
    std::size_t slot = hash_of(vertices.row(row)) & mask;
    while (table[slot] >= 0 && vertices.row(table[slot]) != vertices.row(row)) slot = (slot + 1) & mask;
    if (table[slot] < 0) table[slot] = static_cast<std::int32_t>(v);
    first[v] = table[slot];
  }
  return first;
}

}  // namespace

WeldedVertices weld_vertices(const RawMesh& raw)
{
  const Eigen::Index n = raw.vertices.rows();
  const std::vector<std::int32_t> earliest = first_of_equal(raw.vertices);
  WeldedVertices out;
  out.index_of_raw.resize(earliest.size());
  out.vertices.resize(n, 3);
  out.normal_sums = Points::Zero(raw.normals.rows(), 3);
  std::int32_t n_merged = 0;
  for (Eigen::Index v = 0; v < n; ++v) {
    const auto place = static_cast<std::size_t>(v);
    const bool is_first = earliest[place] == v;
    out.index_of_raw[place] =
        is_first ? n_merged++ : out.index_of_raw[static_cast<std::size_t>(earliest[place])];
    // Adding zero turns -0 into 0.
    if (is_first) out.vertices.row(out.index_of_raw[place]) = raw.vertices.row(v).array() + 0.0;
    if (raw.normals.rows() > 0) out.normal_sums.row(out.index_of_raw[place]) += raw.normals.row(v);
  }
  out.vertices.conservativeResize(n_merged, 3);
  if (raw.normals.rows() > 0) out.normal_sums.conservativeResize(n_merged, 3);
  return out;
}

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
  core::sort_by_row(
      edges, static_cast<std::size_t>(mesh.vertices_mm.rows()), [](const EdgeUse& e) { return e.low; },
      [](const EdgeUse& a, const EdgeUse& b) {
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

// How an open edge may end: nothing on the other side, or faces that do not match.
struct EdgeFaults {
  Eigen::Index n_edges = 0, n_inconsistent = 0;
};

// The area vectors of a closed surface cancel out. What remains is the area of its holes: at most 3 % of the
// whole for bones with a cut shaft, and at least 35 % for the sheets of cartilage of real knees.
constexpr double largest_open_share = 0.15;
// A face with reversed winding has three inconsistent edges; with random windings half of the edges are.
constexpr double largest_inconsistent_share = 0.2;
// Normals of two faces of a fold are 165 degrees apart or more; at the rims of real menisci and cartilage at
// most 160.
constexpr double fold_cosine = -0.966;
// Height of a needle over its longest edge.
constexpr double needle_share = 0.01;

Eigen::Vector3d doubled_area(const Mesh& mesh, Eigen::Index t)
{
  const auto [a, b, c] = corners(mesh, t);
  return (b - a).cross(c - a);
}

bool is_fold(const Mesh& mesh, Eigen::Index t, Eigen::Index other)
{
  const Eigen::Vector3d a = doubled_area(mesh, t), b = doubled_area(mesh, other);
  return a.dot(b) < fold_cosine * std::sqrt(a.squaredNorm() * b.squaredNorm());
}

void measure(const Mesh& mesh, const EdgeFaults& faults, Shell& shell)
{
  Eigen::AlignedBox3d box;
  for (const Eigen::Index t : shell.triangles) {
    for (const Eigen::Vector3d& corner : corners(mesh, t)) box.extend(corner);
  }
  shell.box = {box.min(), box.max()};
  const Eigen::Vector3d origin = box.center();
  Eigen::Vector3d area_vector = Eigen::Vector3d::Zero();
  double six_volumes = 0.0, area = 0.0;
  for (const Eigen::Index t : shell.triangles) {
    const auto [a, b, c] = corners(mesh, t);
    const Eigen::Vector3d doubled = (b - a).cross(c - a);
    six_volumes += (a - origin).dot(doubled);
    area_vector += doubled;
    area += doubled.norm();
    const double longest_sq = std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()});
    if (doubled.norm() < needle_share * longest_sq) shell.needle_at.push_back(a);
  }
  shell.signed_volume = six_volumes / 6.0;
  const bool is_whole = area_vector.norm() <= largest_open_share * area;
  const bool is_consistent = static_cast<double>(faults.n_inconsistent) <=
                             largest_inconsistent_share * static_cast<double>(faults.n_edges);
  shell.has_inside = shell.is_closed || (is_whole && is_consistent);
}

bool box_contains(const Box& outer, const Box& inner)
{
  return (outer.min_mm.array() <= inner.min_mm.array()).all() &&
         (inner.max_mm.array() <= outer.max_mm.array()).all();
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

// Of full turns of the surface around a point: 1 inside and 0 outside a closed surface; between them near the
// holes of another.
// Source: van Oosterom and Strackee (1983), IEEE Trans Biomed Eng 30:125-126.
double winding_number(const Mesh& mesh, const Shell& shell, const Eigen::Vector3d& p)
{
  double sum_rad = 0.0;
  for (const Eigen::Index t : shell.triangles) {
    const auto [ca, cb, cc] = corners(mesh, t);
    const Eigen::Vector3d a = ca - p, b = cb - p, c = cc - p;
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    sum_rad +=
        2.0 * arc_tangent2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  return std::abs(sum_rad) / (4.0 * pi);
}

bool is_inside(const Mesh& mesh, const Shell& outer, const Eigen::Vector3d& p)
{
  if (!outer.is_closed) return winding_number(mesh, outer, p) > 0.5;
  // An arbitrary direction, unlikely to be parallel to a face or an axis of a mesh.
  const Eigen::Vector3d along(0.8137, 0.4683, 0.3441);
  bool is_odd = false;
  for (const Eigen::Index t : outer.triangles) {
    if (ray_hits(p, along, corners(mesh, t))) is_odd = !is_odd;
  }
  return is_odd;
}

// By a corner of the inner shell; in an outer shell with holes by five, of which one may be in a hole.
bool shell_contains(const Mesh& mesh, const Shell& outer, const Shell& inner)
{
  if (!box_contains(outer.box, inner.box)) return false;
  const std::size_t n = outer.is_closed ? 1 : 5;
  std::size_t n_inside = 0;
  for (std::size_t k = 0; k < n; ++k) {
    const Eigen::Index t = inner.triangles[k * inner.triangles.size() / n];
    n_inside += is_inside(mesh, outer, corners(mesh, t)[0]) ? 1 : 0;
  }
  return n_inside + n / 5 >= n;
}

}  // namespace

std::vector<Shell> shells_of(const Mesh& mesh)
{
  const std::vector<EdgeUse> edges = sorted_edges(mesh);
  Groups groups(mesh.triangles.rows());
  std::vector<std::pair<Eigen::Index, std::size_t>>
      uses;  // a triangle of each faulty edge, number of its faces
  std::vector<std::pair<Eigen::Index, std::int32_t>> folds;  // a triangle and a vertex of each
  for (std::size_t first = 0; first < edges.size();) {
    std::size_t last = first;
    int n_forward = 0;
    for (;
         last < edges.size() && edges[last].low == edges[first].low && edges[last].high == edges[first].high;
         ++last) {
      n_forward += edges[last].is_forward ? 1 : 0;
      groups.join(edges[first].triangle, edges[last].triangle);
    }
    if (last - first != 2 || n_forward != 1) {
      uses.emplace_back(edges[first].triangle, last - first);
    } else if (is_fold(mesh, edges[first].triangle, edges[first + 1].triangle)) {
      folds.emplace_back(edges[first].triangle, edges[first].low);
    }
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
  std::vector<EdgeFaults> faults(shells.size());
  for (const auto& [t, n_faces] : uses) {
    const std::size_t shell = shell_of[static_cast<std::size_t>(t)];
    shells[shell].is_closed = false;
    if (n_faces > 1) ++faults[shell].n_inconsistent;
  }
  for (const auto& [t, v] : folds)
    shells[shell_of[static_cast<std::size_t>(t)]].fold_at.emplace_back(mesh.vertices_mm.row(v));
  for (std::size_t s = 0; s < shells.size(); ++s) {
    faults[s].n_edges = static_cast<Eigen::Index>(3 * shells[s].triangles.size() / 2);
    measure(mesh, faults[s], shells[s]);
  }
  return shells;
}

std::vector<std::size_t> outermost_shells(const Mesh& mesh, const std::vector<Shell>& shells)
{
  constexpr std::size_t most_outer = 100;  // of thousands of pieces, only the largest can enclose others
  std::vector<std::size_t> outer;
  for (std::size_t s = 0; s < shells.size(); ++s) {
    if (shells[s].has_inside) outer.push_back(s);
  }
  const auto volume = [&](std::size_t s) { return std::abs(shells[s].signed_volume); };
  std::stable_sort(outer.begin(), outer.end(),
                   [&](std::size_t a, std::size_t b) { return volume(a) > volume(b); });
  outer.resize(std::min(outer.size(), most_outer));
  std::vector<std::size_t> outermost(shells.size());
  for (std::size_t s = 0; s < shells.size(); ++s) {
    const auto found = std::find_if(outer.begin(), outer.end(), [&](std::size_t o) {
      return o != s && (!shells[s].has_inside || volume(o) > volume(s)) &&
             shell_contains(mesh, shells[o], shells[s]);
    });
    outermost[s] = found == outer.end() ? s : *found;
  }
  return outermost;
}

std::vector<std::vector<Eigen::Index>> small_shells(const std::vector<Shell>& shells,
                                                    const std::vector<std::size_t>& outermost)
{
  constexpr double small_share = 0.2;  // an epiphysis, a fibula or a piece of cartilage has more
  const auto size = [](const Shell& shell) { return (shell.box.max_mm - shell.box.min_mm).norm(); };
  double largest = 0.0;
  for (const Shell& shell : shells) largest = std::max(largest, size(shell));
  std::vector<std::vector<Eigen::Index>> small;
  for (std::size_t s = 0; s < shells.size(); ++s) {
    if (outermost[s] == s && size(shells[s]) <= small_share * largest) small.push_back(shells[s].triangles);
  }
  return small;
}

Mesh outer_surface(const Mesh& mesh)
{
  const std::vector<Shell> shells = shells_of(mesh);
  const std::vector<std::size_t> outermost = outermost_shells(mesh, shells);
  std::vector<std::vector<Eigen::Index>> enclosed;
  for (std::size_t s = 0; s < shells.size(); ++s) {
    if (outermost[s] != s) enclosed.push_back(shells[s].triangles);
  }
  return enclosed.empty() ? mesh : compacted(mesh, others_than(mesh, enclosed));
}

std::vector<Eigen::Index> others_than(const Mesh& mesh, const std::vector<std::vector<Eigen::Index>>& lists)
{
  std::vector<bool> is_listed(static_cast<std::size_t>(mesh.triangles.rows()), false);
  for (const std::vector<Eigen::Index>& list : lists) {
    for (const Eigen::Index t : list) is_listed[static_cast<std::size_t>(t)] = true;
  }
  std::vector<Eigen::Index> others;
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    if (!is_listed[static_cast<std::size_t>(t)]) others.push_back(t);
  }
  return others;
}

Mesh compacted(const Mesh& mesh, const std::vector<Eigen::Index>& kept)
{
  Mesh out = select_triangles(mesh, kept);
  std::vector<std::int32_t> place(static_cast<std::size_t>(mesh.vertices_mm.rows()), -1);
  for (const std::int32_t v : out.triangles.reshaped()) place[static_cast<std::size_t>(v)] = 0;
  std::vector<Eigen::Index> rows;
  for (std::size_t v = 0; v < place.size(); ++v) {
    if (place[v] < 0) continue;
    place[v] = static_cast<std::int32_t>(rows.size());
    rows.push_back(static_cast<Eigen::Index>(v));
  }
  for (std::int32_t& v : out.triangles.reshaped()) v = place[static_cast<std::size_t>(v)];
  out.vertices_mm = mesh.vertices_mm(rows, Eigen::all);
  if (mesh.normals.rows() > 0) out.normals = mesh.normals(rows, Eigen::all);
  return out;
}

}  // namespace vrda::job
